"""Blobs of a label image, their external contours and anchor points (paper, steps 1 and 2)."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate

import cv2
import numpy as np
from numpy.typing import NDArray

from .compiled.jit import COMPILED
from .compiled.outlining import outlines
from .config import RecognizerConfig
from .deadline import Deadline
from .transforms import Array

_CROWD_ROWS = 8  # every so many-th is looked at
_CROWDED = 0.05  # changes between neighbours in a row, as a share of its pixels


@dataclass(frozen=True)
class Blob:
    """A connected set of pixels of one class, seen through its external contour; holes are ignored.

    :param pixels: (n, 2) int, the outermost pixels' centres, ordered so that the inside lies on the same
        side as in `Shape` (positive shoelace sum in x right, y down).
    :param contour: (n, 2) the same, moved out to where the edge is (half a pixel, see `subpixel_contour`).
    :param normals: (n, 2) unit outward normals; zero where the contour doubles back on itself.
    :param cut: (n,) bool, points where not the blob but the image or an ignored rectangle ends: no evidence.
    :param area_px: pixels enclosed, holes included.
    """

    label: int
    pixels: NDArray[np.int32]
    contour: Array
    normals: Array
    cut: NDArray[np.bool_]
    area_px: float

    @cached_property
    def polygon(self) -> NDArray[np.float32]:
        """(n, 1, 2) the contour as OpenCV takes it."""
        return self.contour.astype(np.float32)[:, None]


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
        if _is_crowded(mask):
            mask = _without_specks(mask, config.min_blob_px)
        chains = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
        found += [(area, label, chain) for area, chain in _large_enough(chains, config)]
    if len(found) > config.max_blobs:
        found = sorted(found, key=lambda f: -f[0])[: config.max_blobs]
    found.sort(key=lambda f: (f[1], -f[0]))
    rectangles = np.array(blank, np.int64).reshape(-1, 4)
    if COMPILED and found:
        return _blobs_compiled(found, labels.shape, rectangles)
    return tuple(_blob(chain[:, 0], label, area, labels.shape, rectangles) for area, label, chain in found)


def _is_crowded(mask: NDArray[np.uint8]) -> bool:
    """Whether a mask (H, W) changes so often along its rows that most of its blobs must be specks."""
    rows = mask[::_CROWD_ROWS]
    return cv2.countNonZero(rows[:, 1:] ^ rows[:, :-1]) > _CROWDED * rows.size


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


def _blobs_compiled(
    found: list[tuple[float, int, NDArray[np.int32]]], shape: tuple[int, ...], blank: NDArray[np.int64]
) -> tuple[Blob, ...]:
    first = [0, *accumulate(len(chain) for _, _, chain in found)]
    chains = np.concatenate([chain for _, _, chain in found])[:, 0]
    pixels, contour, normals, cut = outlines(chains, np.array(first), shape[1], shape[0], blank)
    return tuple(
        Blob(label, pixels[i:j], contour[i:j], normals[i:j], cut[i:j], area)
        for (area, label, _), i, j in zip(found, first, first[1:], strict=False)
    )


def _blob(
    pixels: NDArray[np.int32], label: int, area_px: float, shape: tuple[int, ...], blank: NDArray[np.int64]
) -> Blob:
    """:param blank: (r, 4)."""
    x, y = pixels.T.astype(np.int64)
    if np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y) < 0:
        pixels = pixels[::-1]
    contour, normals = subpixel_contour(pixels)
    return Blob(label, pixels, contour, normals, _cut_points(pixels, shape, blank), area_px)


def _cut_points(pixels: NDArray[np.int32], shape: tuple[int, ...], blank: NDArray[np.int64]) -> NDArray[np.bool_]:
    x, y = pixels.T
    cut = (x == 0) | (y == 0) | (x == shape[1] - 1) | (y == shape[0] - 1)
    for bx, by, bw, bh in blank:
        cut |= (x >= bx - 1) & (x <= bx + bw) & (y >= by - 1) & (y <= by + bh)
    return np.asarray(cut)


def subpixel_contour(pixels: NDArray[np.int32]) -> tuple[Array, Array]:
    """Contour and outward normals of a chain of boundary pixels.

    A chain runs through pixel centres, so a shape is measured too small. Its true edge is off by half a
    pixel along the axis on which the edge is steeper: 0.5 max(|nx|, |ny|) along the normal.

    :param pixels: (n, 2), inside as in `Blob.pixels`.
    :return: (n, 2) points and (n, 2) unit normals (zero where undefined).
    """
    p = pixels.astype(np.float64)
    reach = int(np.clip(len(p) // 12, 1, 5))
    # Differences over several spans smooth the staircase of a chain code.
    around = np.concatenate([p[-reach:], p, p[:reach]])
    d = np.zeros_like(p)
    for s in range(1, reach + 1):
        d += around[reach + s : len(p) + reach + s] - around[reach - s : len(p) + reach - s]
    length = np.hypot(d[:, 0], d[:, 1])[:, None]
    normals = np.where(length > 1e-9, np.stack([d[:, 1], -d[:, 0]], axis=1) / np.maximum(length, 1e-9), 0.0)
    # The nearest of a staircase's points is one of its outer steps; smoothed, it lies on the mean again.
    smooth = 0.25 * around[reach - 1 : len(p) + reach - 1] + 0.5 * p + 0.25 * around[reach + 1 : len(p) + reach + 1]
    return smooth + 0.5 * np.abs(normals).max(axis=1, keepdims=True) * normals, normals


def anchor_points(contour: Array, tolerance: float) -> Array:
    """(a, 2) anchors: split-based polygonal approximation of a closed contour (Pavlidis; Ramer-Douglas-Peucker)."""
    return _approximated(contour.astype(np.float32)[:, None], tolerance)


def _approximated(polygon: NDArray[np.float32], tolerance: float) -> Array:
    return cv2.approxPolyDP(polygon, tolerance, True)[:, 0].astype(np.float64)


def blob_anchors(blob: Blob, config: RecognizerConfig) -> list[Array]:
    """Anchors of a blob at each configured tolerance, at most `max_anchors` each.

    Small patches need two tolerances at once, large silhouettes one that grows with the root of their area.
    """
    polygons = []
    grown = config.anchor_tolerance_share * math.sqrt(blob.area_px)
    for base in config.anchor_tolerances_px:
        tolerance = max(base, base * grown)
        anchors = _approximated(blob.polygon, tolerance)
        while len(anchors) > config.max_anchors:
            tolerance *= 1.5
            anchors = _approximated(blob.polygon, tolerance)
        polygons.append(anchors)
    return polygons
