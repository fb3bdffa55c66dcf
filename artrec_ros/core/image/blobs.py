"""Blobs of a label image, their external contours and anchor points (paper, steps 1 and 2)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate, compress
from operator import not_
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..base.deadline import Deadline
from ..geometry.transforms import Array
from .contour_kernels import outlines

_CROWD_ROWS = 8  # every so many-th is looked at
_CROWDED = 0.05  # changes between neighbours in a row, as a share of its pixels: decides on the time alone
_FEW_CHANGES = 2_000  # in all rows: so few leave no room for many pinholes, and contours are drawn with them at once
_LEAST_AROUND = 8  # pixels of a hole that has something in it
_FEW_IN_HOLES = 2_000  # pixels: of more pinholes OpenCV takes longer to tell what lies in which than to label all parts
_COARSER = 1.5  # from one tolerance to the next that is tried


@dataclass(frozen=True)
class Blob:
    """A connected set of pixels of one class, seen through its external contour; holes are ignored.

    :param pixels: (n, 2) int, the outermost pixels' centres, ordered so that the inside lies on the same
        side as in `Shape` (positive shoelace sum in x right, y down).
    :param contour: (n, 2) the same, moved out to where the edge is (half a pixel, see `contour_kernels.outlines`).
    :param normals: (n, 2) unit outward normals; zero where the contour doubles back on itself.
    :param cut: (n,) bool, points where not the blob but the image or an ignored rectangle ends: no evidence.
    :param area_px: pixels enclosed, holes included.
    :param box: (2, 2) least and greatest x, y of its pixels.
    """

    label: int
    pixels: NDArray[np.int32]
    contour: Array
    normals: Array
    cut: NDArray[np.bool_]
    area_px: float
    box: NDArray[np.int64]

    @cached_property
    def notes(self) -> dict[object, Any]:
        """What others worked out of it, by who it is that did, as long as its image is looked at."""
        return {}

    @cached_property
    def polygon(self) -> NDArray[np.float32]:
        """(n, 1, 2) the contour as OpenCV takes it."""
        return self.contour.astype(np.float32)[:, None]

    @cached_property
    def middle(self) -> Array:
        """(2,) of its contour, pixels."""
        # its `mean` takes thrice as long
        return np.asarray(np.add.reduce(self.contour) / len(self.contour), np.float64)


def centres(blobs: Sequence[Blob]) -> Array:
    """(n, 2) the middles of blobs' contours, pixels."""
    return np.array([b.middle for b in blobs]).reshape(-1, 2)


def solidity(outline: Array) -> float:
    """The share of its convex hull that a polygon (n, 2) fills."""
    points = np.asarray(outline, np.float32)
    hull = cv2.contourArea(cv2.convexHull(points))
    return cv2.contourArea(points) / hull if hull > 0 else 1.0


def find_blobs(
    labels: NDArray[np.uint8],
    wanted: Iterable[int],
    config: RecognizerConfig,
    blank: tuple[int, ...] = (),
    deadline: Deadline | None = None,
) -> tuple[Blob, ...]:
    """Blobs of the wanted classes, the largest `max_blobs` of them, by label and then from large to small.

    :param labels: (H, W) class number per pixel.
    :param blank: ignored rectangles x,y,width,height,...: a contour along them is no evidence.
    :param deadline: classes that it leaves are not looked at.
    """
    found: list[tuple[float, int, NDArray[np.int32]]] = []  # pixels enclosed, label, chain
    for label in sorted(set(wanted)):
        if deadline is not None and deadline.expired:
            break
        mask = (labels == label).view(np.uint8)
        if (crowd := _crowd(mask)) > _CROWDED:
            mask = _without_specks(mask, config.min_blob_px)
        chains = _outer_chains(mask, config.min_blob_px, crowd)
        found += [(area, label, chain) for area, chain in _large_enough(chains, config)]
    if len(found) > config.blobs.max_blobs:
        found = sorted(found, key=lambda f: -f[0])[: config.blobs.max_blobs]
    found.sort(key=lambda f: (f[1], -f[0]))
    return _outlined(found, labels.shape, np.array(blank, np.int64).reshape(-1, 4)) if found else ()


def _outer_chains(mask: NDArray[np.uint8], least_px: float, crowd: float) -> list[NDArray[np.int32]]:
    """The external contours (n, 1, 2) of all that is set in a mask (H, W), what lies in another one's hole included, as
    far as it has so many pixels: a red border around the scene hides no red robot. :param crowd: see `_crowd`."""
    if crowd * mask.size < _FEW_CHANGES:
        chains, holes = _chains_of_all(mask)
        if sum(map(cv2.contourArea, holes)) < _FEW_IN_HOLES:
            return chains
    chains = list(cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0])
    enclosed = sum(map(cv2.contourArea, chains)) + sum(map(len, chains)) / 2 + len(chains)  # see `_pixels_enclosed`
    in_holes = enclosed - cv2.countNonZero(mask)
    if in_holes < _LEAST_AROUND:
        return chains
    if in_holes < _FEW_IN_HOLES:
        return _chains_of_all(mask)[0]
    _, part, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    inner = stats[:, cv2.CC_STAT_AREA] >= least_px
    inner[[0, *(part[chain[0, 0, 1], chain[0, 0, 0]] for chain in chains)]] = False
    return chains + _chains_of_all(inner.view(np.uint8)[part])[0] if inner.any() else chains


def _chains_of_all(mask: NDArray[np.uint8]) -> tuple[list[NDArray[np.int32]], list[NDArray[np.int32]]]:
    """The external contours of all that is set in a mask, be it in others' holes; and the holes'."""
    each, nesting = cv2.findContours(mask, cv2.RETR_CCOMP, cv2.CHAIN_APPROX_NONE)
    inside = [parent >= 0 for parent in nesting[0, :, 3].tolist()] if each else []
    return list(compress(each, map(not_, inside))), list(compress(each, inside))


def _crowd(mask: NDArray[np.uint8]) -> float:
    """How often a mask (H, W) changes along its rows, as a share of its pixels: where that is often, most of its blobs
    must be specks."""
    rows = mask[::_CROWD_ROWS]
    return cv2.countNonZero(rows[:, 1:] ^ rows[:, :-1]) / max(rows.size, 1)


def _without_specks(mask: NDArray[np.uint8], least_px: float) -> NDArray[np.uint8]:
    """A mask (H, W) without the blobs whose bounding box is too small to enclose so many pixels.

    The contours of very many of them would take longer than this; of few, it is the other way round.
    """
    _, blob, stats, _ = cv2.connectedComponentsWithStats(mask, connectivity=8)
    large = stats[:, cv2.CC_STAT_WIDTH] * stats[:, cv2.CC_STAT_HEIGHT] >= least_px
    large[0] = False  # the background
    return large.view(np.uint8)[blob]


def _large_enough(
    chains: Sequence[NDArray[np.int32]], config: RecognizerConfig
) -> list[tuple[float, NDArray[np.int32]]]:
    # n pixels of a contour enclose most as a diamond, n^2 / 8 + n / 2 + 1: most specks are sorted out by their length.
    least = max(4, int(math.sqrt(8 * max(config.min_blob_px, 1) - 4)) - 2)
    measured = [(_pixels_enclosed(c), c) for c in chains if len(c) >= least]
    return [m for m in measured if m[0] >= config.min_blob_px]


def _pixels_enclosed(chain: NDArray[np.int32]) -> float:
    """Pick's theorem: a lattice polygon of area A with n boundary points holds A + n/2 + 1 points."""
    return cv2.contourArea(chain) + len(chain) / 2 + 1


def _outlined(
    found: list[tuple[float, int, NDArray[np.int32]]], shape: tuple[int, ...], blank: NDArray[np.int64]
) -> tuple[Blob, ...]:
    first = [0, *accumulate(len(chain) for _, _, chain in found)]
    chains = np.concatenate([chain for _, _, chain in found])[:, 0]
    pixels, contour, normals, cut = outlines(chains, np.array(first), shape[1], shape[0], blank)
    ends = [of.reduceat(pixels, first[:-1]) for of in (np.minimum, np.maximum)]
    boxes = np.stack(ends, axis=1).astype(np.int64)
    return tuple(
        Blob(label, pixels[i:j], contour[i:j], normals[i:j], cut[i:j], area, box)
        for (area, label, _), box, i, j in zip(found, boxes, first, first[1:], strict=False)
    )


def anchor_points(contour: Array, tolerance: float) -> Array:
    """(a, 2) anchors: split-based polygonal approximation of a closed contour (Pavlidis; Ramer-Douglas-Peucker)."""
    return _approximated(contour.astype(np.float32)[:, None], tolerance)


def _approximated(polygon: NDArray[np.float32], tolerance: float) -> Array:
    return cv2.approxPolyDP(polygon, tolerance, True)[:, 0].astype(np.float64)


def blob_anchors(blob: Blob, config: RecognizerConfig) -> list[Array]:
    """Anchors of a blob at each configured tolerance, at most `max_anchors` each."""
    polygons = []
    for tolerance in config.blobs.tolerances_px(blob.area_px):
        anchors = _approximated(blob.polygon, tolerance)
        while len(anchors) > config.blobs.max_anchors:
            tolerance *= _COARSER
            anchors = _approximated(blob.polygon, tolerance)
        polygons.append(anchors)
    return polygons
