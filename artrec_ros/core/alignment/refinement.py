"""Choosing among hypotheses: suppression modulo symmetry and batched robust refinement."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from ..base.config import RecognizerConfig
from ..base.deadline import Deadline
from . import thinning_kernels as thinning
from .contour_map import ContourMap
from .placements import Placements
from .refinement_kernels import move_onto_contours
from .shapes import Shape, pack_shapes

_DAMPING = 1e-3  # keeps steps determined where the points that count lie on one line; weighs less than one point
_BATCH = 512  # placements between looks at the clock


def suppress(
    placed: Placements,
    group: np.ndarray,
    shapes: list[Shape],
    quota: np.ndarray,
    config: RecognizerConfig,
    same_place: float,
) -> np.ndarray:
    """Indices of placements that are the best of their place, at most `quota` a group, group after group.

    :param group: (H,) only placements of one group, which share a shape, suppress each other.
    :param quota: (H,) the most that may be kept of the entry's group.
    :param same_place: poses closer than this share of the shape's radius, or 1 px, are one.
    """
    order = np.lexsort((-placed.score, group))
    limits = (pack_shapes(tuple(shapes)), config.alignment.symmetry_px, same_place)
    return thinning.suppress(order, group, placed.t, placed.z, placed.w, placed.shape, quota, *limits)


def refine(
    cmap: ContourMap,
    shapes: list[Shape],
    placed: Placements,
    config: RecognizerConfig,
    deadline: Deadline,
    *,
    slanted: bool = False,
) -> Placements:
    """All placements moved onto the contours in batches: Tukey-weighted point-to-line least squares.

    A similarity is linear in (z, t), an affinity in (z, t, w), so each step is one exact solve per placement.
    Those whose scale runs away by more than `max_refined_scale` keep their hypothesis, as do those the deadline
    leaves.

    :param slanted: by affinities, as far as a turn of `max_slant_deg` out of the image plane squeezes a marker.
    """
    parts = []
    for start in range(0, len(placed), _BATCH):
        part = placed if len(placed) <= _BATCH else placed.take(np.arange(start, min(start + _BATCH, len(placed))))
        if not deadline.expired:
            part = _refined(cmap, shapes, part, config, slanted)
        parts.append(part)
    return parts[0] if len(parts) == 1 else Placements.concatenate(parts)


@lru_cache(maxsize=8)
def _gates(first_px: float, last_px: float, steps: int) -> np.ndarray:
    return np.geomspace(first_px, last_px, steps)


def _squeeze(config: RecognizerConfig, slanted: bool) -> float:
    """Greatest |w| / |z| of an affinity that a turn by `max_slant_deg` makes."""
    if not slanted:
        return 0.0
    cosine = np.cos(np.radians(config.max_slant_deg))
    return float((1 - cosine) / (1 + cosine))


def _refined(
    cmap: ContourMap, shapes: list[Shape], placed: Placements, config: RecognizerConfig, slanted: bool
) -> Placements:
    t, z, w = move_onto_contours(
        cmap.contours,
        pack_shapes(tuple(shapes)),
        *placed.packed,
        _gates(*config.alignment.gates_px, config.alignment.refine_steps),
        config.alignment.point_step,
        config.alignment.normal_agreement,
        _DAMPING,
        _squeeze(config, slanted),
        config.alignment.max_refined_scale,
    )
    return placed.replace(t=t, z=z, w=w)
