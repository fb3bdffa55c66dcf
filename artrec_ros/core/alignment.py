"""Tolerance area and matching: how much of a placed outline lies on a frame's contours (paper, steps 3 and 4).

All contours of a frame share one atlas: per class one slot of the same size, stacked. A similarity is
a complex pair (t, z): p -> t + z p, with pixels x + iy, z = k exp(i theta).
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from .blobs import Blob
from .compiled import contour_fit as compiled
from .compiled.jit import COMPILED
from .compiled.outlining import merge_boxes
from .config import RecognizerConfig
from .deadline import Deadline
from .shapes import SAMPLES, Shape, pack_shapes

_MARGIN_PX = 16
STEPS_PER_PX = 15.0  # of the quantised distance: 255 stands for 17 px and more
_MOST_BOXES = 64  # are looked at one by one
_CHUNK = 8192  # hypotheses a batch; cv2.remap takes fewer than 32767 rows
_NORMAL_AGREEMENT = 0.6  # cosine


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
        count = np.array([len(b.pixels) for b in blobs])
        starts = np.cumsum(count) - count
        pixels = np.concatenate([b.pixels for b in blobs])
        cut = np.concatenate([b.cut for b in blobs])
        boxes = np.concatenate(  # of each blob: left, top, right, bottom, with a margin
            [
                np.minimum.reduceat(pixels, starts) - _MARGIN_PX,
                np.maximum.reduceat(pixels, starts) + _MARGIN_PX + 1,
            ],
            axis=1,
        ).astype(np.int64)
        low, high = boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)
        w, h = (high - low).tolist()
        labels = np.array([b.label for b in blobs])
        slots = {label: s for s, label in enumerate(sorted(set(labels.tolist())))}
        # One more point, far off, stands for "no contour here at all".
        points = _as_complex([*(b.contour for b in blobs), np.full((1, 2), -1e6)])
        normals = _as_complex([*(b.normals for b in blobs), np.zeros((1, 2))])
        blob = np.repeat(np.arange(len(blobs), dtype=np.int32), count)
        distance = np.full((len(slots) * h, w), 255, np.uint8)
        nearest = np.full((len(slots) * h, w), len(points) - 1, np.int32)
        for label, slot in slots.items():
            index = np.flatnonzero(~cut & (labels == label)[blob])
            rows = slice(slot * h, (slot + 1) * h)
            for box in _apart(boxes[labels == label]) - np.tile(low, 2):
                _fill_nearest(pixels[index] - low, index, box.tolist(), distance[rows], nearest[rows])
        origin = (int(low[0]), int(low[1]))
        return cls(distance, nearest, points, normals, np.append(blob, np.int32(-1)), slots, origin, h, image_size)

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

    @property
    def contours(self) -> compiled.Contours:
        """The nearest points as compiled code takes them."""
        return compiled.Contours(self.nearest, self.points, self.normals, *self.origin, self.height)

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
        count = np.bincount(self.blob[:-1])
        return compiled.stretches(index, self.blob, np.cumsum(count) - count, count, longest)


def _as_complex(parts: list[NDArray[np.float64]]) -> np.ndarray:
    return np.concatenate(parts).view(np.complex128)[:, 0]


def _apart(boxes: NDArray[np.int64]) -> NDArray[np.int64]:
    """Boxes that do not overlap, round all: what lies in one is nearest to, or far from, what is in it."""
    if len(boxes) <= _MOST_BOXES:
        return merge_boxes(boxes)
    return np.concatenate([boxes[:, :2].min(axis=0), boxes[:, 2:].max(axis=0)])[None]


def _fill_nearest(
    pixels: NDArray[np.int64],
    index: NDArray[np.int64],
    box: list[int],
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
    distance[top:bottom, left:right] = cv2.convertScaleAbs(dist, alpha=STEPS_PER_PX)
    nearest[top:bottom, left:right] = of_zone[zone]


def tolerance_px(area_px: np.ndarray | float, config: RecognizerConfig) -> np.ndarray:
    """How far a point may lie from the contour: `tolerance_px`, less on small shapes, where it would fit anything."""
    return np.clip(config.tolerance_share * np.sqrt(area_px), 1.0, max(1.0, config.tolerance_px))


Array1 = NDArray[np.float64]


@dataclass(frozen=True)
class Placements:
    """A batch of placed shapes: (H,) arrays; a shape's point p lies at t + z p + w conj(p).

    :param blob: the blob a placement came from; slot: its class' slot in the `ContourMap`.
    :param w: 0 for a similarity. A marker that is turned out of the image plane is seen squeezed: an affinity
        with singular values |z| + |w| and |z| - |w|, the first of them the scale.
    """

    t: np.ndarray
    z: np.ndarray
    shape: NDArray[np.int32]
    blob: NDArray[np.int32]
    slot: NDArray[np.int32]
    score: Array1
    w: np.ndarray

    def __len__(self) -> int:
        return len(self.t)

    def take(self, index: np.ndarray) -> Placements:
        return Placements(*(getattr(self, f)[index] for f in self.__dataclass_fields__))

    def replace(self, **arrays: np.ndarray) -> Placements:
        return dataclasses.replace(self, **arrays)

    @property
    def scale(self) -> Array1:
        """(H,) pixels per metre along the direction that no turn out of the plane shortens."""
        return np.abs(self.z) + np.abs(self.w)

    def area_px(self, shapes: list[Shape]) -> Array1:
        return np.array([s.area_m2 for s in shapes])[self.shape] * (np.abs(self.z) ** 2 - np.abs(self.w) ** 2)

    def where(self, points: np.ndarray) -> np.ndarray:
        """(H, m) image points of (H, m) or (m,) shape points, complex."""
        return self.t[:, None] + self.z[:, None] * points + self.w[:, None] * np.conj(points)

    def turned(self, normals: np.ndarray) -> np.ndarray:
        """(H, m) unit normals in the image of (H, m) shape normals: by the inverse transpose."""
        n = self.z[:, None] * normals - self.w[:, None] * np.conj(normals)
        return n / np.maximum(np.abs(n), 1e-12)

    @classmethod
    def similarities(
        cls, t: np.ndarray, z: np.ndarray, shape: NDArray[np.int32], blob: NDArray[np.int32], slot: NDArray[np.int32]
    ) -> Placements:
        return cls(t, z, shape, blob, slot, np.zeros(len(t)), np.zeros(len(t), complex))

    @classmethod
    def concatenate(cls, parts: list[Placements]) -> Placements:
        none = np.zeros(0, np.int32)
        empty = cls.similarities(np.zeros(0, complex), np.zeros(0, complex), none, none, none)
        return cls(*(np.concatenate([getattr(p, f) for p in [empty, *parts]]) for f in cls.__dataclass_fields__))


def matched_share(
    cmap: ContourMap,
    shapes: list[Shape],
    placed: Placements,
    config: RecognizerConfig,
    deadline: Deadline,
    step: int,
    tolerance: float | None = None,
) -> Array1:
    """(H,) share of each placed outline's points, every `step`-th one, inside the tolerance area.

    What the deadline leaves unread scores 0. `tolerance` in px overrides the size-dependent one.
    """
    share = np.zeros(len(placed))
    for s, shape in enumerate(shapes):
        mine = np.flatnonzero(placed.shape == s)
        points = shape.points[::step]
        for start in range(0, len(mine), _CHUNK):
            if deadline.expired:
                return share
            part = mine[start : start + _CHUNK]
            d = cmap.distances(placed.t[part], placed.z[part], placed.slot[part], points)
            tol = (
                tolerance_px(placed.take(part).area_px(shapes), config)
                if tolerance is None
                else np.full(len(part), tolerance)
            )
            share[part] = np.count_nonzero(d <= (tol * STEPS_PER_PX)[:, None], axis=1) / len(points)
    return share


@dataclass(frozen=True)
class Evidence:
    """How (K,) placed outlines agree with the contours.

    :param share: share of the outline that could be seen and is matched, normals agreeing.
    :param score: the same, with a point worth less the farther off it is (half at the tolerance).
    :param visible: share of the outline inside the image and outside ignored rectangles.
    :param matched: (K, m) index of the contour point that each of the outline's points matches; -1: none.
    """

    share: Array1
    score: Array1
    visible: Array1
    matched: NDArray[np.int32]

    def take(self, index: np.ndarray) -> Evidence:
        return Evidence(*(getattr(self, f)[index] for f in self.__dataclass_fields__))

    @classmethod
    def concatenate(cls, parts: list[Evidence]) -> Evidence:
        parts = [cls.none(), *parts]
        return cls(*(np.concatenate([getattr(p, f) for p in parts]) for f in cls.__dataclass_fields__))

    @classmethod
    def none(cls) -> Evidence:
        return cls(np.zeros(0), np.zeros(0), np.zeros(0), np.zeros((0, SAMPLES), np.int32))


def evidence(
    cmap: ContourMap, shapes: list[Shape], placed: Placements, config: RecognizerConfig, blank: tuple[int, ...] = ()
) -> Evidence:
    """Exact evidence for a few placements: sub-pixel distances and normals at every point."""
    if not len(placed):
        return Evidence.none()
    if COMPILED:
        return _evidence_compiled(cmap, shapes, placed, config, blank)
    points = np.stack([s.points for s in shapes])[placed.shape]  # (K, m)
    normals = np.stack([s.normals for s in shapes])[placed.shape]
    where = placed.where(points)
    index = cmap.nearest_index(where, placed.slot)
    off = np.abs(where - cmap.points[index])
    agree = np.real(np.conj(placed.turned(normals)) * cmap.normals[index]) >= _NORMAL_AGREEMENT
    tol = tolerance_px(placed.area_px(shapes), config)[:, None]
    matched = agree & (off <= tol)
    seen = _in_view(where, cmap.image_size, blank)
    count = np.maximum(seen.sum(axis=1), 1)
    worth = np.where(matched & seen, 1 - 0.5 * (off / tol) ** 2, 0.0)
    share = (matched & seen).sum(axis=1) / count
    return Evidence(share, worth.sum(axis=1) / count, seen.mean(axis=1), np.where(matched, index, -1))


def _evidence_compiled(
    cmap: ContourMap, shapes: list[Shape], placed: Placements, config: RecognizerConfig, blank: tuple[int, ...]
) -> Evidence:
    packed = pack_shapes(tuple(shapes))
    tolerance = tolerance_px(placed.area_px(shapes), config)
    return Evidence(
        *compiled.evidence(
            cmap.contours,
            packed.points,
            packed.normals,
            placed.t,
            placed.z,
            placed.w,
            placed.shape,
            placed.slot,
            tolerance,
            _NORMAL_AGREEMENT,
            cmap.image_size,
            np.array(blank, float),
        )
    )


def _in_view(where: np.ndarray, size: tuple[int, int], blank: tuple[int, ...]) -> NDArray[np.bool_]:
    # The last row of pixels tells nothing of an edge there: a blob cut by the border ends on it too.
    x, y = where.real, where.imag
    seen = (x > 0.5) & (y > 0.5) & (x < size[0] - 1.5) & (y < size[1] - 1.5)
    for bx, by, bw, bh in np.reshape(blank, (-1, 4)):
        seen &= (x < bx - 1.5) | (x > bx + bw + 0.5) | (y < by - 1.5) | (y > by + bh + 0.5)
    return np.asarray(seen)
