"""Which hypotheses of an object differ enough to be worth two looks."""

from __future__ import annotations

import numpy as np

from ..geometry.transforms import Array
from .distinct_kernels import first_of_cells
from .surface_model import Poses

# Sizes of a cell:
CELL_PLACE = 0.012  # of the place across the view, as a share of the depth: 0.7 degrees
CELL_LOG_DEPTH = 0.06  # 6 % of the depth
CELL_AXIS = 0.2  # of the components of the x and z axes: about 12 degrees
NICHE_RAD, NICHE_RANGE = 0.35, 0.12  # hypotheses that differ by less (in place: a share of the range) climb to one


def best_distinct(poses: Poses, score: Array, n: int) -> np.ndarray:
    """Indices of the `n` best hypotheses that differ from each other, best first."""
    order = np.argsort(-score, kind="stable")
    out = np.empty(min(n, len(order)), np.int64)
    return out[: first_of_cells(order, poses.R, poses.t, CELL_PLACE, CELL_LOG_DEPTH, CELL_AXIS, out)]


def apart(poses: Poses, votes: Array, least: float) -> np.ndarray:
    """Indices, in their order, of hypotheses with more votes than `least` that no earlier one of these would climb to.

    :param poses, votes: best first.
    """
    range_m = np.linalg.norm(poses.t, axis=1)
    keep: list[int] = []
    for i in np.flatnonzero(votes > least).tolist():
        turned = np.einsum("kij,ij->k", poses.R[keep], poses.R[i])  # trace of the turn from one to the other
        near = np.linalg.norm(poses.t[keep] - poses.t[i], axis=1) < NICHE_RANGE * range_m[i]
        if not (near & (turned > 1 + 2 * np.cos(NICHE_RAD))).any():
            keep.append(i)
    return np.array(keep, int)
