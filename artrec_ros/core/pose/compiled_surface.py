"""A spatial object's surface as compiled code takes it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ..base.config import VotesConfig
from ..base.jit import LANES
from ..geometry.transforms import Array
from ..image.codes import OUTSIDE, OWNED
from ..model.surface import Patch, free_contour
from .occlusion import BEHIND
from .surface_kernels import Surface, SurfaceLimits

if TYPE_CHECKING:
    from .surface_model import SpatialModel


def surface_limits(votes: VotesConfig) -> SurfaceLimits:
    """For compiled code; a whole number would be compiled for anew."""
    return SurfaceLimits(
        float(votes.least_cosine),
        float(votes.ring_px),
        float(votes.ring_share),
        float(votes.ring_width_px),
        float(votes.ring_visible),
        float(votes.point_px),
        BEHIND,
        OUTSIDE,
        OWNED,
        float(votes.shared[0]),
        float(votes.shared[1]),
    )


def compiled_surface(surface: SpatialModel) -> Surface:
    """The arrays of its patches, markers and boxes; see `Surface`."""
    like = _like(surface, surface.component[surface.markers], surface.marker_labels)
    marker_of = np.full(len(surface.patches), -1)
    marker_of[surface.markers] = np.arange(len(surface.markers))
    filled = [np.pad(p.finer, ((0, -len(p.finer) % LANES), (0, 0)), mode="edge") for p in surface.patches]
    return Surface(
        component=surface.component,
        stack=surface.stack,
        stacked=_stacked(surface.stack),
        normal=surface.normal,
        centre=surface.centre,
        area=surface.area,
        radius=np.array(
            [
                np.linalg.norm(np.concatenate([p.inside, p.contour]) - middle, axis=1).max()
                for p, middle in zip(surface.patches, surface.centre, strict=True)
            ]
        ),
        extent=np.array([_extent(p, middle) for p, middle in zip(surface.patches, surface.centre, strict=True)]),
        marker_of=marker_of,
        ignored=surface.ignored,
        starts=np.concatenate([[0], np.cumsum([len(points) for points in filled])]),
        count=np.array([len(p.inside) for p in surface.patches]),
        most=np.array([len(p.finer) for p in surface.patches]),
        points=np.ascontiguousarray(np.concatenate(filled).T),
        role=surface.role,
        bulge=np.array([p.bulge for p in surface.patches]),
        contour=np.ascontiguousarray(surface.contour.transpose(0, 2, 1)),
        contour_along=np.ascontiguousarray(surface.contour_along.transpose(0, 2, 1)),
        perimeter=surface.perimeter,
        half_width=surface.sides.half_widths,
        ring_role=surface.ring_role,
        rim_role=surface.rim_role,
        open_ring=free_contour(surface.model, surface.patches, surface.stack, own_class=True).astype(float),
        meets=surface.meeting,
        has_meets=(surface.meeting >= 0).any(axis=1),
        patch_of=surface.markers,
        like=like,
        pairs=np.ascontiguousarray(np.argwhere(np.triu(like, 1))),  # else laid out otherwise than where there are none
        spread=np.array([_spread(surface.patches[p]) for p in surface.markers]).reshape(-1, 2, 3),
        like_box=_like(
            surface, surface.boxes.component, [surface.model.components[c].body_labels for c in surface.boxes.component]
        ),
        table=surface.table,
        own=surface.roles.own,
        best=surface.table.max(axis=1),
        box_component=surface.boxes.component,
        box_rotation=surface.boxes.R,
        box_t=surface.boxes.t,
        half=surface.boxes.half,
        box_radius=np.linalg.norm(surface.boxes.half, axis=1),
    )


def _stacked(stack: NDArray[np.int64]) -> NDArray[np.int64]:
    """(n,) see `Surface`."""
    order = np.argsort(stack, kind="stable")
    return order[stack[order] >= 0]


def _extent(patch: Patch, middle: Array) -> Array:
    """(2, 3) see `Surface`."""
    off = np.concatenate([patch.inside, patch.finer, patch.contour]) - middle
    axes = np.linalg.svd(off, full_matrices=False)[2][:2]
    return np.asarray(axes * np.abs(off @ axes.T).max(axis=0)[:, None])


def _spread(patch: Patch) -> Array:
    """(2, 3) see `Surface`."""
    points = patch.inside - patch.inside.mean(axis=0)
    deviations, axes = np.linalg.svd(points / np.sqrt(len(points)), full_matrices=False)[1:]
    return np.asarray(deviations[:2, None] * axes[:2])


def _like(surface: SpatialModel, component: np.ndarray, labels: Sequence[Sequence[int]]) -> NDArray[np.bool_]:
    """(M, n) which of n pieces of components joints move against a marker, of those that may be of its class."""
    mine = zip(surface.component[surface.markers], surface.marker_labels, strict=True)
    pieces, moves = list(zip(component.tolist(), labels, strict=True)), surface.kinematics.moves
    rows = [
        [bool((moves[c] != moves[other]).any() and set(own) & set(theirs)) for other, theirs in pieces]
        for c, own in mine
    ]
    return np.array(rows, bool).reshape(len(surface.markers), len(pieces))
