"""How large an object's markers are and where its parts sit, from marked ends of axes in images: bundle adjustment.

Object files are measured with a ruler, or guessed. What many images show of a thing that moves in itself fits one set
of lengths alone, but for their common measure: that stays as the required component's first marker has it. Nothing
moves without need: the object file counts as one more measurement, which may be off by so much.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.optimize import least_squares
from scipy.sparse import lil_matrix
from scipy.spatial.transform import Rotation

from ..geometry.camera import Camera
from ..geometry.transforms import Array
from ..model.objects import ObjectModel
from ..pose.surface_model import Poses
from .lengths import Change, Lengths
from .marked_views import Eye, Marks, Start

_CLICK_PX, _MISTAKEN = 1.0, 3.0  # deviation of a marked end; beyond so many it counts for less
_LEAST_BETTER = 0.85  # of the distance that remains: else the object file holds as it is
LEAST_VIEWS = 4
MOST_VIEWS = 80  # seconds of work, and more tell hardly more
_EXACT = 1e-5  # a step that betters the sum by a smaller share is the last one
_MOST_STEPS = 100  # many parts and joints take 40


class Far(NamedTuple):
    """A marked axis that lies far from where the others say that it is."""

    place: str
    component: str
    marker: str
    off_px: float


@dataclass(frozen=True)
class Measured:
    """:param model: the object with what was measured. :param views: how many were.
    :param before_px, after_px: median distance of marked ends from where they should be, by the object as it was and by
        what other views measure.
    :param far: marked axes, the farthest first, by what all measure.
    :param left_out: places of marked objects that are in no pose like the object.
    """

    model: ObjectModel
    changes: tuple[Change, ...]
    views: int
    before_px: float
    after_px: float
    far: tuple[Far, ...]
    left_out: tuple[str, ...]

    @property
    def helps(self) -> bool:
        """Whether what some views measure fits others clearly better than what the object file has."""
        return self.after_px < _LEAST_BETTER * self.before_px


@dataclass(frozen=True)
class TooFew:
    """Marked objects that tell too little: `LEAST_VIEWS` must be near to how the object may look.

    :param showing: how many show two markers or more. :param looked_at: of how many of these a pose was sought.
    :param near: how many are near to one. :param off_px: mean distance of marked ends from it, of those that are not.
    """

    showing: int
    looked_at: int
    near: int
    off_px: tuple[float, ...]


def measure(
    model: ObjectModel, marks: Sequence[Marks], camera: Camera | None, most: int = MOST_VIEWS
) -> Measured | TooFew:
    """The lengths that marked images tell of an object whose markers have places.

    :param camera: of the images; None: the object is flat, and seen straight from above by whatever camera.
    :param most: images that are used, evenly drawn.
    """
    showing = [m for m in marks if len(m.marker) > 1]
    marks = showing[:: -(-len(showing) // most) or 1]
    most_px = int(max((m.ends.max() for m in marks), default=1)) + 1
    eye = Eye(model, camera or Camera.facing((most_px, most_px)), camera is None)
    found = eye.starts(marks)
    starts = [start for start in found if start.near]
    if len(starts) < LEAST_VIEWS:
        return TooFew(len(showing), len(marks), len(starts), tuple(s.off_px for s in found if not s.near))
    return _measured(model, eye, marks, starts)


def _measured(model: ObjectModel, eye: Eye, marks: Sequence[Marks], starts: Sequence[Start]) -> Measured:
    """By the starts of some of the marks."""
    lengths, used = Lengths(model), {id(start.marks) for start in starts}
    halves = [_Views(eye, lengths, half) for half in (starts[::2], starts[1::2])]
    found = [half.lengths() for half in halves]
    before = np.concatenate([half.off_px(lengths.none) for half in halves])
    after = np.concatenate([half.off_px(other) for half, other in zip(halves, found[::-1], strict=True)])
    views = _Views(eye, lengths, starts)
    best = views.lengths()
    return Measured(
        lengths.model_of(best), tuple(lengths.changes(best)), len(starts), float(np.median(before)),
        float(np.median(after)), tuple(views.far(best)), tuple(m.place for m in marks if id(m) not in used),
    )  # fmt: skip


class _Views:
    """Marked images of an object, and where it is in each: numbers near 0 about where it starts.

    Of each image a turn about the line of sight, or any where objects do not face the camera, a shift, and the joints.
    """

    def __init__(self, eye: Eye, lengths: Lengths, starts: Sequence[Start]) -> None:
        self._eye, self._lengths, self._turns = eye, lengths, [2] if eye.facing else [0, 1, 2]
        self._places = [s.marks.place for s in starts]
        self._start = Poses.concatenate([s.poses for s in starts])
        self._image = np.repeat(np.arange(len(starts)), [len(s.marks.marker) for s in starts])
        self._marker = np.concatenate([s.marks.marker for s in starts])
        self._ends = np.concatenate([s.marks.ends for s in starts])
        self._disc = lengths.discs[self._marker]
        self._each = len(self._turns) + 3 + self._start.q.shape[1]

    def lengths(self) -> Array:
        """Those that fit these images best."""
        n, rows = len(self._lengths.none), 4 * len(self._marker)
        pattern = lil_matrix((rows + n, n + len(self._start) * self._each), dtype=np.int8)
        pattern[:rows, :n], pattern[np.arange(rows, rows + n), np.arange(n)] = 1, 1
        self._note(pattern, n)
        return _least(lambda x: np.concatenate([self._residuals(x[:n], x[n:]), x[:n]]), pattern)[:n]

    def off_px(self, values: Array) -> Array:
        """(n,) mean distance of each marked axis' ends from where they should be at given lengths; of a disc its
        middle's."""
        pattern = lil_matrix((4 * len(self._marker), len(self._start) * self._each), dtype=np.int8)
        self._note(pattern, 0)
        off = self._off(values, _least(lambda x: self._residuals(values, x), pattern))
        ends, middle = np.linalg.norm(off, axis=-1).mean(axis=1), np.linalg.norm(off.mean(axis=1), axis=-1)
        return np.where(self._disc, middle, ends)

    def far(self, values: Array) -> list[Far]:
        """All axes, the farthest first."""
        off, names = self.off_px(values), self._lengths.names
        order = np.argsort(-off, kind="stable").tolist()
        where = [(self._places[self._image[n]], names[self._marker[n]], float(off[n])) for n in order]
        return [Far(place, component, marker, off_px) for place, (component, marker), off_px in where]

    def _note(self, pattern: lil_matrix, first: int) -> None:
        """Which residuals depend on which numbers, from column `first` on."""
        for row, image in enumerate(self._image.tolist()):
            begin = first + image * self._each
            pattern[4 * row : 4 * row + 4, begin : begin + self._each] = 1

    def _off(self, values: Array, x: Array) -> Array:
        """(n, 2, 2) pixels from marked ends to where they should be."""
        turns, shift, q = np.split(x.reshape(-1, self._each), [len(self._turns), len(self._turns) + 3], axis=1)
        rotvec, start = np.zeros((len(turns), 3)), self._start
        rotvec[:, self._turns] = turns
        R = Rotation.from_rotvec(rotvec).as_matrix() @ start.R
        poses = Poses(R, start.t + shift * start.t[:, 2:], start.q + q)
        pixels = self._eye.pixels(self._lengths.figure(values), poses)
        return np.asarray(pixels[self._image, self._marker] - self._ends)

    def _residuals(self, values: Array, x: Array) -> Array:
        """(4 n,) of each axis its middle's, and half its length's and direction's, in deviations of a click. Which of
        its diameters was marked of a disc nobody knows: its length alone counts."""
        off, disc = self._off(values, x), self._disc
        middle, half = off.mean(axis=1), (off[:, 1] - off[:, 0]) / 2
        seen = (self._ends[disc, 1] - self._ends[disc, 0]) / 2
        longer = np.linalg.norm(half[disc] + seen, axis=1) - np.linalg.norm(seen, axis=1)
        half[disc] = np.column_stack([longer, np.zeros(len(longer))])
        return np.asarray(np.sqrt(2) / _CLICK_PX * np.concatenate([middle, half], axis=1).ravel())


def _least(residuals: Callable[[Array], Array], pattern: lil_matrix) -> Array:
    """Numbers, from 0 on, at which residuals are least, mistakes counting for less."""
    found = least_squares(
        residuals, np.zeros(pattern.shape[1]), jac_sparsity=pattern, loss="soft_l1", f_scale=_MISTAKEN, ftol=_EXACT,
        x_scale="jac", max_nfev=_MOST_STEPS,  # turns, shifts and lengths weigh unlike: unscaled, steps come to no end
    )  # fmt: skip
    return np.asarray(found.x)
