"""What a camera sees of a spatial object: sample points of its markers and body faces.

Each patch (a marker or one face of a box) carries points in its component's frame, an outward
normal, its area, and a role that says which labels support it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..base.errors import ConfigError
from ..geometry.polygons import distance_to_outline, signed_area
from ..geometry.transforms import Array
from .marker import Marker
from .objects import Component, ObjectModel

INSIDE_POINTS = 36  # per marker: about the pixels of the smallest useful one
MOST_POINTS = 144  # of a large one: these, and more that go on with the same sequence
CONTOUR_POINTS = 32  # per marker
FACE_POINTS = 20  # per box face
COVER_DEPTH_M = 0.02  # a marker this close in front of a face hides it
_BEYOND = 0.1  # of a marker's width: so far outside of its contour it is looked for others
MEETING = 0.05  # of a marker's width: who is so near meets it
_ROUNDED_M = 2e-5  # object files that are written have places to a hundredth of a millimetre
_SLIVER = 0.02  # of its bounding box: sampled in that, what is narrower takes long
_MOST_DRAWN = 1 << 18  # points: where fewer than one in a thousand lies inside there is none to speak of
ASLANT = 0.97  # cosine between normals of markers that meet at an angle, and do not lie in one plane


@dataclass(frozen=True)
class Patch:
    """One flat piece of surface.

    :param component: index into the model's components.
    :param marker: the marker shown, None for a box face.
    :param labels: class labels of which one is expected on it; none where unknown.
    :param inside: (n, 3) points on it, component frame; each stands for area / n.
    :param finer: (k, 3) the same and more of them, for markers of many pixels.
    :param drawn: (3 + k, 3) a marker's centroid, its axis' tail and head, and its outline's corners.
    :param contour, contour_along: (m, 3) points of a marker's outline and its unit directions there, counter-clockwise
        as seen from the front.
    :param normal: (3,) outward.
    :param area: square metres.
    """

    component: int
    marker: Marker | None
    labels: tuple[int, ...]
    inside: Array
    finer: Array
    drawn: Array
    contour: Array
    contour_along: Array
    normal: Array
    area: float

    @property
    def bulge(self) -> float:
        """By how much what it stands for lies before it, metres: a ball's radius; 0: it is flat."""
        return self.marker.radius if self.marker is not None and self.marker.is_ball else 0.0


def patches_of(model: ObjectModel, label: int) -> list[Patch]:
    """Every marker of a spatial model, and every face of its boxes, but for those that are closed in by markers which
    meet all around; `label` is the object's class."""
    out: list[Patch] = []
    for c, component in enumerate(model.components):
        markers = [_marker_patch(c, m, component.labels(label)) for m in component.markers]
        out += markers
        if component.bodies and component.ball is None and not meet_all_around(markers):
            out += _face_patches(c, component)
    return out


def is_on_unknown(patches: list[Patch]) -> bool:
    """Whether a body whose class is not known may show beyond the outlines of markers: the component's own, where these
    do not cover it, or that of another one behind it."""
    return any(p.marker is None and not p.labels for p in patches)


def free_contour(
    model: ObjectModel, patches: list[Patch], stack: NDArray[np.int64], *, own_class: bool
) -> NDArray[np.bool_]:
    """(M, m) bool of the contour points of all markers: beyond which no other marker of the object begins.

    Only markers of which nothing moves one against the other are told, and that are there at once.

    :param stack: (P,) see `stacks_of`.
    :param own_class: only of others that may be of the same class: these, just outside, would say nothing against the
        outline.
    """
    markers = [(p, n) for p, n in zip(patches, stack.tolist(), strict=True) if p.marker is not None]
    out = np.ones((len(markers), CONTOUR_POINTS), bool)
    for row, (mine, own) in zip(out, markers, strict=True):
        beyond = mine.contour + _BEYOND * np.sqrt(mine.area) * np.cross(mine.contour_along, mine.normal)
        for other, its in markers:
            fixed = mine.component == other.component or all(
                model.components[p.component].joint is None for p in (mine, other)
            )
            balls = mine.bulge or other.bulge  # what lies beyond these is a matter of the view, not of the model
            at_once = other is not mine and (own < 0 or own != its)
            if at_once and fixed and not balls and (not own_class or set(mine.labels) & set(other.labels)):
                row[covers(other, beyond)] = False
    return out


def meeting_contour(patches: list[Patch]) -> NDArray[np.int64]:
    """(M, m) which marker of its component each point of a marker's contour meets at an angle, -1: none.

    Two sides of a box of one colour meet so: while both are in view nothing ends where they do.
    """
    markers = [p for p in patches if p.marker is not None]
    out = np.full((len(markers), CONTOUR_POINTS), -1)
    normal, component = np.array([p.normal for p in markers]), np.array([p.component for p in markers])
    centre = np.array([p.drawn[0] for p in markers])
    radius = np.array([np.linalg.norm(p.drawn[3:] - p.drawn[0], axis=1).max() for p in markers])
    for n, mine in enumerate(markers):
        near_m = MEETING * np.sqrt(mine.area)
        nearest = np.full(CONTOUR_POINTS, near_m)
        in_reach = np.linalg.norm(centre - centre[n], axis=1) < radius + radius[n] + near_m
        aslant = np.abs(normal @ normal[n]) < ASLANT
        for j in np.flatnonzero(in_reach & aslant & (component == component[n])).tolist():
            off = _off(markers[j], mine.contour)
            out[n, off < nearest] = j
            nearest = np.minimum(nearest, off)
    return out


def meet_all_around(markers: list[Patch]) -> bool:
    """Whether one component's markers close in what lies within, as the sides of a box of one colour do."""
    return bool((meeting_contour(markers) >= 0).all())


def _off(patch: Patch, points: Array) -> Array:
    """(n,) how far points (n, 3) of its component's frame are from a marker's patch; as if they lay in its plane where
    they lie above its inside."""
    assert patch.marker is not None and patch.marker.T_component_marker is not None
    local, outline = patch.marker.T_component_marker.inverse().apply(points), patch.marker.outline
    aside = np.where(contains(outline, local[:, :2]), 0.0, distance_to_outline(local[:, :2], outline))
    return np.asarray(np.hypot(aside, local[:, 2]))


def covers(patch: Patch, points: Array) -> np.ndarray:
    """(n,) bool: which points (n, 3) of its component's frame lie on a marker's patch."""
    assert patch.marker is not None and patch.marker.T_component_marker is not None
    local = patch.marker.T_component_marker.inverse().apply(points)
    on = np.abs(local[:, 2]) < _BEYOND * np.sqrt(patch.area)
    return np.asarray(on & contains(patch.marker.outline, local[:, :2]))


def sample_polygon(outline: Array, n: int) -> Array:
    """(n, 2) evenly spread points inside a polygon (m, 2).

    A low-discrepancy sequence, not a lattice: a lattice keeps off the border by half its step, and so would not
    notice that a model outgrows its blob.

    :raises ConfigError: it has no area to speak of.
    """
    low, high = outline.min(axis=0), outline.max(axis=0)
    if abs(signed_area(outline)) > _SLIVER * np.prod(high - low):
        return _sample_in_box(outline, n)
    middle = outline.mean(axis=0)  # of what its bounding box holds hardly any of, one along its axes may hold more
    _, _, axes = np.linalg.svd(outline - middle, full_matrices=False)
    along = (outline - middle) @ axes.T
    return _sample_in_box(along, n) @ axes + middle


def _sample_in_box(outline: Array, n: int) -> Array:
    low, high = outline.min(axis=0), outline.max(axis=0)
    found = np.zeros((0, 2))
    draw = 4 * n
    while len(found) < n:
        if draw > _MOST_DRAWN:
            raise ConfigError("an outline is so thin and bent that it has no inside to speak of")
        # Roberts' R2 sequence: steps of the plastic number's inverse powers
        unit = (0.5 + np.arange(1, draw + 1)[:, None] * (0.7548776662466927, 0.5698402909980532)) % 1
        points = low + unit * (high - low)
        found = points[contains(outline, points)]
        draw *= 2
    return found[:n]


def contains(outline: Array, points: Array) -> np.ndarray:
    """(k,) bool: which points (k, 2) lie inside the polygon (n, 2); even-odd rule."""
    a, b = outline, np.roll(outline, -1, axis=0)
    x, y = points[:, None, 0], points[:, None, 1]
    crosses = (a[:, 1] > y) != (b[:, 1] > y)  # (k, n)
    with np.errstate(divide="ignore", invalid="ignore"):
        at = a[:, 0] + (y - a[:, 1]) / (b[:, 1] - a[:, 1]) * (b[:, 0] - a[:, 0])
    return (np.sum(crosses & (x < at), axis=1) % 2).astype(bool)


def sample_contour(outline: Array, n: int) -> tuple[Array, Array]:
    """`n` points at equal arc length along a polygon, and their outward unit normals, both (n, 2)."""
    edges = np.roll(outline, -1, axis=0) - outline
    lengths = np.linalg.norm(edges, axis=1)
    ends = np.cumsum(lengths)
    s = (np.arange(n) + 0.5) * ends[-1] / n
    i = np.searchsorted(ends, s)
    along = (s - (ends[i] - lengths[i])) / lengths[i]
    points = outline[i] + along[:, None] * edges[i]
    normals = np.sign(signed_area(outline)) * np.stack([edges[i, 1], -edges[i, 0]], axis=-1) / lengths[i, None]
    return points, normals


def _marker_patch(c: int, marker: Marker, labels: tuple[int, ...]) -> Patch:
    T = marker.T_component_marker
    assert T is not None  # ObjectModel.is_spatial is the caller's condition
    lift = lambda p: T.apply(np.pad(p, ((0, 0), (0, 1))))  # noqa: E731
    contour, normals = sample_contour(marker.outline, CONTOUR_POINTS)
    finer = lift(sample_polygon(marker.outline, MOST_POINTS))
    along = np.cross(T.rotation[:, 2], np.pad(normals, ((0, 0), (0, 1))) @ T.rotation.T)
    drawn = np.vstack([marker.centroid, marker.tail, marker.head, marker.outline])
    inside, contour, normal = finer[:INSIDE_POINTS], lift(contour), T.rotation[:, 2]
    return Patch(c, marker, labels, inside, finer, lift(drawn), contour, along, normal, marker.area)


def _face_patches(c: int, component: Component) -> list[Patch]:
    out = []
    for box in component.bodies:
        for axis in range(3):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            rectangle = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * box.size[[u, v]] / 2
            grid = sample_polygon(rectangle, FACE_POINTS)
            for sign in (-1.0, 1.0):
                local = np.zeros((len(grid), 3))
                local[:, u], local[:, v], local[:, axis] = grid[:, 0], grid[:, 1], sign * box.size[axis] / 2
                points = box.T_component_box.apply(local)
                normal = sign * box.T_component_box.rotation[:, axis]
                free = ~_covered(component, points, normal)
                if free.any():
                    area = float(box.size[u] * box.size[v] * free.mean())
                    none = np.zeros((0, 3))
                    labels = component.body_labels
                    out.append(Patch(c, None, labels, points[free], points[free], none, none, none, normal, area))
    return out


def _covered(component: Component, points: Array, normal: Array) -> np.ndarray:
    """(n,) bool: which points of a face lie under a marker of the same component."""
    hidden = np.zeros(len(points), bool)
    for marker in component.markers:
        T = marker.T_component_marker
        if T is None or T.rotation[:, 2] @ normal < 0.9:
            continue
        local = T.inverse().apply(points)
        close = (local[:, 2] <= _ROUNDED_M) & (local[:, 2] > -COVER_DEPTH_M)
        hidden |= close & contains(marker.outline, local[:, :2])
    return hidden
