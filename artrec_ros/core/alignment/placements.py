"""Tolerance area and matching: how much of a placed outline lies on a frame's contours (paper, steps 3 and 4).

A similarity is a complex pair (t, z): p -> t + z p, with pixels x + iy, z = k exp(i theta).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..base.config import AlignmentConfig, RecognizerConfig
from ..base.deadline import Deadline
from . import agreement_kernels as compiled
from .contour_map import ContourMap
from .counting_kernels import Tolerance, count_all
from .shapes import SAMPLES, Shape, pack_shapes

_CHUNK = 60_000  # hypotheses between looks at the clock: a few milliseconds


def tolerance_of(config: AlignmentConfig) -> Tolerance:
    """`tolerance_px`, less on small shapes, where it would fit anything."""
    least_px = config.least_tolerance_px
    return Tolerance(config.tolerance_share, least_px, max(least_px, config.tolerance_px))


def tolerance_px(area_px: np.ndarray | float, config: AlignmentConfig) -> np.ndarray:
    """How far a point may lie from the contour."""
    share, least_px, most_px = tolerance_of(config)
    return np.minimum(np.maximum(share * np.sqrt(area_px), least_px), most_px)  # np.clip takes three times as long


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

    @property
    def packed(self) -> tuple[np.ndarray, ...]:
        """As compiled code takes them: t, z, w, shape, slot."""
        return self.t, self.z, self.w, self.shape, self.slot

    def area_px(self, shapes: list[Shape]) -> Array1:
        """(H,) of the shapes where they are placed, pixels."""
        return pack_shapes(tuple(shapes)).area[self.shape] * (np.abs(self.z) ** 2 - np.abs(self.w) ** 2)

    @classmethod
    def similarities(
        cls, t: np.ndarray, z: np.ndarray, shape: NDArray[np.int32], blob: NDArray[np.int32], slot: NDArray[np.int32]
    ) -> Placements:
        return cls(t, z, shape, blob, slot, np.zeros(len(t)), np.zeros(len(t), complex))

    @classmethod
    def concatenate(cls, parts: list[Placements]) -> Placements:
        """All, in order; of no parts none."""
        none = np.zeros(0, np.int32)
        empty = cls.similarities(np.zeros(0, complex), np.zeros(0, complex), none, none, none)
        return cls(*(np.concatenate([getattr(p, f) for p in [empty, *parts]]) for f in cls.__dataclass_fields__))


def matched_share(
    cmap: ContourMap, shapes: list[Shape], placed: Placements, tolerance_px: float, deadline: Deadline
) -> Array1:
    """(H,) share of each placed outline's points that lie no farther than `tolerance_px` from a contour.

    For similarities. What the deadline leaves unread scores 0.
    """
    share = np.zeros(len(placed))
    packed = pack_shapes(tuple(shapes))
    tolerance = Tolerance(0.0, tolerance_px, tolerance_px)
    for s, slot in np.unique(np.stack([placed.shape, placed.slot]), axis=1).T:
        mine = np.flatnonzero((placed.shape == s) & (placed.slot == slot))
        points = packed.x[s], packed.y[s]
        for start in range(0, len(mine), _CHUNK):
            if deadline.expired:
                return share
            part = mine[start : start + _CHUNK]
            count = count_all(placed.t[part], placed.z[part], packed.area[s], slot, *points, cmap.field, tolerance)
            share[part] = count / packed.x.shape[1]
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
    return Evidence(
        *compiled.evidence(
            cmap.contours,
            pack_shapes(tuple(shapes)),
            *placed.packed,
            tolerance_px(placed.area_px(shapes), config.alignment),
            config.alignment.normal_agreement,
            cmap.image_size,
            np.array(blank, float),
        )
    )
