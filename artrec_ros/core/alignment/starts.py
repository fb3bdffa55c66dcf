"""Where to start refinement: hypotheses of every blob and shape, counted and thinned out (paper, step 4)."""

from __future__ import annotations

from collections.abc import Iterator, Sequence, Sized
from itertools import accumulate
from statistics import median

import numpy as np
from numpy.typing import NDArray

from ..base.config import AlignmentConfig, RecognizerConfig
from ..base.deadline import Deadline
from ..geometry.range_limits import ScaleLimits
from ..image.blobs import Blob, blob_anchors
from . import start_kernels as compiled
from .contour_map import ContourMap
from .counting_kernels import Limits
from .hypotheses import circles, is_round, pack_couples
from .placements import Placements, tolerance_of
from .shapes import Shape, pack_shapes
from .whole_contours import WholeContours

_CHUNK = 60_000  # hypotheses between looks at the clock: a few milliseconds of compiled work


def find_starts(
    blobs: tuple[Blob, ...],
    cmap: ContourMap,
    shapes: list[Shape],
    wanted: set[tuple[int, int]],
    config: RecognizerConfig,
    deadline: Deadline,
    scales: ScaleLimits,
) -> Placements:
    """The best hypotheses of every place, at most `refine_keep` a blob and shape.

    :param wanted: (shape, label) pairs.
    :param deadline: blobs that it leaves are not looked at.
    :param scales: to look for.
    """
    packed = pack_shapes(tuple(shapes))
    couples = pack_couples(tuple(shapes), config.alignment.couple_spans)
    mine = _pack_blobs(blobs, cmap, shapes, wanted, config)
    limits = _limits(config, scales)
    spans = np.array(config.alignment.couple_spans)
    parts = []
    for b_from, b_to in _chunks(mine, len(couples.q1) * len(spans)):
        if deadline.expired:
            break
        t, z, shape, blob, score = compiled.find_starts(mine, b_from, b_to, packed, couples, cmap.field, spans, limits)
        slot = mine.slot[blob]
        parts.append(Placements(t, z, shape, blob, slot, score, np.zeros(len(t), complex)))
    return parts[0] if len(parts) == 1 else Placements.concatenate(parts)


def _quota(blob: Blob, config: RecognizerConfig) -> int:
    """A small blob has room for few instances."""
    room = len(blob.pixels) // config.alignment.contour_per_start
    return min(max(room, config.alignment.least_starts), config.alignment.refine_keep)


def _chunks(blobs: compiled.BlobArrays, an_anchor: int) -> Iterator[tuple[int, int]]:
    """:param an_anchor: hypotheses that come of an anchor."""
    start, count = 0, len(blobs.area)
    if len(blobs.anchors) * an_anchor <= _CHUNK:
        yield start, count
        return
    work = np.cumsum(np.diff(blobs.polygon_first[blobs.polygons]) * an_anchor)
    while start < count:
        done = work[start - 1] if start else 0
        end = max(start + 1, int(np.searchsorted(work, done + _CHUNK, side="right")))
        yield start, end
        start = end


def _limits(config: RecognizerConfig, scales: ScaleLimits) -> Limits:
    return Limits(
        config.alignment.coarse_step,
        config.alignment.coarse_match,
        config.alignment.coarse_keep,
        config.alignment.min_area_ratio,
        config.alignment.max_area_ratio,
        float(config.min_blob_px),
        *scales,
        tolerance_of(config.alignment),
        config.alignment.symmetry_px,
        config.alignment.same_start,
    )


def _pack_blobs(
    blobs: tuple[Blob, ...],
    cmap: ContourMap,
    shapes: list[Shape],
    wanted: set[tuple[int, int]],
    config: RecognizerConfig,
) -> compiled.BlobArrays:
    polygons = [polygon for b in blobs for polygon in blob_anchors(b, config)]
    shapes_of = {label: sorted(s for s, wanted_label in wanted if wanted_label == label) for label in cmap.slots}
    area = np.array([b.area_px for b in blobs])
    typical = {n: median([b.area_px for b in blobs if b.label == n]) for n in cmap.slots}
    round_ = {(s, n): is_round(shapes[s], typical[n], config) for n, mine in shapes_of.items() for s in mine}
    rows = [(b, s) for b in blobs for s in shapes_of[b.label]]
    is_disc = np.array([round_[s, b.label] for b, s in rows], bool)
    extra_t, extra_z, extra_first = _besides_couples(blobs, shapes, rows, is_disc, config.alignment)
    return compiled.BlobArrays(
        np.concatenate(polygons).view(complex)[:, 0],
        _starts_of(polygons),
        np.arange(len(blobs) + 1) * len(config.blobs.anchor_tolerances_px),
        area,
        np.array([cmap.slots[b.label] for b in blobs], np.int32),
        np.array([_quota(b, config) for b in blobs]),
        np.array([s for _, s in rows], np.int32),
        _starts_of([shapes_of[b.label] for b in blobs]),
        ~is_disc,
        extra_t,
        extra_z,
        extra_first,
    )


def _besides_couples(
    blobs: tuple[Blob, ...],
    shapes: list[Shape],
    rows: Sequence[tuple[Blob, int]],
    is_disc: NDArray[np.bool_],
    config: AlignmentConfig,
) -> tuple[np.ndarray, np.ndarray, NDArray[np.int64]]:
    """(t, z) proposed for each blob and shape in `rows`, one row's after the other's, and where each row's start:
    circles for discs, and else the shape's whole outline on the whole contour."""
    discs = {n: circles(rows[n][0], shapes[rows[n][1]], config) for n in np.flatnonzero(is_disc).tolist()}
    first = np.array([0, *accumulate(len(discs[n][0]) if n in discs else config.whole_ways for n in range(len(rows)))])
    t, z = np.empty(first[-1], complex), np.empty(first[-1], complex)
    for n, circle in discs.items():
        t[first[n] : first[n + 1]], z[first[n] : first[n + 1]] = circle
    if len(discs) < len(rows):
        number = {id(b): n for n, b in enumerate(blobs)}
        blob, shape = np.array([(number[id(b)], s) for b, s in rows])[~is_disc].T
        at = first[:-1][~is_disc, None] + np.arange(config.whole_ways)
        t[at], z[at] = WholeContours(blobs).laid(shapes, blob, shape, config.whole_ways)
    return t, z, first


def _starts_of(parts: Sequence[Sized]) -> NDArray[np.int64]:
    """(n + 1,) where each of n parts starts when they are put one after another, and where the last one ends."""
    return np.array([0, *accumulate(map(len, parts))])
