"""Which hypotheses of an object differ enough to be worth two looks."""

from __future__ import annotations

import numpy as np

from .compiled.jit import COMPILED
from .compiled.telling_apart import first_of_cells
from .spatial import Poses
from .transforms import Array

# Sizes of a cell:
CELL_PLACE = 0.012  # of the place across the view, as a share of the depth: 0.7 degrees
CELL_LOG_DEPTH = 0.06  # 6 % of the depth
CELL_AXIS = 0.2  # of the components of the x and z axes: about 12 degrees
NICHE_RAD, NICHE_RANGE = 0.35, 0.12  # hypotheses that differ by less (in place: a share of the range) climb to one
_FACTORS = np.random.default_rng(1).integers(1, 2**62, 9) * 2 + 1


def best_distinct(poses: Poses, score: Array, n: int) -> np.ndarray:
    """Indices of the `n` best hypotheses that differ from each other, best first."""
    order = np.argsort(-score, kind="stable")
    if COMPILED:
        out = np.empty(min(n, len(order)), np.int64)
        return out[: first_of_cells(order, poses.R, poses.t, CELL_PLACE, CELL_LOG_DEPTH, CELL_AXIS, out)]
    _, first = np.unique(_keys(pose_cells(poses))[order], return_index=True)
    return order[np.sort(first)[:n]]  # the best of each cell


def pose_cells(poses: Poses) -> np.ndarray:
    """(H, 9) integers, equal for hypotheses that refinement would bring to one place."""
    depth = np.maximum(poses.t[:, 2:], 1e-6)
    place = np.column_stack([poses.t[:, :2] / depth / CELL_PLACE, np.log(depth) / CELL_LOG_DEPTH])
    cells = np.column_stack([place, poses.R[:, :, 0] / CELL_AXIS, poses.R[:, :, 2] / CELL_AXIS])
    return np.rint(np.nan_to_num(np.clip(cells, -1e9, 1e9))).astype(np.int64)  # diverged ones must not raise


def _keys(cells: np.ndarray) -> np.ndarray:
    """One number for each row of integers: rows are told apart but for one chance in 2^64."""
    return cells @ _FACTORS  # wraps round


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
