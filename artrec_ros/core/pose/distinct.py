"""Which hypotheses of an object differ enough to be worth two looks."""

from __future__ import annotations

import numpy as np

from ..base.config import SearchConfig
from ..geometry.transforms import Array
from .distinct_kernels import first_of_cells
from .surface_model import Poses


def best_distinct(poses: Poses, score: Array, n: int, config: SearchConfig) -> np.ndarray:
    """Indices of the `n` best hypotheses that lie in cells of their own, best first."""
    cell = float(config.cell_place), float(config.cell_log_depth), float(config.cell_axis)
    order = np.argsort(-score, kind="stable")
    out = np.empty(min(n, len(order)), np.int64)
    return out[: first_of_cells(order, poses.R, poses.t, *cell, out)]


def apart(poses: Poses, votes: Array, least: float, turn_rad: float, range_share: float) -> np.ndarray:
    """Indices, in their order, of hypotheses with more votes than `least` that lie apart from all earlier ones of
    these: turned by more than an angle, or farther than a share of the range.

    :param poses, votes: best first.
    """
    range_m = np.linalg.norm(poses.t, axis=1)
    keep: list[int] = []
    for i in np.flatnonzero(votes > least).tolist():
        turned = np.einsum("kij,ij->k", poses.R[keep], poses.R[i])  # trace of the turn from one to the other
        near = np.linalg.norm(poses.t[keep] - poses.t[i], axis=1) < range_share * range_m[i]
        if not (near & (turned > 1 + 2 * np.cos(turn_rad))).any():
            keep.append(i)
    return np.array(keep, int)
