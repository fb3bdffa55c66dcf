"""How far a class goes on beyond the outlines that axes mark: what is painted, or shines, is larger than they are."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..base.config import ImageConfig, LearningConfig
from ..geometry.polygons import signed_area
from ..geometry.transforms import Array
from ..image.segmentation import Segmenter

_FAR_PX = 6.0  # so far outwards it is followed at least: a plate, or a floor of its colour, goes on there
_STEP_PX = 0.25  # labels are of whole pixels, and rays begin anywhere between two
_LEAST_PX = 0.7  # a narrower ring may be none: clicks and pixels are half a pixel off
_SIDES, _LEAST_SIDES = 4, 3  # what lies beside a marker is not on all sides of it; one may be hidden by another marker
_EVEN = 1 / 3  # of its width it has on each side at least: what moves is wider along its way
_FAR = LearningConfig.beside_share  # of a marker's width, where that is more: what lies beside it is told as that
_ENDS = 0.9  # of the rays on which it must end: else it is what lies there

Outlines = Sequence[tuple[str, Array]]  # class, (n, 2) pixels
Seen = tuple[NDArray[np.uint8], NDArray[np.uint8], Outlines]


def rings_px(image: ImageConfig, seen: Iterable[Seen]) -> dict[str, float]:
    """Classes that go on beyond their outlines all around and end there, and how far, pixels: their outlines are
    smaller than what is painted. The median around a marker, and of markers.

    :param seen: colour images (H, W, 3) as they are read, (H, W) numbers of what is marked, 0: nothing, and outlines.
    """
    segmenter, found = Segmenter(image), defaultdict[str, list[tuple[Array, Array, NDArray[np.bool_]]]](list)
    for pixels, numbers, outlines in seen:
        labels = segmenter.labels(pixels)
        for name, outline in outlines:
            far_px = max(_FAR_PX, _FAR * abs(signed_area(outline)) ** 0.5)
            reaches, normals = _reaches(labels == image.classes[name].label, numbers == 0, outline, far_px)
            if len(reaches):
                found[name].append((_centred(reaches, normals), normals, reaches < far_px))
    rings = {}
    for name, own in found.items():
        width = float(np.median([np.median(centred) for centred, _, _ in own]))
        centred, normals, ends = (np.concatenate(parts) for parts in zip(*own, strict=True))
        if width >= _LEAST_PX and ends.mean() >= _ENDS and _is_all_around(centred, normals, _EVEN * width):
            rings[name] = width
    return rings


def _is_all_around(reaches: Array, normals: Array, least: float) -> bool:
    """Whether a class goes on for so much to each side, by reaches (n,) outwards along normals (n, 2)."""
    side = _sides(normals)
    medians = [np.median(reaches[side == s]) for s in np.unique(side)]
    return len(medians) >= _LEAST_SIDES and bool(min(medians) >= least)


def _sides(normals: Array) -> NDArray[np.int64]:
    """(n,) to which side normals (n, 2) point."""
    return np.rint(np.arctan2(normals[:, 1], normals[:, 0]) / (2 * np.pi / _SIDES)).astype(np.int64) % _SIDES


def _centred(reaches: Array, normals: Array) -> Array:
    """(n,) how far a class would reach if its marker lay amid it: what a shift makes on one side it takes on the
    other; as it is where a side is missing."""
    if len(np.unique(_sides(normals))) < _SIDES:
        return reaches
    level_and_shift = np.linalg.lstsq(np.column_stack([np.ones(len(reaches)), normals]), reaches, rcond=None)[0]
    return np.asarray(reaches - normals @ level_and_shift[1:])


def _reaches(own: NDArray[np.bool_], free: NDArray[np.bool_], outline: Array, far_px: float) -> tuple[Array, Array]:
    """(n,) pixels from points of an outline, a pixel apart, outwards to where the class ends, below 0 where it does so
    within, and the normals (n, 2) there; of those before which nobody has marked anything."""
    points, normals = _points(outline)
    count = round(far_px / _STEP_PX)
    steps = _STEP_PX * np.arange(-count, count + 1)
    at = np.rint(points[:, None] + steps[:, None] * normals[:, None]).astype(int)
    height, width = own.shape
    inside = np.all((at >= 0) & (at < (width, height)), axis=(1, 2))
    x, y = np.moveaxis(at[inside], 2, 0)
    clear = free[y, x][:, steps > 1.0].all(axis=1)  # a pixel on the outline may be the marker's own
    there, first = own[y, x][clear], int(np.argmax(steps >= 0))
    ends = np.argmin(np.column_stack([there[:, first:], np.zeros(len(there), bool)]), axis=1)
    begins = np.argmax(np.column_stack([there[:, first::-1], np.ones(len(there), bool)]), axis=1)
    return _STEP_PX * np.where(there[:, first], ends, -begins), normals[inside][clear]


def _points(outline: Array) -> tuple[Array, Array]:
    """(n, 2) points on the sides of an outline, a pixel apart or less, and the (n, 2) outward normals there."""
    begin, side = outline, np.roll(outline, -1, axis=0) - outline
    size = np.linalg.norm(side, axis=1)
    turning = np.sign(np.sum(begin[:, 0] * np.roll(begin[:, 1], -1) - begin[:, 1] * np.roll(begin[:, 0], -1)))
    counts = np.ceil(size).astype(int)
    of = np.repeat(np.arange(len(outline)), counts)
    share = np.concatenate([(np.arange(n) + 0.5) / n for n in counts.tolist()])
    normal = turning * np.stack([side[:, 1], -side[:, 0]], axis=1) / np.maximum(size, 1e-9)[:, None]
    return begin[of] + share[:, None] * side[of], normal[of]
