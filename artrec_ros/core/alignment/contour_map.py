"""Distances to, and nearest points of, all contours of a frame (paper, step 3).

All contours share one atlas: per class one slot of the same size, stacked. Complex numbers hold x + iy, pixels.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import accumulate

import numpy as np
from numpy.typing import NDArray

from ..image.blobs import Blob
from .agreement_kernels import stretches
from .counting_kernels import Field
from .nearest_kernels import bounding_boxes, fill_atlas, hull
from .refinement_kernels import Contours

_STEPS_PER_PX = 15.0  # of the quantised distance: 255 stands for 17 px and more
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
        fill_atlas(pixels, cut, first, slot, boxes, _STEPS_PER_PX, _MOST_BOXES, distance, nearest)
        points = _as_complex([*(b.contour for b in blobs), np.full((1, 2), -1e6)])
        normals = _as_complex([*(b.normals for b in blobs), np.zeros((1, 2))])
        blob = np.repeat(np.array([*range(len(blobs)), -1], np.int32), [*count, 1])
        maps = distance.reshape(-1, w), nearest.reshape(-1, w)
        return cls(*maps, points, normals, blob, slots, (left, top), h, image_size)

    @property
    def field(self) -> Field:
        """The distances as compiled code takes them."""
        return Field(self.distance, *self.origin, self.height, _STEPS_PER_PX)

    @cached_property
    def contours(self) -> Contours:
        """The nearest points as compiled code takes them."""
        edge = np.empty((len(self.points), 2), complex)
        edge[:, 0], edge[:, 1] = self.points - complex(*self.origin), self.normals
        return Contours(self.nearest, edge.view(np.float64), *self.origin, self.height)

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
