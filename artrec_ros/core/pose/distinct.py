"""Which hypotheses of an object differ enough to be worth two looks."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..base.config import SearchConfig
from ..geometry.transforms import Array
from .distinct_kernels import first_of_cells
from .poses import Poses


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
    rows, keep = np.flatnonzero(votes > least), list[int]()
    R, t = poses.R[rows].reshape(-1, 9), poses.t[rows]
    near = _are_near(np.linalg.norm(t[:, None] - t, axis=2), t, R @ R.T, turn_rad, range_share)
    for i in range(len(rows)):
        if not near[keep, i].any():
            keep.append(i)
    return np.asarray(rows[keep])


def is_near(poses: Poses, others: Poses, turn_rad: float, range_share: float) -> NDArray[np.bool_]:
    """(H,) which hypotheses are turned from others by less than an angle, and lie from them by less than a share of
    these ones' range. :param others: as many, or one."""
    trace = np.einsum("hij,hij->h", *np.broadcast_arrays(poses.R, others.R))  # of the turn from one to the other
    return _are_near(np.linalg.norm(poses.t - others.t, axis=1), others.t, trace, turn_rad, range_share)


def _are_near(off_m: Array, t: Array, trace: Array, turn_rad: float, range_share: float) -> NDArray[np.bool_]:
    """:param off_m: (..., H) from places t (H, 3).
    :param trace: (..., H) of the turns between them: 1 + 2 cos(angle).
    """
    near = off_m < range_share * np.linalg.norm(t, axis=1)
    return np.asarray(near & (trace > 1 + 2 * np.cos(turn_rad)))
