"""Markers of a rigid object of which one is as good as another to begin a search with.

Turned so that one side of a cylinder is where another one was, all of it is where it was. Guesses from either are the
same poses to the eye: those from one are enough, and leave room among the best for what is otherwise.
"""

from __future__ import annotations

from itertools import product

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from .layout import Layout, Placed, moves_onto, placed_markers
from .lookalikes import turns_on
from .surface_model import SpatialModel

_CUBE = np.array(list(product((-1.0, 1.0), repeat=3)))
_UP = 0.99  # cosine
_EXACT = 0.01  # corners that come as near to others, as a share of the root of the least marker's area, lie on them


def unlike_markers(surface: SpatialModel, component: int, *, stands: bool) -> list[int]:
    """Numbers of a component's markers, of those that are alike in this way the first; of an object with joints, or
    with balls, all.

    :param stands: it stands on a floor, with z up: then those alone are alike that turns about this axis exchange.
    """
    count = len(surface.markers_of[component])
    if count < 2 or surface.kinematics.n_joints or surface.sides.balls:
        return list(range(count))
    every = placed_markers(surface)
    mine = [m for m in every if m.component == component]
    corners, kept = _Corners(surface), list[int]()
    layout = Layout(every)
    for n, marker in enumerate(mine):
        if not any(_alike(marker, mine[k], every, layout, corners, stands=stands) for k in kept):
            kept.append(n)
    return kept


def _alike(
    marker: Placed, there: Placed, every: list[Placed], layout: Layout, corners: _Corners, *, stands: bool
) -> bool:
    R, t = moves_onto(marker, there, turns_on(marker, there, every))
    on: NDArray[np.bool_] = np.asarray(layout.alike(R, t).any(axis=1))
    up = R[:, 2, 2] > _UP
    roughly = np.flatnonzero(on.all(axis=1) & (up | (not stands)))
    return any(corners.stay(R[n], t[n]) for n in roughly.tolist())


class _Corners:
    """Of all markers and bodies of a rigid object, in its own frame."""

    def __init__(self, surface: SpatialModel) -> None:
        kin = surface.kinematics
        frames = kin.in_object(kin.middle[None])
        self._least_m = _EXACT * min(surface.patches[p].area for p in surface.markers) ** 0.5
        found: dict[tuple[int | str, ...], list[Array]] = {}  # by what shows there
        for c, part in enumerate(surface.model.components):
            R, t = frames.R[0, c], frames.t[0, c]
            for p in surface.markers_of[c]:
                patch = surface.patches[p]
                found.setdefault(patch.labels, []).append(patch.drawn[3:] @ R.T + t)
            for box in part.bodies:
                corners = box.T_component_box.apply(_CUBE * box.size / 2)
                found.setdefault(("body", *part.body_labels), []).append(corners @ R.T + t)
        self._of = [np.concatenate(each) for each in found.values()]

    def stay(self, R: Array, t: Array) -> bool:
        """Whether each lies on another one of its kind after a move."""
        return all(bool((_nearest(points @ R.T + t, points) < self._least_m).all()) for points in self._of)


def _nearest(points: Array, others: Array) -> NDArray[np.float64]:
    """(n,) how near the next of others is to each."""
    return np.asarray(np.linalg.norm(points[:, None] - others, axis=2).min(axis=1))
