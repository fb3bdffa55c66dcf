"""Distances to, and nearest points of, all contours of a frame (paper, step 3).

All contours share one atlas: per class one slot of the same size, stacked. Complex numbers hold x + iy, pixels.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate

import cv2
import numpy as np
from numpy.typing import NDArray

from .blobs import Blob
from .compiled.agreement import stretches
from .compiled.contour_fit import Contours
from .compiled.jit import COMPILED
from .compiled.nearest import bounding_boxes, fill_atlas, hull
from .compiled.outlining import merge_boxes

STEPS_PER_PX = 15.0  # of the quantised distance: 255 stands for 17 px and more
_MARGIN_PX = 16
_MOST_BOXES = 64  # are looked at one by one


@dataclass(frozen=True)
class ContourMap:
    """Distances to, and nearest points of, the contours of a frame.

    :param distance: (slots * h, w) uint8, 1/15 px to the nearest contour pixel of the slot's class.
    :param nearest: (slots * h, w) int32, index of that contour point.
    :param points, normals: (P,) complex, all blobs' contour points and outward normals.
    :param blob: (P,) index of the blob of each point.
    :param slots: class label -> slot.
    """

    distance: NDArray[np.uint8]
    nearest: NDArray[np.int32]
    points: np.ndarray
    normals: np.ndarray
    blob: NDArray[np.int32]
    slots: dict[int, int]
    origin: tuple[int, int]
    height: int
    image_size: tuple[int, int]

    @classmethod
    def build(cls, blobs: tuple[Blob, ...], image_size: tuple[int, int]) -> ContourMap:
        """:param image_size: (width, height) of the image."""
        labels = [b.label for b in blobs]
        slots = {label: s for s, label in enumerate(sorted(set(labels)))}
        slot = np.array([slots[label] for label in labels])
        count = [len(b.pixels) for b in blobs]
        first = np.array([0, *accumulate(count)])
        pixels = np.concatenate([b.pixels for b in blobs])
        cut = np.concatenate([b.cut for b in blobs])
        boxes = bounding_boxes(pixels, first, _MARGIN_PX)
        left, top, right, bottom = hull(boxes)[0].tolist()
        w, h = right - left, bottom - top
        pixels, boxes = pixels - np.array([left, top], np.int32), boxes - np.array([left, top, left, top])
        distance = np.full((len(slots), h, w), 255, np.uint8)
        # One more point, far off, stands for "no contour here at all".
        nearest = np.full((len(slots), h, w), len(pixels), np.int32)
        fill = fill_atlas if COMPILED else _fill_in_numpy
        fill(pixels, cut, first, slot, boxes, STEPS_PER_PX, _MOST_BOXES, distance, nearest)
        points = _as_complex([*(b.contour for b in blobs), np.full((1, 2), -1e6)])
        normals = _as_complex([*(b.normals for b in blobs), np.zeros((1, 2))])
        blob = np.repeat(np.array([*range(len(blobs)), -1], np.int32), [*count, 1])
        maps = distance.reshape(-1, w), nearest.reshape(-1, w)
        return cls(*maps, points, normals, blob, slots, (left, top), h, image_size)

    def distances(self, t: np.ndarray, z: np.ndarray, slot: np.ndarray, points: np.ndarray) -> NDArray[np.uint8]:
        """(H, m) quantised distance of every placed point: one look-up for the whole batch.

        :param t, z, slot: (H,) placements and the class slot each is looked up in.
        :param points: (m,) complex shape points.
        """
        where = z[:, None].astype(np.complex64) * points[None].astype(np.complex64)
        where += (t - complex(*self.origin))[:, None].astype(np.complex64)
        maps = where.view(np.float32).reshape(*where.shape, 2)
        np.clip(maps[..., 1], -0.4, self.height - 0.6, out=maps[..., 1])
        maps[..., 1] += (slot * self.height)[:, None].astype(np.float32)
        return cv2.remap(self.distance, maps, None, cv2.INTER_NEAREST, borderMode=cv2.BORDER_CONSTANT, borderValue=255)

    @cached_property
    def contours(self) -> Contours:
        """The nearest points as compiled code takes them."""
        edge = np.empty((len(self.points), 2), complex)
        edge[:, 0], edge[:, 1] = self.points - complex(*self.origin), self.normals
        return Contours(self.nearest, edge.view(np.float64), *self.origin, self.height)

    def nearest_index(self, where: np.ndarray, slot: np.ndarray) -> NDArray[np.int32]:
        """(K, m) index of the contour point nearest to (K, m) complex image points."""
        x = np.clip(np.rint(where.real - self.origin[0]), 0, self.nearest.shape[1] - 1).astype(np.intp)
        y = np.clip(np.rint(where.imag - self.origin[1]), 0, self.height - 1).astype(np.intp)
        return np.take(self.nearest, (y + (slot * self.height)[:, None]) * self.nearest.shape[1] + x)

    def stretches(self, index: NDArray[np.int32], longest: int) -> NDArray[np.int32]:
        """Indices, ascending, of contour points and of all that lie between one and the next on the same contour,
        where these are no more than `longest` points apart.

        :param index: (m,) contour points in the order of the contour; -1 for none.
        """
        return stretches(index, self.blob, self._first, self.lengths, longest)

    @cached_property
    def lengths(self) -> NDArray[np.int64]:
        """(B,) points of each blob's contour."""
        return np.bincount(self.blob[:-1])

    @cached_property
    def _first(self) -> NDArray[np.int64]:
        return np.cumsum(self.lengths) - self.lengths


def _as_complex(parts: list[NDArray[np.float64]]) -> np.ndarray:
    return np.concatenate(parts).view(np.complex128)[:, 0]


def _fill_in_numpy(
    pixels: NDArray[np.int32],
    cut: NDArray[np.bool_],
    first: NDArray[np.int64],
    slot: NDArray[np.int64],
    boxes: NDArray[np.int64],
    steps_per_px: float,
    most_boxes: int,
    distance: NDArray[np.uint8],
    nearest: NDArray[np.int32],
) -> None:
    """As `fill_atlas`."""
    slot_of_point = np.repeat(slot, np.diff(first))
    for s in range(len(distance)):
        mine, index = boxes[slot == s], np.flatnonzero(~cut & (slot_of_point == s))
        # Boxes that do not overlap, round all: what lies in one is nearest to, or far from, what is in it.
        for box in merge_boxes(mine) if len(mine) <= most_boxes else hull(mine):
            _fill_nearest(pixels[index], index, box.tolist(), steps_per_px, distance[s], nearest[s])


def _fill_nearest(
    pixels: NDArray[np.int32],
    index: NDArray[np.int64],
    box: list[int],
    steps_per_px: float,
    distance: NDArray[np.uint8],
    nearest: NDArray[np.int32],
) -> None:
    """Write distances to, and indices of, the nearest of the pixels into one box of a slot."""
    left, top, right, bottom = box
    x, y = pixels.T
    inside = (x >= left) & (x < right) & (y >= top) & (y < bottom)
    x, y = x[inside] - left, y[inside] - top
    if not len(x):
        return
    canvas = np.full((bottom - top, right - left), 255, np.uint8)
    canvas[y, x] = 0
    dist, zone = cv2.distanceTransformWithLabels(canvas, cv2.DIST_L2, 5, labelType=cv2.DIST_LABEL_PIXEL)
    of_zone = np.zeros(len(x) + 1, np.int32)
    of_zone[zone[y, x]] = index[inside]
    distance[top:bottom, left:right] = cv2.convertScaleAbs(dist, alpha=steps_per_px)
    nearest[top:bottom, left:right] = of_zone[zone]
