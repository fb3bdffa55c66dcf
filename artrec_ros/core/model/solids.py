"""Components of one colour all around: markers that close in what lies within, as the sides of a box do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..geometry.transforms import Array
from .marker import Marker
from .objects import ObjectModel
from .surface import MEETING, Patch, meet_all_around, patches_of


def closed_components(model: ObjectModel) -> frozenset[str]:
    """Components of a spatial model that their markers close in, or that are balls; none of others."""
    patches = patches_of(model, 0) if model.is_spatial else []
    return frozenset(model.components[c].name for c in closed_in(patches).keys() | balls_of(patches).keys())


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


def middle_of(markers: Sequence[Patch]) -> Array:
    """(3,) of a solid, by its sides."""
    return np.asarray(np.mean([p.drawn[3:].mean(axis=0) for p in markers], axis=0))


def _is_convex(markers: Sequence[Patch]) -> bool:
    corners, normals = np.concatenate([p.drawn for p in markers]), np.array([p.normal for p in markers])
    above = corners @ normals.T - [p.drawn[0] @ p.normal for p in markers]
    return bool((above <= MEETING * np.sqrt([p.area for p in markers])).all())


def shadow_m2(markers: Sequence[Patch]) -> float:
    """What a convex solid covers seen from afar: a fourth of its surface, the mean over all directions (Cauchy)."""
    return float(sum(p.area for p in markers)) / 4


def balls_of(patches: Sequence[Patch]) -> dict[int, Marker]:
    """What shows the components that are balls, by the component's index."""
    return {p.component: p.marker for p in patches if p.marker is not None and p.bulge}
