"""Marked images of an object by its lengths: where it is in each, what its joints are there, which lengths fit best."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares
from scipy.sparse import lil_matrix
from scipy.spatial.transform import Rotation

from ..geometry.transforms import Array
from ..model.kinematics import Kinematics
from ..pose.poses import Poses
from .joint_limits import Carried, JointValues, carried
from .lengths import Lengths
from .marked_views import Eye, Start

CLICK_PX, _MISTAKEN = 1.0, 3.0  # deviation of a marked end; beyond so many it counts for less
_LOST = 6.0  # times as far off as most: a mistake, which tells no joint's value
_MOST_LOST = 0.25  # of an image's marks: with more its pose may be another one
_LOOSE = 1e-6  # what is known of a pose and of joints beside marks: nothing, in 1 / deviations squared
_EXACT = 1e-5  # a step that betters the sum by a smaller share is the last one
_MOST_STEPS = 100  # many parts and joints take 40


class Far(NamedTuple):
    """A marked axis that lies far from where the others say that it is."""

    place: str
    component: str
    marker: str
    off_px: float


class Views:
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
        self._first_joint = len(self._turns) + 3
        self._each = self._first_joint + self._start.q.shape[1]
        self.kin = Kinematics(eye.model)

    def measured(self) -> tuple[Array, Carried]:
        """Lengths that fit these images best, and the limits that go with them."""
        values = self._lengths_fit()
        return values, carried(self.kin, self._as_is, self._told(values))

    def as_marked(self) -> Carried:
        """The limits that hold all these images with lengths as they are."""
        return carried(self.kin, self._as_is, self._as_is)

    @cached_property
    def _as_is(self) -> JointValues:
        """What marks tell of joints with lengths as they are."""
        return self._told(self._lengths.none)

    def _lengths_fit(self) -> Array:
        n, rows = len(self._lengths.none), 4 * len(self._marker)
        pattern = lil_matrix((rows + n, n + len(self._start) * self._each), dtype=np.int8)
        pattern[:rows, :n], pattern[np.arange(rows, rows + n), np.arange(n)] = 1, 1
        self._note(pattern, n)
        return _least(lambda x: np.concatenate([self._residuals(x[:n], x[n:]), x[:n]]), pattern).x[:n]

    def off_px(self, values: Array, joints: Carried) -> Array:
        """(n,) mean distance of each marked axis' ends from where they should be at given lengths, with joints within
        limits; of a disc its middle's."""
        return self._apart(values, self._placed(values, joints.bounds(self.kin)).x)

    def _apart(self, values: Array, x: Array) -> Array:
        """(n,) the same where objects are as `x` has them."""
        off = self._off(values, x)
        ends, middle = np.linalg.norm(off, axis=-1).mean(axis=1), np.linalg.norm(off.mean(axis=1), axis=-1)
        return np.where(self._disc, middle, ends)

    def _placed(self, values: Array, bounds: Array | None = None) -> Any:
        """Where objects are, at given lengths. :param bounds: (2, J) of joints."""
        pattern = lil_matrix((4 * len(self._marker), len(self._start) * self._each), dtype=np.int8)
        self._note(pattern, 0)
        free = _least(lambda x: self._residuals(values, x), pattern)
        within = np.full((2, len(self._start), self._each), [[[-np.inf]], [[np.inf]]])
        if bounds is not None:
            within[..., self._first_joint :] = bounds[:, None] - self._start.q
        within = within.reshape(2, -1)
        at_limits = np.clip(free.x, *within)
        if (at_limits == free.x).all():
            return free
        return _least(lambda x: self._residuals(values, x), pattern, at_limits, within)

    def _told(self, values: Array) -> JointValues:
        """What marks tell of joints at given lengths, limits or not. A joint beyond which nothing is marked has a
        column of zeros."""
        found, each = self._placed(values), self._each
        apart, deviation = self._apart(values, found.x), np.empty_like(self._start.q)
        for n in range(len(self._start)):
            rows = np.flatnonzero(np.repeat(self._image == n, 4))
            slopes = found.jac[rows][:, n * each : (n + 1) * each].toarray()
            covariance = np.linalg.inv(slopes.T @ slopes + _LOOSE * np.eye(each))
            deviation[n] = np.sqrt(np.diag(covariance)[self._first_joint :])
        deviation[self._mistaken(apart)] = np.inf
        return JointValues(self._start.q + found.x.reshape(-1, each)[:, self._first_joint :], deviation)

    def _mistaken(self, apart: Array) -> NDArray[np.bool_]:
        """(n, J) of which images' joints an axis is that lies far off, by axes' distances (m,): of joints that move it;
        of all where none does, or where it is one of few."""
        lost = apart > max(_MISTAKEN * CLICK_PX, _LOST * float(np.median(apart)))
        number, marked = (np.bincount(i, minlength=len(self._start)) for i in (self._image[lost], self._image))
        out = np.repeat((number > _MOST_LOST * marked)[:, None], self._start.q.shape[1], axis=1)
        for n, c in zip(self._image[lost], self._lengths.components[self._marker[lost]], strict=True):
            moves = self.kin.moves[c]
            out[n] |= moves | ~moves.any()
        return out

    def far(self, values: Array) -> list[Far]:
        """All axes, the farthest first."""
        off, names = self._apart(values, self._placed(values).x), self._lengths.names
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
        turns, shift, q = np.split(x.reshape(-1, self._each), [len(self._turns), self._first_joint], axis=1)
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
        return np.asarray(np.sqrt(2) / CLICK_PX * np.concatenate([middle, half], axis=1).ravel())


def _least(
    residuals: Callable[[Array], Array],
    pattern: lil_matrix,
    start: Array | float = 0.0,
    within: Any = (-np.inf, np.inf),
) -> Any:
    """What scipy finds: numbers at which residuals are least, mistakes counting for less.

    :param start, within: (n,) from where on; (2, n) least and greatest of them.
    """
    return least_squares(
        residuals, np.zeros(pattern.shape[1]) + start, jac_sparsity=pattern, loss="soft_l1", f_scale=_MISTAKEN,
        ftol=_EXACT, bounds=within, max_nfev=_MOST_STEPS,
        x_scale="jac",  # turns, shifts and lengths weigh unlike: unscaled, steps come to no end
    )  # fmt: skip
