"""A label image that answers for any pixel, and the seams that its segmenter leaves."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from copy import copy
from functools import cached_property, lru_cache
from itertools import accumulate, pairwise

import cv2
import numpy as np
from numpy.typing import NDArray

from ..base.config import SeamsConfig
from ..geometry.pixel_kernels import codes_at
from ..geometry.transforms import Array
from .codes import EMPTY, LABELS, OUTSIDE, OWNED, UNKNOWN, Codes
from .seam_kernels import SILENT, UNTOLD, gaps_px, marked

_SUBPIXEL_BITS = 4
_SEAM_PIXELS = 6000  # of a class' border that are looked at: its median is known to a hundredth of a pixel
_NO_CLASS = UNKNOWN, EMPTY, OWNED, OUTSIDE  # labels of none
_GOLDEN = (np.sqrt(5) - 1) / 2


@lru_cache(maxsize=8)
def _around(reach: int, width: int) -> tuple[NDArray[np.int64], Array]:
    """Where the pixels around one are in rows of so many, nearest first, and the gaps (px) between it and them."""
    around = np.mgrid[-reach : reach + 1, -reach : reach + 1].reshape(2, -1)
    rows, columns = around[:, np.argsort(np.hypot(*around), kind="stable")]
    return rows * width + columns, np.hypot(rows, columns) - 1.0


def _median(values: Array) -> float:
    """Of some; numpy's takes longer to look what they are."""
    ordered, n = np.sort(values), len(values)
    return float((ordered[(n - 1) // 2] + ordered[n // 2]) / 2)


class LabelField:
    """A label image that answers for any pixel, the ones beyond its border included.

    :param codes: (H, W) what pixels show. :param seams: how seams are measured; None: by the defaults.
    :param meaning: of the codes; a label image's are its labels.
    :param ignored: x, y, width, height, ... of rectangles of which nothing is known.
    :param on_bodies: classes of the markers of objects whose bodies have no class: between such a marker and what lies
        beyond a body may show that is no wider than a seam.
    """

    def __init__(
        self,
        codes: NDArray[np.uint8],
        seams: SeamsConfig | None = None,
        meaning: Codes = LABELS,
        ignored: Sequence[int] = (),
        on_bodies: Iterable[int] = (),
    ) -> None:
        self.codes, self.meaning, self._ignored, self.on_bodies = codes, meaning, ignored, frozenset(on_bodies)
        self._config = seams or SeamsConfig()
        self._seams: dict[int, float] = {}
        self._near: dict[int, tuple[Array, int, float]] = {}
        self._before: LabelField | None = None
        self.hides = False  # whether those who own pixels lie before what is looked for
        self._seams_of: dict[tuple[tuple[tuple[int, ...], ...], bool], Array] = {}

    @cached_property
    def padded(self) -> NDArray[np.uint8]:
        """The codes with a border of one pixel, row by row; of unknown pixels with nothing known around EMPTY."""
        empty = self._empty()
        codes = cv2.bitwise_or(cv2.bitwise_and(self.codes, ~empty), empty & EMPTY)
        return cv2.copyMakeBorder(codes, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=OUTSIDE).ravel()

    def _empty(self) -> NDArray[np.uint8]:
        """(H, W) 255 where a pixel is unknown for sure, and all others are that are no farther than a seam is wide."""
        known = cv2.bitwise_not(cv2.inRange(self.labels, UNKNOWN, UNKNOWN))
        codes = np.flatnonzero(self.meaning.unknown).tolist()
        if len(codes) == 1:  # a comparison takes a tenth of the time of a table
            unknown = cv2.inRange(self.codes, codes[0], codes[0])
        else:
            unknown = cv2.LUT(self.codes, np.where(self.meaning.unknown, 255, 0).astype(np.uint8))
        self._fill_ignored(known, 255)
        around = 2 * self._reach_px + 1
        near = cv2.dilate(known, np.ones((around, around), np.uint8))
        return np.asarray(unknown & ~near)

    @cached_property
    def labels(self) -> NDArray[np.uint8]:
        """(H, W) what each code is named."""
        return self.codes if self.meaning is LABELS else cv2.LUT(self.codes, self.meaning.label)

    @cached_property
    def padded_labels(self) -> NDArray[np.uint8]:
        """What each code is named, with a border of one pixel, row by row; EMPTY in an image of labels alone."""
        if self.meaning is LABELS:
            return self.padded
        return cv2.copyMakeBorder(self.labels, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=OUTSIDE).ravel()

    def blanked(self, code: int) -> NDArray[np.uint8]:
        """(H, W) the codes, with one of their own where nothing is known; not to be changed."""
        if not len(self._ignored):
            return self.codes
        codes = self.codes.copy()
        self._fill_ignored(codes, code)
        return codes

    def _fill_ignored(self, image: NDArray[np.uint8], value: int) -> None:
        for x, y, width, height in np.reshape(self._ignored, (-1, 4)).astype(int).tolist():
            image[max(y, 0) : max(y + height, 0), max(x, 0) : max(x + width, 0)] = value

    def at(self, pixels: Array) -> NDArray[np.uint8]:
        """Codes (...,) at the nearest pixels to (..., 2); OUTSIDE beyond the image."""
        height, width = self.codes.shape
        codes = np.empty(pixels.shape[:-1], np.uint8)
        codes_at(self.padded, width, height, pixels.reshape(-1, 2), codes.reshape(-1))
        return codes

    def owned_share(self, contour: Array) -> float:
        """Share of a blob's contour (n, 2) that lies on pixels which somebody owns."""
        return np.count_nonzero(self.at(contour) == OWNED) / len(contour)

    def owned_inside(self, pixels: NDArray[np.int32]) -> float:
        """Share of the pixels inside a blob's outermost ones (n, 2) that somebody owns: of its contour's less where
        blur carries a colour beyond edges."""
        x, y, width, height = cv2.boundingRect(pixels)
        inside = cv2.drawContours(np.zeros((height, width), np.uint8), [pixels], 0, 1, cv2.FILLED, offset=(-x, -y))
        return float(np.mean(self.codes[y : y + height, x : x + width][inside > 0] == OWNED))

    def seam_px(self, label: int) -> float:
        """Half the width of the seam of unknown pixels that the segmenter leaves around a class; 0 without one.

        Measured where another known class follows within `reach_px` of the class' border. Where that is along a part of
        it alone, as between the patches of one robot, it is a seam only if the segmenter leaves some around the others;
        where classes are told by colours none are left. Around a class of `on_bodies` it is as wide as around others.
        """
        if label not in self._seams:
            whole = self.unowned
            self._seams[label] = whole._seam_of_others_px if label in self.on_bodies else whole._seam_of_px(label)
        return self._seams[label]

    def most_seam_px(self, label: int) -> float:
        """The same of all that may be a seam: around a class of `on_bodies` nobody can tell it from the body."""
        told = self.seam_px(label)
        return max(told, self.unowned._seam_of_px(label)) if label in self.on_bodies else told

    def _seam_of_px(self, label: int) -> float:
        near, border, _ = self._near_px(label)
        seams = len(near) > self._config.border_share * border
        if seams and len(near) <= self._config.clear_share * border:
            seams = self.leaves_seams
        return _median(near) / 2 if seams else 0.0

    @cached_property
    def _seam_of_others_px(self) -> float:
        """The same around all classes together that others are near, but those of `on_bodies`."""
        if self.meaning is not LABELS:
            return 0.0
        looks = map(self._near_px, self._told_labels)
        gaps = [near for near, border, _ in looks if len(near) > self._config.border_share * border]
        return _median(np.concatenate(gaps)) / 2 if gaps else 0.0

    @cached_property
    def _told_labels(self) -> list[int]:
        """Classes in the image whose borders tell of seams."""
        labels = np.flatnonzero(np.bincount(self.padded_labels))
        return [int(v) for v in np.setdiff1d(labels, (*_NO_CLASS, *self.on_bodies))]

    @cached_property
    def leaves_seams(self) -> bool:
        """Whether the image is one of labels, and another known class follows within a seam's reach along much of the
        borders of all classes."""
        if self.meaning is not LABELS:
            return False
        counts = [(scale * len(near), scale * border) for near, border, scale in map(self._near_px, self._told_labels)]
        near, border = np.array(counts).reshape(-1, 2).sum(axis=0)
        return bool(near > self._config.all_share * border)

    def _near_px(self, label: int) -> tuple[Array, int, float]:
        """The gaps between a class and others in reach; how many of its border pixels were looked at, and for how many
        each of these stands."""
        if label not in self._near:
            gaps, scale = self._gaps_px(label)
            self._near[label] = gaps[gaps < self._config.reach_px], len(gaps), scale
        return self._near[label]

    def seams_px(self, classes: tuple[tuple[int, ...], ...], *, most: bool = False) -> Array:
        """Half the width of the seam around each of some classes, or of the most that it may be; of several labels' the
        mean. Not to be changed."""
        if (classes, most) not in self._seams_of:
            of = self.most_seam_px if most else self.seam_px
            self._seams_of[classes, most] = np.array([sum(map(of, labels)) / len(labels) for labels in classes], float)
        return self._seams_of[classes, most]

    def _gaps_px(self, label: int) -> tuple[Array, float]:
        """From border pixels of a class, but for those within `reach_px` of the image's border, to the next pixel
        of another known class, itself not counted; inf: far. And for how many each of them stands. Those before a class
        of `on_bodies` tell nothing."""
        means = np.zeros(256, np.uint8)
        means[list(self.on_bodies)] = UNTOLD
        means[[*_NO_CLASS, label]] = SILENT
        labels, looks = self.padded_labels, _around(self._reach_px, self.codes.shape[1] + 2)
        borders, theirs = self._borders
        mine = borders[theirs == label]
        scale = max(len(mine) / _SEAM_PIXELS, 1.0)
        if len(mine) > _SEAM_PIXELS:  # a regular step could keep pace with the rows and miss a side
            mine = mine[(np.arange(_SEAM_PIXELS) * _GOLDEN % 1 * len(mine)).astype(int)]
        gaps = np.empty(len(mine))
        return gaps[: gaps_px(labels, mine, means, *looks, gaps)], scale

    @cached_property
    def _reach_px(self) -> int:
        return int(np.ceil(self._config.reach_px))

    @cached_property
    def _borders(self) -> tuple[NDArray[np.int64], NDArray[np.uint8]]:
        """Indices in `padded_labels` of the pixels where a label ends, all in a seam's reach in the image; and their
        labels."""
        (height, width), around, edge = self.codes.shape, np.ones((3, 3), np.uint8), self._reach_px + 1
        labels = self.padded_labels.reshape(height + 2, width + 2)
        ends = cv2.compare(cv2.dilate(labels, around), cv2.erode(labels, around), cv2.CMP_NE)
        ends[:edge], ends[-edge:], ends[:, :edge], ends[:, -edge:] = 0, 0, 0, 0
        flags, borders = ends.ravel(), np.empty(cv2.countNonZero(ends), np.int64)
        marked(flags, flags[: len(flags) // 8 * 8].view(np.uint64), borders)  # many times as fast as numpy's
        return borders, self.padded_labels[borders]

    @property
    def unowned(self) -> LabelField:
        """The same image before anybody owned some of its pixels."""
        return self._before or self

    def without(self, solids: Sequence[NDArray[np.float32]], *, nearer: bool = False) -> LabelField:
        """The same image with the pixels in convex hulls of points (n, 2) owned by somebody.

        :param nearer: who lies before what is looked for: where it ends, that does not.
        """
        height, width = self.codes.shape
        bordered, far = self.padded.reshape(height + 2, width + 2).copy(), 4 * max(height, width)
        codes = bordered[1:-1, 1:-1]
        points = np.minimum(np.maximum(np.concatenate(solids), -far), far)
        fine = np.rint(points * (1 << _SUBPIXEL_BITS)).astype(np.int32)
        for first, last in pairwise([0, *accumulate(map(len, solids))]):
            cv2.fillConvexPoly(codes, cv2.convexHull(fine[first:last]), OWNED, shift=_SUBPIXEL_BITS)
        rest = copy(self)  # with its seams, which are the segmenter's, not the objects'
        rest.codes, rest.padded, rest._before = codes, bordered.ravel(), self.unowned
        rest.hides = nearer
        for made in ("labels", "padded_labels", "_borders"):
            rest.__dict__.pop(made, None)
        return rest
