"""What an object's components are to each other, as far as that has consequences: a part of `artrec model`'s report."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import combinations
from typing import NamedTuple

import cv2
import numpy as np

from ...core.geometry.polygons import distance_to_outline
from ...core.geometry.transforms import Array
from ...core.model.kinematics import Kinematics
from ...core.model.objects import ObjectModel
from ...core.model.solids import closed_components
from ...core.model.surface import ASLANT, MEETING, sample_contour

_LISTED = 6  # names on a line
_SAMPLES = 96  # of an outline
_ALONG = 0.08  # along such a share of its outline, adjoins
_BACK_TO_BACK = -0.7  # cosine: who face more away from each other are not seen together
_ONE_WAY = 0.7  # cosine: who face so nearly one way are mostly seen together
_DRAWN_PX = 100  # extent of two outlines that are laid on each other
_COVERED = 0.1  # of the smaller one: whose outlines have so much in common are not there at once
_ASIDE = 0.5  # cosine: a marker turned farther than that from all others may be seen without them


class _Placed(NamedTuple):
    """A marker in the object: its outline (n, 3) and normal (3,)."""

    name: str
    labels: tuple[int, ...]
    outline: Array
    normal: Array
    size_m: float
    component: int
    moves: tuple[bool, ...]  # by which joints it does
    is_of_solid: bool  # of a component whose markers meet all around

    @property
    def low(self) -> Array:
        return np.asarray(self.outline.min(axis=0))

    @property
    def high(self) -> Array:
        return np.asarray(self.outline.max(axis=0))


def structure(model: ObjectModel) -> Iterator[str]:
    """A line for each thing to know."""
    loose = ["/".join(key) for key, m in model.markers.items() if m.T_component_marker is None]
    if loose:
        where = "the object is found in the image plane only, with constraints from artrec train"
        yield f"note: {shortened(loose)}: no pose: {where}"
        return
    fixed = [c.name for c in model.components if c.joint is None and not c.required]
    if fixed:
        yield f"note: without joint, and so taken to be fixed to the object's frame: {', '.join(fixed)}"
    known = _placed(model)
    for names in _adjoining(known):
        yield (
            f"warning: {shortened(names)} adjoin and are of one class: seen together they are one blob, which no one's "
            "outline fits; leave a gap between them, a tenth of their width, or give them other classes"
        )
    for names in _seen_together(known):
        yield (
            f"warning: {shortened(names)} are of one component and seen at once, but one at a time counts: make "
            "each a component of its own, without joint (on what a joint moves, with a fixed one): so they bear each "
            "other out; where one at a time is there indeed, leave them"
        )
    if model.is_flat:
        return
    moves = Kinematics(model).moves.tolist()
    borne = [moved for c, moved in zip(model.components, moves, strict=True) if c.bodies]
    if bare := [c.name for c, moved in zip(model.components, moves, strict=True) if moved not in borne]:
        yield f"note: without body, so that what they hide, their own far side too, is not known: {', '.join(bare)}"
    if around := _on_other_sides(model):
        yield (
            f"note: where {shortened(around)} face the camera, '{model.required.name}' may be out of sight: there "
            "the object is told with recognizer.required: visible alone"
        )


def split_sides(model: ObjectModel) -> Iterator[str]:
    """A line for sides of one class, of components that are rigid to each other, that meet at an angle."""
    if not model.is_spatial:
        return

    def split(a: _Placed, b: _Placed) -> bool:
        return a.component != b.component and _aslant(a, b) and not (a.is_of_solid and b.is_of_solid)

    for group in _groups(_placed(model), split):
        yield (
            f"{shortened([m.name for m in group])} are sides of one class that meet: make them markers of one "
            "component; as components of their own each seems to bear out the others, and objects are told that are "
            "not there"
        )


def _adjoining(known: list[_Placed]) -> list[list[str]]:
    """Groups of markers of one class that meet along an edge; but for alternatives, and for sides that meet at an
    angle: those of one component are looked for together, of others `split_sides` tells."""
    place = _places(known)

    def beside(a: _Placed, b: _Placed) -> bool:
        if place[a.name] == place[b.name]:
            return False
        return not _aslant(a, b) or (a.component != b.component and a.is_of_solid and b.is_of_solid)

    return [[m.name for m in group] for group in _groups(known, beside)]


def _placed(model: ObjectModel) -> list[_Placed]:
    """Markers of one class each, joints mid-range; but for balls, which lie in no plane."""
    kin = Kinematics(model)
    frames, known = kin.in_object(kin.middle[None]), list[_Placed]()
    solid = closed_components(model)
    for c, part in enumerate(model.components):
        for marker in part.markers if part.ball is None else ():
            if (T := marker.T_component_marker) is not None and len(part.labels(0)) == 1:
                points = np.pad(sample_contour(marker.outline, _SAMPLES)[0], ((0, 0), (0, 1)))
                outline = T.apply(points) @ frames.R[0, c].T + frames.t[0, c]
                normal = frames.R[0, c] @ T.rotation[:, 2]
                about = outline, normal, marker.area**0.5, c, tuple(kin.moves[c].tolist()), part.name in solid
                known.append(_Placed(f"{part.name}/{marker.name}", part.labels(0), *about))
    return known


def _groups(known: list[_Placed], linked: Callable[[_Placed, _Placed], bool]) -> list[list[_Placed]]:
    """Those that meet and are linked, directly or by others."""
    groups = [[m] for m in known]
    for a, b in combinations(known, 2):
        if a.labels == b.labels and linked(a, b) and _meet(a, b):
            first, second = (next(g for g in groups if any(m is one for m in g)) for one in (a, b))
            if first is not second:
                first += second
                groups = [g for g in groups if g is not second]
    return [group for group in groups if len(group) > 1]


def _aslant(a: _Placed, b: _Placed) -> bool:
    """Whether two markers are rigid to each other and do not lie in one plane."""
    return a.moves == b.moves and abs(float(a.normal @ b.normal)) < ASLANT


def _meet(a: _Placed, b: _Placed) -> bool:
    """Whether two markers have an edge in common, or much of one's, and may be seen together."""
    near_m = MEETING * min(a.size_m, b.size_m)
    if a.normal @ b.normal <= _BACK_TO_BACK or (a.low > b.high + near_m).any() or (b.low > a.high + near_m).any():
        return False
    along = max((distance_to_outline(x.outline, y.outline) < near_m).mean() for x, y in ((a, b), (b, a)))
    return bool(along > _ALONG)


def _places(known: list[_Placed]) -> dict[str, int]:
    """A number for each marker, the same of alternatives: of one component, facing one way, and lying on each other
    directly or by others. They are views of one thing, of which one at a time is there."""
    place = {m.name: n for n, m in enumerate(known)}
    for a, b in combinations(known, 2):
        if a.component == b.component and not a.is_of_solid and _cover(a, b):
            joined = place[b.name]
            place = {name: place[a.name] if n == joined else n for name, n in place.items()}
    return place


def _cover(a: _Placed, b: _Placed) -> bool:
    """Whether two markers that face one way have much of their areas in common."""
    if a.normal @ b.normal <= _ONE_WAY or (a.low > b.high).any() or (b.low > a.high).any():
        return False
    u = a.outline[0] - a.outline.mean(axis=0)
    u /= np.linalg.norm(u)
    flat = [m.outline @ np.stack([u, np.cross(a.normal, u)], axis=1) for m in (a, b)]
    low, high = np.min([f.min(axis=0) for f in flat], axis=0), np.max([f.max(axis=0) for f in flat], axis=0)
    drawn = []
    for points in flat:
        mask = np.zeros((_DRAWN_PX + 1,) * 2, np.uint8)
        cv2.fillPoly(mask, [np.rint((points - low) / (high - low).max() * _DRAWN_PX).astype(np.int32)], 1)
        drawn.append(mask > 0)
    return bool((drawn[0] & drawn[1]).sum() > _COVERED * min(mask.sum() for mask in drawn))


def _seen_together(known: list[_Placed]) -> list[list[str]]:
    """Of each component those of its markers that face the way another one of it faces, and neither meet that nor are
    alternatives of it."""
    place, found = _places(known), dict[int, list[str]]()
    for a, b in combinations(known, 2):
        same = a.component == b.component and place[a.name] != place[b.name]
        if same and not a.is_of_solid and a.normal @ b.normal > _ONE_WAY and not _meet(a, b):
            found.setdefault(a.component, []).extend([a.name, b.name])
    return [list(dict.fromkeys(names)) for names in found.values()]


def _on_other_sides(model: ObjectModel) -> list[str]:
    """Components that are rigid to the required one, with a marker that faces where none of its own does."""
    kin, required = Kinematics(model), model.components.index(model.required)
    R = kin.in_object(kin.middle[None]).R[0]
    facing = [
        np.array([R[c] @ m.T_component_marker.rotation[:, 2] for m in part.markers if m.T_component_marker is not None])
        for c, part in enumerate(model.components)
    ]
    rigid = kin.rigid_to(required)
    return [
        part.name
        for c, part in enumerate(model.components)
        if rigid[c] and part.ball is None and ((facing[c] @ facing[required].T).max(axis=1) < _ASIDE).any()
    ]


def shortened(names: Sequence[str]) -> str:
    """Names on a line, the first few."""
    return ", ".join(names[:_LISTED]) + (f" and {len(names) - _LISTED} more" if len(names) > _LISTED else "")
