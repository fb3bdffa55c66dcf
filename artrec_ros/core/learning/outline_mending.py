"""Outlines as they are seen beside those that were drawn: laid on them, and what is drawn mended where they differ.

Polygons (n, 2), metres, in a marker's frame.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import least_squares

from ..geometry.polygons import distance_to_outline, signed_area
from ..geometry.transforms import Array
from ..model.surface import sample_contour

_BACK = 0.4  # of what may be noise: within it what is seen has come back to what is drawn
_MOST = 0.5  # of an outline: where more of it differs nothing of what is drawn is kept
_SAMPLES, _PLACES = 400, 2000  # along an outline, and where on it something may begin


def along(outline: Array) -> Array:
    """(m, 2) points on a closed polygon, evenly."""
    return sample_contour(outline, _SAMPLES)[0]


def farthest_apart(a: Array, b: Array) -> tuple[float, Array]:
    """How far two closed polygons are apart where they are most, and the point (2,) of either that is so far off."""
    on_a, on_b = along(a), along(b)
    points = np.concatenate([on_a, on_b])
    off = np.concatenate([distance_to_outline(on_a, b), distance_to_outline(on_b, a)])
    worst = int(np.argmax(off))
    return float(off[worst]), points[worst]


def laid_on(seen: Array, drawn: Array, near_m: float, slanted: bool) -> Array:
    """What is seen, moved, turned and sized so that most of it lies on what is drawn.

    :param slanted: width over height is a matter of the slant, and sized, too.
    """
    points, middle, size = along(seen), drawn.mean(axis=0), float(np.ptp(drawn, axis=0).max())
    outline = ((drawn - middle) / size).astype(np.float32)[:, None]

    def moved(p: Array, way: Array) -> Array:
        if not slanted:
            way = np.concatenate([way, [-way[3], way[2]]])
        return np.asarray(((p - middle) / size) @ (np.eye(2) + np.array([way[2:4], way[4:6]])) + way[:2])

    def off(way: Array) -> Array:
        return np.array([cv2.pointPolygonTest(outline, (float(x), float(y)), True) for x, y in moved(points, way)])

    start = np.zeros(6 if slanted else 4)
    way = least_squares(off, start, loss="soft_l1", f_scale=near_m / size, diff_step=1e-4).x
    return np.asarray(moved(seen, way) * size + middle)


def to_length(seen: Array, drawn: Array, along: Array) -> tuple[float, Array]:
    """Factor and shift (2,) by which what is seen reaches along an axis (2,) from where to where what is drawn does.

    A lone marker of unknown distance has no size of its own: found by sides that are drawn too narrow it is taken for
    one that is nearer, and seen too short. Its length is what was measured, and what marks of its axis go by.
    """
    direction = along / np.linalg.norm(along)
    (first, last), (low, high) = ((p.min(), p.max()) for p in (seen @ direction, drawn @ direction))
    zoom = float((high - low) / (last - first))
    return zoom, (1 - zoom) * (drawn - np.outer(drawn @ direction, direction)).mean(axis=0) + direction * (
        low - zoom * first
    )


def mended_by(drawn: Array, seen: Array, least_m: float, as_drawn: Array | None = None) -> Array:
    """What is drawn, but as it is seen where the two are farther apart than that: sharp corners stay sharp.

    :param as_drawn: how what is drawn would be seen, corners rounded; not given: as it is.
    """
    if signed_area(seen) * signed_area(drawn) < 0:
        seen = seen[::-1]
    points = along(seen)
    off = distance_to_outline(points, drawn)
    if as_drawn is not None:
        off = np.minimum(off, distance_to_outline(points, as_drawn))
    runs = _runs(off > least_m, off > _BACK * least_m)
    if not runs:
        return drawn
    grid, places = (np.arange(_PLACES) + 0.5) / _PLACES, sample_contour(drawn, _PLACES)[0]
    ends = ((grid[_nearest(points[run[0]], places)], grid[_nearest(points[run[-1]], places)], run) for run in runs)
    spans = sorted(((float(begin), float(end), run) for begin, end, run in ends), key=lambda span: span[0])
    if sum((end - begin) % 1 for begin, end, _ in spans) > _MOST:
        return seen  # most of it is otherwise
    corners, points_of = _corners(drawn), list[Array]()
    for (_, kept_from, run), (kept_to, _, _) in zip(spans, [*spans[1:], spans[0]], strict=True):
        points_of += [*points[run]]
        ahead = (corners - kept_from) % 1
        kept = np.flatnonzero((ahead > 0) & (ahead < (kept_to - kept_from) % 1))
        points_of += [*drawn[kept[np.argsort(ahead[kept])]]]
    return np.array(points_of)


def _corners(outline: Array) -> Array:
    """(n,) at which share of its length each corner of a closed polygon lies."""
    length = np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1)
    return (np.cumsum(length) - length) / length.sum()


def _runs(wrong: NDArray[np.bool_], near: NDArray[np.bool_]) -> list[NDArray[np.int64]]:
    """Indices, around a ring, of stretches that are not `near` and hold something `wrong`."""
    if near.all():
        return [np.arange(len(near))]
    start = int(np.flatnonzero(~near)[0])
    order = (np.arange(len(near)) + start) % len(near)
    pieces = np.split(order, np.flatnonzero(np.diff(near[order].astype(int))) + 1)
    return [piece for piece in pieces if near[piece[0]] and wrong[piece].any()]


def _nearest(point: Array, places: Array) -> int:
    return int(np.argmin(np.linalg.norm(places - point, axis=1)))
