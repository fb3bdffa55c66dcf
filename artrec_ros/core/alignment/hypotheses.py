"""Hypotheses of where a shape lies: couples of anchors, circles (paper, step 4)."""

from __future__ import annotations

import math
from functools import lru_cache

import cv2
import numpy as np

from ..base.config import AlignmentConfig, RecognizerConfig
from ..image.blobs import Blob
from .shapes import Shape
from .start_kernels import Couples


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


def is_round(shape: Shape, typical_area_px: float, config: RecognizerConfig) -> bool:
    """Whether no direction of the shape can be told at the size of the blobs: its anchors mean nothing."""
    typical_scale = math.sqrt(typical_area_px / shape.area_m2)
    return shape.is_disc or shape.symmetry.is_any_angle(typical_scale, config.alignment.symmetry_px)


def centroid(blob: Blob) -> complex:
    """Of the pixels enclosed."""
    moments = cv2.moments(blob.polygon)
    if moments["m00"] < 1e-6:
        return complex(*blob.middle)
    return complex(moments["m10"], moments["m01"]) / moments["m00"]


def circles(blob: Blob, shape: Shape, config: AlignmentConfig) -> tuple[np.ndarray, np.ndarray]:
    """(t, z) of the circle that is as large as the blob, and of those through three contour points: discs that are
    merged with, or cut by, something else."""
    p = blob.contour @ np.array([1, 1j])
    at = np.unique(np.linspace(0, len(p), config.arc_points, endpoint=False).astype(int))
    steps = [max(1, int(share * len(p) / 2)) for share in config.arc_spans]
    found = [_circumcircles(p[at - step], p[at], p[(at + step) % len(p)]) for step in steps]
    centres, radii = (np.concatenate(column) for column in zip(*found, strict=True))
    centres, radii = np.append(centres, centroid(blob)), np.append(radii, np.sqrt(blob.area_px / np.pi))
    return centres, radii.astype(complex) / float(np.sqrt(shape.area_m2 / np.pi))


def _circumcircles(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Centres and radii of the circles through triples that bend outward."""
    u, v = b - a, c - a
    cross = np.imag(np.conj(u) * v)
    convex = cross > 1e-6
    u, v, a, cross = u[convex], v[convex], a[convex], cross[convex]
    w = 1j * (v * np.abs(u) ** 2 - u * np.abs(v) ** 2) / (2 * cross)
    return a - w, np.abs(w)
