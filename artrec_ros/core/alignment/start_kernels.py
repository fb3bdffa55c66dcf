"""Hypotheses of one blob after another: proposed, counted, thinned out (paper, step 4). They are never all held at
once.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit
from .counting_kernels import by_count, count_all
from .thinning_kernels import thin_out


class ShapeArrays(NamedTuple):
    """Shapes packed. :param points, normals: (S, m) complex. :param x, y: of the points, each in an array of its own.
    :param residual: (S, 13) as in `Symmetry`.
    """

    points: np.ndarray
    normals: np.ndarray
    x: np.ndarray
    y: np.ndarray
    area: np.ndarray
    radius: np.ndarray
    residual: np.ndarray


class Couples(NamedTuple):
    """Couples of shapes' anchors, those of shape s from first[s] to first[s + 1].

    :param q1: (Q,) complex, the first anchor. :param turn: 1 / (q2 - q1).
    """

    q1: np.ndarray
    turn: np.ndarray
    first: np.ndarray


class BlobArrays(NamedTuple):
    """Blobs packed. `polygon_first[polygons[b]]` starts blob b's first polygon of anchors; `wanted_first` bounds its
    shapes in `wanted`; `extra_first` what (t, z) is proposed for each such shape besides couples.

    :param quota: (B,) hypotheses to keep of each shape.
    :param coupled: (W,) whether the shape's anchors are to be used.
    """

    anchors: np.ndarray
    polygon_first: np.ndarray
    polygons: np.ndarray
    area: np.ndarray
    slot: np.ndarray
    quota: np.ndarray
    wanted: np.ndarray
    wanted_first: np.ndarray
    coupled: np.ndarray
    extra_t: np.ndarray
    extra_z: np.ndarray
    extra_first: np.ndarray


@jit
def _couples(blobs: Any, b: int, spans: Any) -> Any:
    """(n,) first and second anchors of a blob's couples, each once though two polygons have it."""
    most = 0
    for polygon in range(blobs.polygons[b], blobs.polygons[b + 1]):
        most += (blobs.polygon_first[polygon + 1] - blobs.polygon_first[polygon]) * len(spans)
    first, second = np.empty(most, np.complex128), np.empty(most, np.complex128)
    n = 0
    for polygon in range(blobs.polygons[b], blobs.polygons[b + 1]):
        start = blobs.polygon_first[polygon]
        sides = blobs.polygon_first[polygon + 1] - start
        known = n
        for span in spans:
            if span >= sides:
                continue
            for i in range(sides):
                p1, p2 = blobs.anchors[start + i], blobs.anchors[start + (i + span) % sides]
                new = True
                for j in range(known):
                    if first[j] == p1 and second[j] == p2:
                        new = False
                        break
                if new:
                    first[n], second[n] = p1, p2
                    n += 1
    return first[:n], second[:n]


@jit
def _propose(p1: Any, p2: Any, blobs: Any, w: int, couples: Any) -> Any:
    """(t, z) of all of blob b's hypotheses of one shape: those proposed besides, and T(q1) = p1 and T(q2) = p2.

    Both contours run the same way round, so q2 -> q1 on p1 -> p2 would turn the shape's inside out of the blob: it
    need not be tried.
    """
    s, extra_from, extra_to = blobs.wanted[w], blobs.extra_first[w], blobs.extra_first[w + 1]
    first, last = couples.first[s], couples.first[s + 1] if blobs.coupled[w] else couples.first[s]
    n = extra_to - extra_from
    count = n + len(p1) * (last - first)
    t, z = np.empty(count, np.complex128), np.empty(count, np.complex128)
    t[:n], z[:n] = blobs.extra_t[extra_from:extra_to], blobs.extra_z[extra_from:extra_to]
    q1, turn = couples.q1[first:last], couples.turn[first:last]
    for p in range(len(p1)):
        side, start = p2[p] - p1[p], p1[p]
        for q in range(len(q1)):
            z[n] = side * turn[q]
            t[n] = start - z[n] * q1[q]
            n += 1
    return t, z


@jit
def _plausible(t: Any, z: Any, area: float, blob_area: float, limits: Any) -> Any:
    """Those of a size that can be: a tiny one would fold the whole shape into the tolerance area."""
    least = max(limits.min_area, limits.min_area_ratio * blob_area) / area
    least, most = max(least, limits.min_scale**2), min(limits.max_area_ratio * blob_area / area, limits.max_scale**2)
    n = 0
    for i in range(len(t)):
        k2 = z[i].real * z[i].real + z[i].imag * z[i].imag
        if least <= k2 <= most:
            t[n], z[n] = t[i], z[i]
            n += 1
    return t[:n], z[:n]


@jit
def _least_of(samples: int, share: float) -> int:
    return int(np.ceil(share * samples - 1e-9))


@jit
def _count_coarsely(t: Any, z: Any, b: int, s: int, blobs: Any, shapes: Any, field: Any, limits: Any) -> Any:
    """(t, z, count) of those that pass the coarse count, the best `coarse_keep`, in their order."""
    px, py = shapes.x[s, :: limits.coarse_step].copy(), shapes.y[s, :: limits.coarse_step].copy()
    count = count_all(t, z, shapes.area[s], blobs.slot[b], px, py, field, limits.tolerance)
    passed = np.flatnonzero(count >= _least_of(len(px), limits.coarse_match))
    if len(passed) > limits.coarse_keep:
        best = by_count(count[passed], len(passed), len(px))[: limits.coarse_keep]
        passed = passed[np.sort(best)]
    return t[passed], z[passed], count[passed]


@jit
def _count_fully(t: Any, z: Any, counted: Any, b: int, s: int, blobs: Any, shapes: Any, field: Any, limits: Any) -> Any:
    """Hypotheses that pass the full count, best first: (t, z, count). :param counted: by the coarse count."""
    samples = shapes.x.shape[1]
    rest = np.flatnonzero(np.arange(samples) % limits.coarse_step != 0)
    px, py = shapes.x[s][rest], shapes.y[s][rest]
    count = counted + count_all(t, z, shapes.area[s], blobs.slot[b], px, py, field, limits.tolerance)
    passed = np.flatnonzero(count >= _least_of(samples, limits.coarse_match))
    order = passed[by_count(count[passed], len(passed), samples)]
    return t[order], z[order], count[order]


@jit
def find_starts(
    blobs: Any, b_from: int, b_to: int, shapes: Any, couples: Any, field: Any, spans: Any, limits: Any
) -> Any:
    """(t, z, shape, blob, score) of the hypotheses of blobs `b_from` to `b_to` that are worth refining."""
    room = 0
    for b in range(b_from, b_to):
        room += blobs.quota[b] * (blobs.wanted_first[b + 1] - blobs.wanted_first[b])
    out_t, out_z = np.empty(room, np.complex128), np.empty(room, np.complex128)
    out_shape, out_blob, out_score = np.empty(room, np.int32), np.empty(room, np.int32), np.empty(room)
    n = 0
    for b in range(b_from, b_to):
        p1, p2 = _couples(blobs, b, spans)
        for w in range(blobs.wanted_first[b], blobs.wanted_first[b + 1]):
            s = blobs.wanted[w]
            t, z = _propose(p1, p2, blobs, w, couples)
            t, z = _plausible(t, z, shapes.area[s], blobs.area[b], limits)
            t, z, count = _count_coarsely(t, z, b, s, blobs, shapes, field, limits)
            t, z, count = _count_fully(t, z, count, b, s, blobs, shapes, field, limits)
            radius, residual = shapes.radius[s], shapes.residual[s]
            for i in thin_out(t, z, blobs.quota[b], radius, residual, limits.symmetry_px, limits.same_start):
                out_t[n], out_z[n], out_shape[n], out_blob[n] = t[i], z[i], s, b
                out_score[n] = count[i] / shapes.points.shape[1]
                n += 1
    return out_t[:n], out_z[:n], out_shape[:n], out_blob[:n], out_score[:n]
