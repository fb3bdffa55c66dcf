"""Hypotheses of one blob after another: proposed, counted, thinned out. The numpy code that it follows is in
`hypotheses.py`, `alignment.matched_share` and `refinement.suppress`; hypotheses are never all held at once.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .jit import jit


class ShapeArrays(NamedTuple):
    """Shapes packed. :param points, normals: (S, m) complex. :param residual: (S, 13) as in `Symmetry`."""

    points: np.ndarray
    normals: np.ndarray
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
    shapes in `wanted`; `extra_first` the circles (t, z) proposed for each such shape.

    :param quota: (B,) hypotheses to keep of each shape. :param turns: (W,) of the shape laid over the whole blob.
    :param coupled: (W,) whether the shape's anchors are to be used.
    """

    anchors: np.ndarray
    polygon_first: np.ndarray
    polygons: np.ndarray
    area: np.ndarray
    centre: np.ndarray
    slot: np.ndarray
    quota: np.ndarray
    wanted: np.ndarray
    wanted_first: np.ndarray
    turns: np.ndarray
    coupled: np.ndarray
    extra_t: np.ndarray
    extra_z: np.ndarray
    extra_first: np.ndarray


class Field(NamedTuple):
    """A `ContourMap`'s distances; `left`, `top`: its origin; `height`: rows of a slot."""

    distance: np.ndarray
    left: int
    top: int
    height: int
    steps_per_px: float


class Limits(NamedTuple):
    """Values of `RecognizerConfig`. `max_scale` is infinite for any."""

    coarse_step: int
    coarse_match: float
    coarse_keep: int
    min_area_ratio: float
    max_area_ratio: float
    min_area: float
    min_scale: float
    max_scale: float
    tolerance_px: float
    tolerance_share: float
    symmetry_px: float
    same_start: float


@jit
def symmetry_order(residual: Any, scale: float, ambiguous_px: float) -> int:
    """`Symmetry.order`; 0: any angle."""
    if residual[0] * scale <= ambiguous_px:
        return 0
    order = 1
    for n in range(2, len(residual)):
        if residual[n] * scale <= ambiguous_px:
            order = n
    return order


@jit
def squared_pose_distance(
    t: complex, z: complex, t0: complex, z0: complex, radius: float, order: int, enough: float
) -> float:
    """`refinement.pose_distance_px`, squared; of the places alone where that is above `enough`."""
    dx, dy = t.real - t0.real, t.imag - t0.imag
    place = dx * dx + dy * dy
    if place > enough:
        return place
    a, b = z.real * z.real + z.imag * z.imag, z0.real * z0.real + z0.imag * z0.imag
    if order == 0:
        turn = (np.sqrt(a) - np.sqrt(b)) ** 2
    else:
        re = z.real * z0.real + z.imag * z0.imag
        im = z.imag * z0.real - z.real * z0.imag
        best = re
        for n in range(1, order):
            angle = 2 * np.pi * n / order
            best = max(best, re * np.cos(angle) + im * np.sin(angle))
        turn = a + b - 2 * best
    return place + radius * radius * max(turn, 0.0)


@jit
def count_matched(
    field: Any, slot: int, t: complex, z: complex, points: Any, step: int, area: float, limits: Any, least: int
) -> int:
    """How many of every `step`-th point lie in the tolerance area; -1 where there are clearly fewer than `least`."""
    tolerance = min(max(limits.tolerance_share * np.sqrt(area), 1.0), max(1.0, limits.tolerance_px))
    limit = int(tolerance * field.steps_per_px)
    right, bottom, low = field.distance.shape[1] - 1.0, field.height - 1.0, slot * field.height
    x0, y0, zr, zi, distance = t.real - field.left, t.imag - field.top, z.real, z.imag, field.distance
    count, left_over = 0, (len(points) + step - 1) // step
    for start in range(0, len(points), 40 * step):
        end = min(start + 40 * step, len(points))
        for i in range(start, end, step):  # without a branch; the map's margin lies far from any contour
            px, py = points[i].real, points[i].imag
            x = np.rint(min(max(x0 + zr * px - zi * py, 0.0), right))
            y = np.rint(min(max(y0 + zi * px + zr * py, 0.0), bottom))
            count += distance[np.uint32(low + y), np.uint32(x)] <= limit
        left_over -= (end - start + step - 1) // step
        if count + left_over < least:
            return -1
    return count


@jit
def by_count(count: Any, n: int, most: int) -> Any:
    """Indices of the first n counts, greatest first, equal ones in their order."""
    start = np.zeros(most + 2, np.int64)
    for i in range(n):
        start[most - count[i] + 1] += 1
    start = np.cumsum(start)
    order = np.empty(n, np.int64)
    for i in range(n):
        order[start[most - count[i]]] = i
        start[most - count[i]] += 1
    return order


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
def _propose(p1: Any, p2: Any, blobs: Any, b: int, w: int, shapes: Any, couples: Any, field: Any, limits: Any) -> Any:
    """(t, z) of blob b's hypotheses of one shape that pass the coarse count, the best `coarse_keep`, in their order."""
    s = blobs.wanted[w]
    turns, extra = blobs.turns[w], blobs.turns[w] + blobs.extra_first[w + 1] - blobs.extra_first[w]
    sides = couples.first[s + 1] - couples.first[s] if blobs.coupled[w] else 0
    t, z = np.empty(extra + len(p1) * sides, np.complex128), np.empty(extra + len(p1) * sides, np.complex128)
    count = np.empty(len(t), np.int64)
    whole = np.sqrt(blobs.area[b] / shapes.area[s])
    samples = (shapes.points.shape[1] + limits.coarse_step - 1) // limits.coarse_step
    least = int(np.ceil(limits.coarse_match * samples - 1e-9))
    least_area = max(limits.min_area, limits.min_area_ratio * blobs.area[b])
    n = 0
    for i in range(len(t)):
        if i < turns:
            t_i, z_i = blobs.centre[b], whole * np.exp(2j * np.pi * i / turns)
        elif i < extra:
            t_i, z_i = blobs.extra_t[blobs.extra_first[w] + i - turns], blobs.extra_z[blobs.extra_first[w] + i - turns]
        else:
            p, q = (i - extra) // sides, couples.first[s] + (i - extra) % sides
            z_i = (p2[p] - p1[p]) * couples.turn[q]
            t_i = p1[p] - z_i * couples.q1[q]
        k2 = z_i.real * z_i.real + z_i.imag * z_i.imag
        area = shapes.area[s] * k2
        if area < least_area or area > limits.max_area_ratio * blobs.area[b]:
            continue
        if k2 < limits.min_scale**2 or k2 > limits.max_scale**2:
            continue
        c = count_matched(field, blobs.slot[b], t_i, z_i, shapes.points[s], limits.coarse_step, area, limits, least)
        if c >= least:
            t[n], z[n], count[n] = t_i, z_i, c
            n += 1
    if n > limits.coarse_keep:
        keep = np.sort(by_count(count, n, samples)[: limits.coarse_keep])
        return t[keep], z[keep]
    return t[:n], z[:n]


@jit
def _count_fully(t: Any, z: Any, s: int, slot: int, shapes: Any, field: Any, limits: Any) -> Any:
    """Hypotheses that pass the full count, best first: (t, z, count)."""
    samples = shapes.points.shape[1]
    least = int(np.ceil(limits.coarse_match * samples - 1e-9))
    count, passed = np.empty(len(t), np.int64), np.empty(len(t), np.int64)
    n = 0
    for i in range(len(t)):
        area = shapes.area[s] * (z[i].real ** 2 + z[i].imag ** 2)
        c = count_matched(field, slot, t[i], z[i], shapes.points[s], 1, area, limits, least)
        if c >= least:
            count[n], passed[n] = c, i
            n += 1
    order = by_count(count, n, samples)
    return t[passed[order]], z[passed[order]], count[order]


@jit
def thin_out(t: Any, z: Any, quota: int, radius: float, residual: Any, symmetry_px: float, same_place: float) -> Any:
    """Indices of the best of each place, at most `quota`: `refinement.suppress` for one group, best first."""
    kept = np.empty(min(quota, len(t)), np.int64)
    order, reach2 = np.empty(len(kept), np.int64), np.empty(len(kept))
    n = 0
    for i in range(len(t)):
        if n == len(kept):
            break
        near = False
        for j in range(n):
            if squared_pose_distance(t[i], z[i], t[kept[j]], z[kept[j]], radius, order[j], reach2[j]) <= reach2[j]:
                near = True
                break
        if not near:
            k = abs(z[i])
            order[n] = symmetry_order(residual, k, symmetry_px)
            reach2[n] = max(1.0, same_place * radius * k) ** 2
            kept[n] = i
            n += 1
    return kept[:n]


@jit
def suppress(
    order: Any, group: Any, t: Any, z: Any, w: Any, shape: Any, quota: Any, shapes: Any, symmetry_px: float,
    same_place: float,
) -> Any:  # fmt: skip
    """`refinement.suppress`; `order` sorts by group and then by score."""
    kept, n = np.empty(len(order), np.int64), 0
    first, before = 0, -1  # of the group
    for i in order:
        if group[i] != before:
            first, before = n, group[i]
        if n - first >= quota[i]:
            continue
        near, radius = False, shapes.radius[shape[i]]
        for j in kept[first:n]:
            k = abs(z[j]) + abs(w[j])
            reach2 = max(1.0, same_place * radius * k) ** 2
            turns = symmetry_order(shapes.residual[shape[i]], k, symmetry_px)
            squeezed = radius * (abs(w[i]) - abs(w[j]))
            if squared_pose_distance(t[i], z[i], t[j], z[j], radius, turns, reach2) + squeezed**2 <= reach2:
                near = True
                break
        if not near:
            kept[n] = i
            n += 1
    return kept[:n]


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
            t, z = _propose(p1, p2, blobs, b, w, shapes, couples, field, limits)
            t, z, count = _count_fully(t, z, s, blobs.slot[b], shapes, field, limits)
            radius, residual = shapes.radius[s], shapes.residual[s]
            for i in thin_out(t, z, blobs.quota[b], radius, residual, limits.symmetry_px, limits.same_start):
                out_t[n], out_z[n], out_shape[n], out_blob[n] = t[i], z[i], s, b
                out_score[n] = count[i] / shapes.points.shape[1]
                n += 1
    return out_t[:n], out_z[:n], out_shape[:n], out_blob[:n], out_score[:n]
