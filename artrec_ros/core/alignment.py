"""Tolerance area and matching: how much of a placed outline lies on a frame's contours (paper, steps 3 and 4).

A similarity is a complex pair (t, z): p -> t + z p, with pixels x + iy, z = k exp(i theta).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .compiled import agreement as compiled
from .compiled.jit import COMPILED
from .config import RecognizerConfig
from .contour_map import STEPS_PER_PX, ContourMap
from .deadline import Deadline
from .shapes import SAMPLES, Shape, pack_shapes

_CHUNK = 8192  # hypotheses a batch; cv2.remap takes fewer than 32767 rows
_NORMAL_AGREEMENT = 0.6  # cosine


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
        return Placements(**{**self.__dict__, **arrays})

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
    tolerance = tolerance_px(placed.area_px(shapes), config)
    return Evidence(
        *compiled.evidence(
            cmap.contours,
            pack_shapes(tuple(shapes)),
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
