"""What is known of objects once a frame has shown them, or has not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..base.config import TrackingConfig
from ..geometry.transforms import Array
from ..model.found import Detection
from .existence import Existence
from .motion import Bodies, Counts, Flags, MotionModel, MotionState, calmed
from .names import remembered
from .sightings import Sightings
from .tracks import Tracks
from .turns import Turns

_GROWN = 2.0  # what grows by a share moves at its rim by half of that share of its size
_SEEN_IF_HIDDEN = 0.2  # share of objects that are found though something stands before their middle


def begun(
    found: Sequence[Detection], s: Sightings, likely: Array, model: MotionModel, config: TrackingConfig
) -> Tracks:
    """Objects that nobody has seen before. :param likely: (D,) probabilities that they are there."""
    if not found:
        return Tracks.none()
    n = len(found)
    return Tracks(
        tuple(d.object for d in found),
        (None,) * n,
        tuple(d.identity for d in found),
        tuple(found),
        MotionState.first_seen(s.place, s.noise, s.unit, model),
        s.theta,
        _bodies(s, model, config),
        s.placed,
        Existence.of(likely),
        np.zeros(n),
        np.zeros(n, np.intp),
        s.placed.astype(np.intp),
        Turns.of(found, config.sightings),
        np.zeros(n),
    )


def followed(
    tracks: Tracks,
    found: Sequence[Detection],
    sightings: Sightings,
    row_of: Mapping[int, int],
    doubtful: Mapping[int, float],
    goes_on: float,
    dt_s: float,
    size: tuple[int, int],
    model: MotionModel,
    config: TrackingConfig,
) -> Tracks:
    """:param row_of: of what was found the track that each continues.
    :param doubtful: of tracks that nothing continues how probable something is in the place of each.
    :param goes_on: probability that the frame goes on from the one before. :param size: (width, height) of the image.
    """
    if not len(tracks):
        return tracks
    detections, rows = list(row_of), np.array(list(row_of.values()), int)
    s = sightings[detections]
    seen = tracks.image[rows].seen(s.place, s.noise)
    image = tracks.image.replaced(rows, replace(seen, unit=s.unit))
    new = np.minimum(_moved(image, tracks.age_s, rows, s) / config.existence.anew, 1.0)
    # one of several parts alone is the same patch from frame to frame, and moves in the image where the camera does
    new[[row for n, row in row_of.items() if len(found[n].components) == 1 and found[n].missing]] = 0.0
    before = tracks.existence.probability[rows]
    existence = _exists(tracks, found, sightings, row_of, doubtful, new, goes_on, size, config)
    theta, age_s, strange = tracks.theta.copy(), tracks.age_s.copy(), tracks.strange.copy()
    theta[rows], age_s[rows] = s.theta, 0.0
    strange[rows[~s.placed]] = 0  # what tells no place is in none that is far off
    identities, last = list(tracks.identities), list(tracks.last)
    other_frame = np.array([_frame(found[n]) != _frame(last[row]) for n, row in row_of.items()], bool)
    for n, row in row_of.items():
        last[row] = found[n]
        identities[row] = remembered(found[n].identity, identities[row], config.sightings.identity_memory)
    tracks = replace(
        tracks,
        identities=tuple(identities),
        last=tuple(last),
        image=image,
        theta=theta,
        age_s=age_s,
        existence=existence,
        strange=strange,
    )
    placed, there = np.flatnonzero(s.placed), np.array([found[n].there for n in row_of])
    of_placed = there[placed], before[placed], other_frame[placed]
    return _in_space(tracks, rows[placed], s[placed.tolist()], *of_placed, dt_s, model, config)


def _frame(d: Detection) -> tuple[str, str]:
    """In which its pose is."""
    return d.pose_from, d.frame_id


def _in_space(
    tracks: Tracks,
    rows: Counts,
    s: Sightings,
    there: Array,
    before: Array,
    other_frame: Flags,
    dt_s: float,
    model: MotionModel,
    config: TrackingConfig,
) -> Tracks:
    """Those of tracks that were seen with poses. What is far off does not count, unless it lasts. As far as a pose does
    not count what is known of an object is of another place, and it is there as probably as the frame alone has it;
    while none is taken over it stands as it was.

    :param there: (n,) the frame's own probabilities. :param before: (n,) those that were known.
    :param other_frame: (n,) whose poses are in another frame than before: they begin anew.
    """
    if not len(rows):
        return tracks
    of, mine = config.sightings, tracks.bodies[rows]
    error = mine.error(s.position, s.turn)
    S = mine.motion.place_covariance + s.pose_noise
    far = (error * np.linalg.solve(S, error[..., None])[..., 0]).sum(axis=1)
    agrees = tracks.posed[rows] & (far <= of.far) & ~other_frame
    strange, times, posed = tracks.strange.copy(), tracks.times.copy(), tracks.posed.copy()
    strange[rows] = np.where(agrees, 0, strange[rows] + 1)
    anew = ~agrees & (~posed[rows] | other_frame | (strange[rows] > of.strange))
    doubt = np.maximum(far / of.usual, 1.0)  # errors have longer tails than normal ones
    share = np.where(anew, other_frame | ~posed[rows], 1 / doubt)
    by_all = tracks.existence.probability[rows]
    likely = np.where(agrees | anew, share * by_all + (1 - share) * there, np.maximum(by_all, before))
    seen = mine.seen(s.position, s.turn, s.pose_noise * doubt[:, None, None])
    seen = replace(seen, motion=calmed(seen.motion, dt_s, _most(len(rows), config), 3, model, of.calm))
    bodies = tracks.bodies.replaced(rows[agrees], seen[agrees])
    if anew.any():
        bodies = bodies.replaced(rows[anew], _bodies(s, model, config)[anew])
    times[rows] = np.where(anew, 1, times[rows] + agrees)
    strange[rows[anew]], posed[rows] = 0, True
    existence = tracks.existence.replaced(rows, likely)
    return replace(tracks, bodies=bodies, existence=existence, strange=strange, times=times, posed=posed)


def _bodies(s: Sightings, model: MotionModel, config: TrackingConfig) -> Bodies:
    return Bodies.first_seen(s.position, s.turn, s.pose_noise, _most(len(s.posed), config), model)


def _most(n: int, config: TrackingConfig) -> Array:
    """(n, 6) what a unit of the speed is along x, y, z and about them."""
    turn = config.turn_rate / max(config.speed, 1e-9)
    return np.tile([1.0, 1.0, 1.0, turn, turn, turn], (n, 1))


def _exists(
    tracks: Tracks,
    found: Sequence[Detection],
    sightings: Sightings,
    row_of: Mapping[int, int],
    doubtful: Mapping[int, float],
    new: Array,
    goes_on: float,
    size: tuple[int, int],
    config: TrackingConfig,
) -> Existence:
    here, elsewhere = np.zeros((2, len(tracks)), bool)
    scores = np.full(len(tracks), 0.5)
    for n, row in row_of.items():
        here[row], scores[row], elsewhere[row] = True, found[n].there, found[n].may_be_elsewhere
    for row, probability in doubtful.items():
        here[row], scores[row] = True, probability
    seen = tracks.existence.found(scores, new, tracks.age_s, config.existence, elsewhere)
    if here.all():
        return seen
    missed = tracks.existence.missed(_could_be_seen(tracks, found, sightings, size), config.existence).times(goes_on)
    return Existence(np.where(here, seen.seen, missed.seen), np.where(here, seen.hidden, missed.hidden))


def _moved(image: MotionState, age_s: Array, rows: Counts, s: Sightings) -> Array:
    """(T,) how far each has come in the image since it was seen last, in sizes of its required component: by its
    speed, for what stands still is told a little elsewhere in each frame; 0 of those that are not seen.

    :param age_s: (T,) since then. :param rows: of what is seen, `s`.
    """
    out, size_px = np.zeros(len(image)), np.maximum(s.size_m * s.unit[:, 0], 1e-9)
    speed = image[rows].mean[:, 1] / np.column_stack([size_px, size_px, np.full(len(rows), _GROWN)])
    out[rows] = np.linalg.norm(speed, axis=1) * age_s[rows]
    return out


def _could_be_seen(tracks: Tracks, found: Sequence[Detection], s: Sightings, size: tuple[int, int]) -> Array:
    """(T,) share of them that would be seen, were they where they are expected: whose middle is in the image, and not
    behind what was found."""
    middle = tracks.expected[:, :2]
    hidden = ((middle < 0) | (middle > size)).any(axis=1)
    range_m = np.where(tracks.in_camera, np.linalg.norm(tracks.bodies.motion.place[:, :3], axis=1), np.inf)
    for n, d in enumerate(found):
        outlines = [c.contour for c in d.components if len(c.contour)]
        if outlines:
            points = np.concatenate(outlines)
            inside = ((middle >= points.min(axis=0)) & (middle <= points.max(axis=0))).all(axis=1)
            hidden |= inside & (~s.posed[n] | (s.range_m[n] < range_m))
    return np.where(hidden, _SEEN_IF_HIDDEN, 1.0)
