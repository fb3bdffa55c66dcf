"""Views of markers of one class that meet at an angle, such as the sides of a box of one colour, and of balls of one.

Seen together they are one blob, whose outline is that of none of them; what else is rigid to them may lie before it.
What they look like together depends on the direction from which they are seen; one of the bank's is near to any.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ..base.config import GuessesConfig
from ..geometry.polygons import signed_area
from ..geometry.spread import all_around
from ..geometry.transforms import Array
from ..model.surface import MEETING
from .surface_model import SpatialModel
from .views import MarkerView, view_of

_EXTENT_PX = 160  # of what is drawn: a pixel is nothing beside the angle between two directions
_LEAST_PIECE = 0.15  # of the largest: what lies before it may leave it in several, and none that is smaller tells much
_LEAST_PX = 4.0  # what is smaller has no outline
_CIRCLE = np.stack([np.cos(np.pi * np.arange(32) / 16), np.sin(np.pi * np.arange(32) / 16)], axis=1)
_SQUARE = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])


class Solid(NamedTuple):
    """Markers of one component that meet, or a ball that touches another one of its class.

    :ivar centre: (3,) amid them, in its frame: origin of the views' outlines.
    :ivar flips: (1, V, 3, 3) of each view the component's turn on the optical axis.
    """

    centre: Array
    views: list[MarkerView]
    flips: Array


class _Face(NamedTuple):
    """A flat piece in the frame of a component: its outline (n, 3), its normal (3,), and whether it has the class. Or a
    ball's disc, whose radius is told, metres; of others that is 0."""

    outline: Array
    normal: Array
    has_class: bool
    ball: float = 0.0

    def seen(self, turn: Array, centre: Array) -> tuple[Array, Array]:
        """Its outline (n, 3) and its normal along a camera's axes, about a centre."""
        if not self.ball:
            return (self.outline - centre) @ turn.T, turn @ self.normal
        at = turn @ (self.outline.mean(axis=0) - centre)
        return at + self.ball * np.array([*_CIRCLE.T, np.full(len(_CIRCLE), -1.0)]).T, np.array([0.0, 0.0, -1.0])


def solids_of(surface: SpatialModel, component: int, config: GuessesConfig) -> list[Solid]:
    """Of all groups of one component's markers that meet."""
    groups = list(_groups(surface, component))
    faces = _rigid_faces(surface, component) if groups else []
    solids = [_solid(surface, group, faces, config) for group in groups]
    return [solid for solid in solids if solid.views]  # others are not seen together


def _groups(surface: SpatialModel, component: int) -> Iterator[list[int]]:
    """Rows of markers that lead to each other."""
    left = set(np.flatnonzero(surface.component[surface.markers] == component).tolist())
    meets = _meet(surface, sorted(left))
    while left:
        group, new = set[int](), {min(left)}
        while new:
            group |= new
            new = {j for j in left - group if any((k, j) in meets for k in new)}
        left -= group
        if len(group) > 1 or _touches(surface, component):
            yield sorted(group)


def _touches(surface: SpatialModel, component: int) -> bool:
    """Whether a component is a ball, and another ball of its class that is rigid to it touches it: both make one
    blob."""
    kin, parts, labels = surface.kinematics, surface.model.components, surface.labels
    mine, frames = parts[component].ball, kin.in_object(kin.middle[None])
    for other in np.flatnonzero(kin.rigid_to(component)).tolist() if mine is not None else ():
        ball = parts[other].ball
        if mine is not None and ball is not None and set(labels[component]) & set(labels[other]):
            one, two = (frames.R[0, c] @ b.centre + frames.t[0, c] for c, b in ((component, mine), (other, ball)))
            if np.linalg.norm(one - two) < (1 + MEETING) * (mine.radius + ball.radius):
                return True
    return False


def _meet(surface: SpatialModel, rows: list[int]) -> set[tuple[int, int]]:
    """Pairs of markers of which either one's contour meets the other: a short edge may have none of its own points."""
    found = {(k, int(j)) for k in rows for j in np.unique(surface.meeting[k]) if j >= 0}
    return found | {(j, k) for k, j in found}


def _rigid_faces(surface: SpatialModel, component: int) -> list[_Face]:
    """Markers and sides of bodies of a component, and of all that are rigid to it."""
    kin, labels = surface.kinematics, set(surface.labels[component])
    frames, out = kin.in_object(kin.middle[None]), list[_Face]()
    R_own, t_own = frames.R[0, component], frames.t[0, component]
    for c in [component, *np.flatnonzero(kin.rigid_to(component)).tolist()]:
        R, t = R_own.T @ frames.R[0, c], R_own.T @ (frames.t[0, c] - t_own)
        for p in surface.markers_of[c]:
            patch = surface.patches[p]
            has_class = bool(labels & set(patch.labels))
            out.append(_Face(patch.drawn[3:] @ R.T + t, R @ patch.normal, has_class, patch.bulge))
        part = surface.model.components[c]
        bodies = part.bodies if (surface.component[~surface.is_marker] == c).any() else ()  # else markers close it in
        for box, axis, sign in product(bodies, range(3), (-1.0, 1.0)):
            corners = np.empty((4, 3))
            corners[:, (axis + 1) % 3], corners[:, (axis + 2) % 3], corners[:, axis] = *_SQUARE.T, sign
            normal = R @ (sign * box.T_component_box.rotation[:, axis])
            corners = box.T_component_box.apply(corners * box.size / 2) @ R.T + t
            out.append(_Face(corners, normal, bool(labels & set(part.body_labels))))
    return out


def _solid(surface: SpatialModel, group: list[int], faces: list[_Face], config: GuessesConfig) -> Solid:
    patches = [surface.patches[p] for p in surface.markers[group]]
    centre, normals = np.mean([p.drawn[0] for p in patches], axis=0), np.array([p.normal for p in patches])
    meets = _meet(surface, group)
    meet = np.array([[(k, j) in meets for j in group] for k in group])
    gap_m, least = MEETING * min(p.area for p in patches) ** 0.5, surface.limits.least_cosine
    views, turns = list[MarkerView](), list[Array]()
    for turn in _turns_around(config.solid_directions):
        seen = normals @ turn[2] < -least
        if len(group) == 1 or meet[np.ix_(seen, seen)].any():
            for outline in _silhouettes(faces, turn, centre, gap_m):
                views.append(view_of(outline, abs(signed_area(outline)), config))
                turns.append(turn)
    return Solid(centre, views, np.array(turns)[None])


def _turns_around(n: int) -> NDArray[np.float64]:
    """(n, 3, 3) turns that show a body from evenly spread directions: of a camera's axes x (right), y (down), z (ahead)
    in the body's frame."""
    ahead = all_around(n)
    aside = np.where(np.abs(ahead[:, 2:]) < 0.9, (0.0, 0.0, 1.0), (1.0, 0.0, 0.0))
    right = np.cross(ahead, aside)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    return np.stack([right, np.cross(ahead, right), ahead], axis=1)


def _silhouettes(faces: list[_Face], turn: Array, centre: Array, gap_m: float) -> list[Array]:
    """Outlines (n, 2), about a centre, of the pieces that are seen of a class: what is nearer hides what is behind it,
    and gaps are closed."""
    shown = [f for f in faces if f.ball or f.normal @ turn[2] < 0]
    placed = [f.seen(turn, centre) for f in shown]
    every = np.concatenate([p[:, :2] for (p, _), f in zip(placed, shown, strict=True) if f.has_class])
    low, unit = every.min(axis=0), float(np.ptp(every, axis=0).max()) / _EXTENT_PX
    gap_px = round(gap_m / unit)
    size, margin = _EXTENT_PX + 2 * gap_px + 3, gap_px + 1
    y, x = np.mgrid[:size, :size]
    nearest, own = np.full((size, size), np.inf), np.zeros((size, size), np.uint8)
    for (points, slope), face in zip(placed, shown, strict=True):
        mask = np.zeros((size, size), np.uint8)
        cv2.fillPoly(mask, [np.rint((points[:, :2] - low) / unit + margin).astype(np.int32)], 1)
        at = (points[0, :2] - low) / unit + margin
        depth = points[0, 2] - unit * ((x - at[0]) * slope[0] + (y - at[1]) * slope[1]) / slope[2]
        before = (mask > 0) & (depth < nearest - 1e-9)
        nearest[before], own[before] = depth[before], face.has_class
    own = cv2.morphologyEx(own, cv2.MORPH_CLOSE, np.ones((gap_px + 1,) * 2, np.uint8))
    contours, _ = cv2.findContours(own, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_SIMPLE)
    least_px = max(_LEAST_PIECE * max(map(cv2.contourArea, contours), default=0.0), _LEAST_PX)
    pieces = [cv2.approxPolyDP(c, 0.5, True)[:, 0] for c in contours if cv2.contourArea(c) > least_px]
    return [(piece - margin) * unit + low for piece in pieces if cv2.contourArea(piece) > _LEAST_PX]
