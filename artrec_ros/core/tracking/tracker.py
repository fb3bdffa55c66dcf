"""What goes on from frame to frame: which detection is which object of the frames before, how probable it is by now
that the object is there, and how it moves.

Of every object it is known where it was and how it moved, in space and in the image. A detection continues an
object where its place and turn are likelier for it than for a newcomer, who may be anywhere in view; all pairs of
a frame are settled together. Where frames go on from one another, a newcomer in doubt waits until it is seen again, and
one frame's doubt does not end what is known.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import replace

import numpy as np

from ..base.config import RecognizerConfig, TrackingConfig
from ..base.deferred import Deferred
from ..base.stamps import seconds_since
from ..geometry.transforms import Array
from ..model.found import Detection
from ..model.frame_result import FrameResult, Rejection
from ..model.target import Target
from ..verdict.judge import too_low
from .doubles import Places, beside_others, doubles, leaps
from .existence import Continuity, newcomers
from .following import begun, followed
from .joints import Joints, units_of
from .matching import assign, matched
from .motion import Flags, MotionModel
from .names import Numbers
from .naming import found_again, with_names
from .sightings import Sightings, sizes_of
from .telling import Teller
from .tracks import Tracks

_MOST_LATE = 3  # frames in a row that come out of their order
_BY_DEFAULT = RecognizerConfig()


class Tracker:
    """Carries objects on through the frames of one camera, in their order."""

    def __init__(
        self,
        config: TrackingConfig,
        targets: Sequence[Target] = (),
        recognizer: RecognizerConfig = _BY_DEFAULT,
    ) -> None:
        """:param targets: tell what joints are measured in, and how large objects are.
        :param recognizer: by which detections are found. It tells whether their scores are probabilities to which other
            frames add; else each frame tells for itself what is there, how it is turned and which one it is, and only
            ids and motions are carried on. What is probable enough for one frame to tell it is so for several.
        """
        self._numbers, self._units = Numbers(), units_of(targets)
        self._sizes = sizes_of(targets)
        self._size, self._frame_id = (0, 0), ""
        self._late: list[int] = []  # stamps of frames that came out of their order just now
        self.configure(config, recognizer)
        self.forget()

    def configure(self, config: TrackingConfig, recognizer: RecognizerConfig = _BY_DEFAULT) -> None:
        """Go on with other parameters."""
        self._least, self._in_doubt = min(config.existence.least, recognizer.min_probability), recognizer.in_doubt
        self._config = config if self._in_doubt else _without_memory(config)
        self._motion = MotionModel(config.speed, config.steady_s)
        if not config.enabled:
            self.forget()

    def forget(self) -> None:
        """Forget all objects: whoever comes next is somebody else. Who was seen just now keeps the id for a while."""
        self._tracks, self._joints = Tracks.none(), Joints.none()
        self._continuity = Continuity.expected(self._config.existence)
        self._stamp_ns: int | None = None

    def update(self, stamp_ns: int, result: FrameResult, frame_id: str = "") -> FrameResult:
        """The same result with lasting ids, with the probabilities that the objects are there by all that has been seen
        of them, and without those that are unlikely by that.

        All objects are forgotten where the clock goes back, as when a bag starts again, and their numbers, too; or
        where the images' size or frame is another one.

        :param frame_id: the camera's optical frame; empty: not known.
        """
        if not self._config.enabled:
            return result
        if self._is_late(stamp_ns, result.size, frame_id):
            # named by what is known by now, of which it says nothing: it shows what was before
            by_now = deepcopy(self)
            by_now._numbers = self._numbers  # so that nobody else gets a number that it gives
            return by_now._follow(stamp_ns, result, frame_id)
        return self._follow(stamp_ns, result, frame_id)

    def _is_late(self, stamp_ns: int, size: tuple[int, int], frame_id: str) -> bool:
        """Whether a frame comes out of its order. Where one after the other does so the clock was set back."""
        late_s = -seconds_since(self._stamp_ns, stamp_ns)
        if not 0 < late_s <= self._config.max_gap_s or self._is_another_view(size, frame_id):
            self._late = []
            return False
        self._late = [*(ns for ns in self._late if ns < stamp_ns), stamp_ns]
        if len(self._late) <= _MOST_LATE:
            return True
        self._stamp_ns, self._late = self._late[-2], []
        return False

    def _follow(self, stamp_ns: int, result: FrameResult, frame_id: str) -> FrameResult:
        first, dt_s = self._advance(stamp_ns, result.size, frame_id)
        found = result.detections
        sightings, area_px = self._sightings(found), float(result.size[0] * result.size[1])
        row_of, odds = matched(self._tracks, found, sightings, area_px, self._config)
        strangers = np.array([d.there for n, d in enumerate(found) if n not in row_of])
        goes_on, other = self._goes_on(odds, strangers, dt_s)
        # in another scene what lies near is somebody else, too
        row_of = {n: row for n, row in row_of.items() if goes_on * odds[row] >= 1 - goes_on}
        row_of |= self._leapt(found, sightings, row_of, dt_s) if goes_on > 1 - goes_on else {}
        if self._in_doubt:
            result, sightings = self._turned(result, row_of, sightings)
            found = result.detections
        doubtful = self._in_doubtful(result, row_of) if self._in_doubt and goes_on > 1 - goes_on else {}
        self._tracks = followed(
            self._tracks, found, sightings, row_of, doubtful, goes_on, dt_s, result.size, self._motion, self._config
        )
        new = [n for n in range(len(found)) if n not in row_of]
        row_of |= {n: len(self._tracks) + k for k, n in enumerate(new)}
        alone = np.array([found[n].there for n in new])
        single = first or other or not self._in_doubt
        scores = alone if single else newcomers(alone, goes_on, dt_s, self._config.existence)
        self._tracks = self._tracks.joined(
            begun([found[n] for n in new], sightings[new], scores, self._motion, self._config)
        )
        by_row = {row: found[n] for n, row in row_of.items()}
        # as a body does its joints begin anew
        anew = {row for row in by_row if self._tracks.times[row] == 1 and not self._tracks.strange[row]}
        self._joints = self._joints.without(anew).seen(by_row, dt_s, self._motion, self._units, self._config)
        return self._told(result, row_of)

    def _advance(self, stamp_ns: int, size: tuple[int, int], frame_id: str) -> tuple[bool, float]:
        """Let time pass up to a frame. Whether it is the first one, and the time since the one before. A frame may
        come out of order, or the clock was set back a little: such stamps stand still."""
        last_ns = stamp_ns if self._stamp_ns is None else self._stamp_ns
        if (last_ns - stamp_ns) * 1e-9 > self._config.max_gap_s:
            self.forget()
            self._numbers = Numbers()  # what is played again is named as it was
        elif self._is_another_view(size, frame_id):
            self.forget()
        else:
            stamp_ns = max(stamp_ns, last_ns)
        first = self._stamp_ns is None
        dt_s = seconds_since(self._stamp_ns, stamp_ns)
        self._numbers.pass_time(dt_s, self._config.max_gap_s)
        self._tracks = self._tracks.after(dt_s, self._motion, self._config)
        self._joints = self._joints.after(dt_s, self._motion)
        gone = self._config.existence.gone
        self._keep((self._tracks.existence.probability >= gone) & (self._tracks.age_s <= self._config.max_gap_s))
        self._stamp_ns, self._size, self._frame_id = stamp_ns, size, frame_id or self._frame_id
        return first, dt_s

    def _is_another_view(self, size: tuple[int, int], frame_id: str) -> bool:
        return size != self._size or bool(frame_id and self._frame_id and frame_id != self._frame_id)

    def _keep(self, kept: Flags) -> None:
        if not kept.all():
            rows = np.flatnonzero(kept).tolist()
            self._tracks, self._joints = self._tracks[rows], self._joints.of_rows(rows)

    def _in_doubtful(self, result: FrameResult, row_of: Mapping[int, int]) -> dict[int, float]:
        """Rows of tracks that are not seen, and how probable by itself a candidate is in which each may go on.

        It may be something else: it tells neither where the object is nor which one, but not that it is gone, either.
        """
        lost = sorted(set(range(len(self._tracks))) - set(row_of.values()))
        if not lost or not len(result.doubtful):
            return {}
        area_px = float(result.size[0] * result.size[1])
        sightings = self._sightings(result.doubtful)
        rows, _ = matched(self._tracks[lost], result.doubtful, sightings, area_px, self._config)
        return {lost[row]: result.doubtful[n].there for n, row in rows.items()}

    def _sightings(self, found: Sequence[Detection]) -> Sightings:
        return Sightings.of(found, self._sizes, self._config.sightings)

    def _leapt(
        self, found: Sequence[Detection], s: Sightings, row_of: Mapping[int, int], dt_s: float
    ) -> dict[int, int]:
        """Rows of tracks that nothing continues by those of other detections that lie in their places."""
        new = [n for n in range(len(found)) if n not in row_of]
        lost = [row for row in range(len(self._tracks)) if row not in row_of.values()]
        if not new or not lost:
            return {}
        there = Places.found([found[n].object for n in new], s[new])
        apart = leaps(there, self._tracks[lost], self._sizes, dt_s, self._config.sightings)
        return {new[n]: lost[k] for n, k in assign(apart - 1).items()}

    def _turned(
        self, result: FrameResult, row_of: Mapping[int, int], sightings: Sightings
    ) -> tuple[FrameResult, Sightings]:
        """With those turns that are likelier by all frames."""
        tracks = self._tracks
        turns, other = tracks.turns.seen(result.detections, row_of, tracks.last, tracks.age_s, self._config)
        self._tracks = replace(tracks, turns=turns)
        if not other:
            return result, sightings
        found = tuple(other.get(n, d) for n, d in enumerate(result.detections))
        return replace(result, detections=found), self._sightings(found)

    def _goes_on(self, odds: Array, new: Array, dt_s: float) -> tuple[float, bool]:
        """The probability that the frame goes on from the one before, and whether it is surely another scene: something
        was there, all of it is gone, and others are there. Where nobody is new it is the same.

        :param odds: (T,) of tracks that do. :param new: scores of what continues none.
        """
        told, tracks, config = self._tracks.are_told, self._tracks, self._config.existence
        if not told.any():
            return self._continuity.share, False
        just_seen = tracks.age_s[told] <= 1.5 * dt_s
        known = tracks.existence.seen[told]
        probability = self._continuity.judged(known, just_seen, odds[told], new, dt_s, config)
        if len(new) or odds.any():
            least = 0.0 if len(new) else self._continuity.share
            self._continuity = self._continuity.after(max(probability, least), config)
        if not len(new) or not self._in_doubt:
            return 1.0, False
        return probability, bool(just_seen.any()) and not odds.any()

    def _told(self, result: FrameResult, row_of: dict[int, int]) -> FrameResult:
        """What is told, with names; tracks that have given theirs away are forgotten."""
        found, least = result.detections, self._least
        likely = self._tracks.existence.probability.tolist()
        for n, row in row_of.items():
            if self._tracks.strange[row]:  # what is known is of another place
                likely[row] = found[n].there
        told = [
            n
            for n in sorted(row_of)
            if not (self._in_doubt and found[n].is_in_doubt) or likely[row_of[n]] >= min(least, found[n].there)
        ]
        here, told_rows = set(row_of.values()), [row_of[n] for n in told]
        self._tracks, given_away = found_again(self._tracks, here, told_rows, self._config.sightings)
        self._tracks = with_names(self._tracks, told_rows, self._numbers, self._in_doubt, self._config.sightings)
        teller = Teller(
            self._tracks, self._joints, self._config, result.size, self._sizes, likely if self._in_doubt else None
        )
        seen = [teller.seen(found[n], row_of[n]) for n in told]
        whose = list(zip(self._tracks.names, self._tracks.ids, strict=True))
        taken = {whose[row] for row in here if self._tracks.ids[row] is not None}
        # who was alone and has been lost has given the id away
        gone = here | given_away | doubles(self._tracks, sorted(here), self._sizes)
        away = [row for row in range(len(whose)) if row not in gone and whose[row] not in taken]
        told_already = beside_others(self._tracks, {row: found[n] for n, row in row_of.items()}, self._sizes)
        expected = teller.expected([row for row in away if row not in told_already])
        kept = np.zeros(len(whose), bool)
        kept[[*here, *away]] = True
        self._keep(kept)
        waits = [_waiting(found[n], likely[row_of[n]], least) for n in sorted(set(row_of) - set(told))]
        rejected = Deferred(lambda: (*waits, *result.rejected)) if waits else result.rejected
        return replace(result, detections=(*seen, *expected), rejected=rejected, doubtful=())


def _without_memory(config: TrackingConfig) -> TrackingConfig:
    """That each frame tells for itself which one of several like objects each is."""
    return replace(config, sightings=replace(config.sightings, identity_memory=0.0))


def _waiting(detection: Detection, likely: float, least: float) -> Rejection:
    """Why an object that is found is not told yet."""
    reason = too_low(likely, least, "one that is seen again is told", by=" by all images so far")
    return Rejection(detection.object, reason, likely, detection.image.x, detection.image.y)
