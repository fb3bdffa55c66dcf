"""Components of one colour all around: markers that close in what lies within, as the sides of a box do."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..geometry.transforms import Array
from .objects import ObjectModel
from .surface import MEETING, Patch, meet_all_around, patches_of

_LEAST_SIDES = 12  # of what stands for a ball: a cube has six, and is none


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


def middle_of(markers: Sequence[Patch]) -> Array:
    """(3,) of a solid, by its sides."""
    return np.asarray(np.mean([p.drawn[3:].mean(axis=0) for p in markers], axis=0))


def _is_convex(markers: Sequence[Patch]) -> bool:
    corners, normals = np.concatenate([p.drawn for p in markers]), np.array([p.normal for p in markers])
    above = corners @ normals.T - [p.drawn[0] @ p.normal for p in markers]
    return bool((above <= MEETING * np.sqrt([p.area for p in markers])).all())


def shadow_m2(markers: Sequence[Patch], *, ball: bool) -> float:
    """What a convex solid covers seen from afar: of a ball, whose sides are as large as it where they look largest,
    that is along one of their normals; else a fourth of its surface, the mean over all directions (Cauchy)."""
    areas, normals = np.array([p.area for p in markers]), np.array([p.normal for p in markers])
    return float((np.abs(normals @ normals.T) @ areas).max() / 2 if ball else areas.sum() / 4)


def ball_centres(patches: Sequence[Patch]) -> dict[int, Array]:
    """(3,) the centres of components that are balls, in their own frames: with many like sides all around, each as far
    from the centre as the others, and square to the line from it."""
    found = ((c, np.mean([p.drawn[0] for p in sides], axis=0), sides) for c, sides in closed_in(patches).items())
    return {c: centre for c, centre, sides in found if len(sides) >= _LEAST_SIDES and _is_ball(sides, centre)}


def ball_sizes(patches: Sequence[Patch]) -> dict[int, tuple[Array, float]]:
    """The same with their radii, metres."""
    closed = closed_in(patches)
    return {
        c: (centre, (shadow_m2(closed[c], ball=True) / np.pi) ** 0.5) for c, centre in ball_centres(patches).items()
    }


def _is_ball(sides: Sequence[Patch], centre: Array) -> bool:
    outwards = np.array([p.drawn[0] - centre for p in sides])
    area, far_m = np.array([p.area for p in sides]), np.linalg.norm(outwards, axis=1)
    off = outwards - far_m.mean() * np.array([p.normal for p in sides])
    near = np.linalg.norm(off, axis=1) < MEETING * np.sqrt(area)
    return bool(near.all() and np.ptp(np.log(area)) < MEETING)
