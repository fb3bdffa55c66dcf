"""Hypotheses of where a shape lies: couples of anchors, whole blobs, circles (paper, step 4)."""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np

from .alignment import Placements
from .blobs import Blob, blob_anchors
from .compiled.starts import Couples
from .config import RecognizerConfig
from .deadline import Deadline
from .shapes import Shape
from .transforms import Array

WHOLE_BLOB_TURNS = 24
_ARC_SPANS = (0.08, 0.16, 0.32)  # of a contour: how far apart the three points of a circle are
_ARC_POINTS = 48


def anchor_couples(anchors: np.ndarray, spans: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """(first, second) of every couple of anchors that are `span` apart along a closed polygon, complex."""
    spans = tuple(s for s in spans if s < len(anchors))
    first = [anchors for _ in spans]
    second = [np.roll(anchors, -s) for s in spans]
    none = np.zeros(0, complex)
    return np.concatenate(first or [none]), np.concatenate(second or [none])


@lru_cache(maxsize=8)
def pack_couples(shapes: tuple[Shape, ...], spans: tuple[int, ...]) -> Couples:
    """The anchors' couples of all shapes as compiled code takes them."""
    couples = [anchor_couples(s.anchors, spans) for s in shapes]
    first = np.concatenate([q1 for q1, _ in couples])
    second = np.concatenate([q2 for _, q2 in couples])
    return Couples(first, 1 / (second - first), np.cumsum([0] + [len(q1) for q1, _ in couples]))


def blob_couples(blobs: list[Blob], config: RecognizerConfig) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Couples of all blobs: (first, second) complex and (n,) position in `blobs`."""
    couples, owner = [np.zeros((0, 2), complex)], [np.zeros(0, np.int32)]
    for i, blob in enumerate(blobs):
        polygons = [anchor_couples(a @ np.array([1, 1j]), config.couple_spans) for a in blob_anchors(blob, config)]
        mine = np.concatenate([np.stack(pair, axis=1) for pair in polygons])  # (n, 2)
        once = np.sort(np.unique(mine, axis=0, return_index=True)[1])  # two polygons share many
        couples.append(mine[once])
        owner.append(np.full(len(once), i, np.int32))
    first, second = np.concatenate(couples).T
    return first, second, np.concatenate(owner)


def propose(
    blobs: tuple[Blob, ...],
    shapes: list[Shape],
    wanted: set[tuple[int, int]],
    slots: dict[int, int],
    config: RecognizerConfig,
    deadline: Deadline,
) -> Placements:
    """Every hypothesis of a frame as one batch.

    :param wanted: (shape, label) pairs to look for.
    :return: placements whose `blob` counts in `blobs`; score 0.
    """
    parts: list[Placements] = []
    for label, slot in slots.items():
        numbers = np.array([i for i, b in enumerate(blobs) if b.label == label], np.int32)
        mine = [blobs[i] for i in numbers]
        couples = blob_couples(mine, config)
        for s in sorted(s for s, wanted_label in wanted if wanted_label == label):
            if deadline.expired:
                return Placements.concatenate(parts)
            t, z, owner = _of_shape(mine, shapes[s], couples, config)
            keep = _plausible(z, shapes[s], np.array([b.area_px for b in mine])[owner], config)
            n = int(np.count_nonzero(keep))
            parts.append(
                Placements.similarities(
                    t[keep], z[keep], np.full(n, s, np.int32), numbers[owner[keep]], np.full(n, slot, np.int32)
                )
            )
    return Placements.concatenate(parts)


def _of_shape(
    blobs: list[Blob], shape: Shape, couples: tuple[np.ndarray, np.ndarray, np.ndarray], config: RecognizerConfig
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(t, z, position in blobs) of one shape's hypotheses."""
    round_shape = is_round(shape, float(np.median([b.area_px for b in blobs])), config)
    parts = [_whole_blobs(blobs, shape, 1 if round_shape else WHOLE_BLOB_TURNS)]
    if round_shape:
        parts.append(circles(blobs, shape))
    else:
        parts.append(_couples(shape, couples, config))
    t, z, owner = (np.concatenate(column) for column in zip(*parts, strict=True))
    return t, z, owner


def is_round(shape: Shape, typical_area_px: float, config: RecognizerConfig) -> bool:
    """Whether no direction of the shape can be told at the size of the blobs: its anchors mean nothing."""
    typical_scale = math.sqrt(typical_area_px / shape.area_m2)
    return shape.is_disc or shape.symmetry.is_any_angle(typical_scale, config.symmetry_px)


def _couples(
    shape: Shape, couples: tuple[np.ndarray, np.ndarray, np.ndarray], config: RecognizerConfig
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """T(q1) = p1, T(q2) = p2 for all couples. Both contours run the same way round, so q2 -> q1 on p1 -> p2 would
    turn the shape's inside out of the blob: it need not be tried."""
    q1, q2 = anchor_couples(shape.anchors, config.couple_spans)
    p1, p2, owner = couples
    z = ((p2 - p1)[:, None] / (q2 - q1)[None]).ravel()  # (n' m',)
    t = (p1[:, None] - z.reshape(len(p1), -1) * q1[None]).ravel()
    return t, z, np.repeat(owner, len(q1))


def _whole_blobs(blobs: list[Blob], shape: Shape, turns: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The shape over a blob's centroid, of its area, turned in equal steps: for blobs too small for anchors."""
    centres = np.array([centroid(b) for b in blobs])
    k = np.sqrt(np.array([b.area_px for b in blobs]) / shape.area_m2)
    turn = np.exp(2j * np.pi * np.arange(turns) / turns)
    return (
        np.repeat(centres, turns),
        (k[:, None] * turn).ravel(),
        np.repeat(np.arange(len(blobs), dtype=np.int32), turns),
    )


def centroid(blob: Blob) -> complex:
    """Of the pixels enclosed."""
    moments = cv2.moments(blob.polygon)
    if moments["m00"] < 1e-6:
        return complex(*blob.contour.mean(axis=0))
    return complex(moments["m10"], moments["m01"]) / moments["m00"]


def circles(blobs: list[Blob], shape: Shape) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Circles through three contour points: discs that are merged with, or cut by, something else."""
    centres, radii, owner = [], [], []
    for i, blob in enumerate(blobs):
        p = blob.contour @ np.array([1, 1j])
        at = np.unique(np.linspace(0, len(p), _ARC_POINTS, endpoint=False).astype(int))
        for share in _ARC_SPANS:
            step = max(1, int(share * len(p) / 2))
            c, r = _circumcircles(p[at - step], p[at], p[(at + step) % len(p)])
            centres.append(c)
            radii.append(r)
            owner.append(np.full(len(c), i, np.int32))
    radius = float(np.sqrt(shape.area_m2 / np.pi))
    return np.concatenate(centres), np.concatenate(radii).astype(complex) / radius, np.concatenate(owner)


def _circumcircles(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres and radii of the circles through triples that bend outward."""
    u, v = b - a, c - a
    cross = np.imag(np.conj(u) * v)
    convex = cross > 1e-6
    u, v, a, cross = u[convex], v[convex], a[convex], cross[convex]
    w = 1j * (v * np.abs(u) ** 2 - u * np.abs(v) ** 2) / (2 * cross)
    return a - w, np.abs(w)


def _plausible(z: np.ndarray, shape: Shape, blob_area_px: Array, config: RecognizerConfig) -> np.ndarray:
    """Floors and ceilings on k: a tiny k would fold the whole shape into the tolerance area."""
    k = np.abs(z)
    area = shape.area_m2 * k**2
    ok = (area >= config.min_area_ratio * blob_area_px) & (area <= config.max_area_ratio * blob_area_px)
    ok &= (area >= config.min_blob_px) & (k >= config.min_scale)
    return ok & (k <= config.max_scale) if config.max_scale > 0 else ok
