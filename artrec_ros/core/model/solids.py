"""Components of one colour all around: markers that close in what lies within, as the sides of a box do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..geometry.transforms import Array
from .objects import ObjectModel
from .surface import MEETING, Patch, meet_all_around, patches_of

_ROUND = 0.7  # a dodecahedron's sides are 0.79 as far off as its corners, a cube's 0.58


def closed_components(model: ObjectModel) -> frozenset[str]:
    """Components of a spatial model that their markers close in; none of others."""
    patches = patches_of(model, 0) if model.is_spatial else []
    return frozenset(model.components[c].name for c in closed_in(patches))


def closed_in(patches: Sequence[Patch]) -> dict[int, list[Patch]]:
    """The markers of each component that they close in, by the component's index."""
    of: dict[int, list[Patch]] = {}
    for patch in patches:
        if patch.marker is not None:
            of.setdefault(patch.component, []).append(patch)
    return {c: markers for c, markers in of.items() if len(markers) > 1 and meet_all_around(markers)}


def convex_solids(patches: Sequence[Patch]) -> frozenset[int]:
    """Components that markers close in and that bulge nowhere inwards: their outline in an image is the convex hull of
    what is drawn of the sides in view."""
    return frozenset(c for c, markers in closed_in(patches).items() if _is_convex(markers))


def balls(patches: Sequence[Patch]) -> frozenset[int]:
    """Those of the convex solids that no picture tells the turn of: their sides are nearly as far from their middle as
    their corners."""
    closed = closed_in(patches)
    return frozenset(c for c in convex_solids(patches) if _is_ball(closed[c]))


def middle_of(markers: Sequence[Patch]) -> Array:
    """(3,) of a solid, by its sides."""
    return np.asarray(np.mean([p.drawn[3:].mean(axis=0) for p in markers], axis=0))


def _is_ball(markers: Sequence[Patch]) -> bool:
    middle = middle_of(markers)
    sides = [abs((p.drawn[0] - middle) @ p.normal) for p in markers]
    corners = [np.linalg.norm(p.drawn[3:] - middle, axis=1).max() for p in markers]
    return bool(min(sides) > _ROUND * max(corners))


def _is_convex(markers: Sequence[Patch]) -> bool:
    corners, normals = np.concatenate([p.drawn for p in markers]), np.array([p.normal for p in markers])
    above = corners @ normals.T - [p.drawn[0] @ p.normal for p in markers]
    return bool((above <= MEETING * np.sqrt([p.area for p in markers])).all())
