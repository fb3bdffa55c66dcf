"""What an object's components are to each other, as far as that has consequences: a part of `artrec model`'s report."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import combinations

import numpy as np

from ...core.geometry.polygons import distance_to_outline
from ...core.model.kinematics import Kinematics
from ...core.model.objects import ObjectModel
from ...core.model.surface import ASLANT, MEETING
from .marker_places import ONE_WAY, Placed, placed, places

_LISTED = 6  # names on a line
_ALONG = 0.08  # along such a share of its outline, adjoins
_BACK_TO_BACK = -0.7  # cosine: who face more away from each other are not seen together
_ASIDE = 0.5  # cosine: a marker turned farther than that from all others may be seen without them

_ONE_OF_THEM = "keep the one that shows most often, or leave the poses out and learn constraints (artrec train)"


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
    yield from _of_markers(model)
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


def _of_markers(model: ObjectModel) -> Iterator[str]:
    """A line for each group of markers whose places go ill together."""
    known = placed(model)
    of_one_class = [m for m in known if len(m.labels) == 1]
    for names in _adjoining(of_one_class):
        yield (
            f"warning: {shortened(names)} adjoin and are of one class: seen together they are one blob, which no one's "
            "outline fits; leave a gap between them, a tenth of their width, or give them other classes"
        )
    for names in _seen_together(of_one_class):
        yield (
            f"warning: {shortened(names)} are of one component and seen at once, but one component counts once: make "
            "each a component of its own, without joint (on what a joint moves, with a fixed one): so they bear each "
            f"other out; where one at a time is there indeed, {_ONE_OF_THEM}"
        )


def split_sides(model: ObjectModel) -> Iterator[str]:
    """A line for sides of one class, of components that are rigid to each other, that meet at an angle."""
    if not model.is_spatial:
        return

    def split(a: Placed, b: Placed) -> bool:
        return a.component != b.component and _aslant(a, b) and not (a.is_of_solid and b.is_of_solid)

    for group in _groups([m for m in placed(model) if len(m.labels) == 1], split):
        yield (
            f"{shortened([m.name for m in group])} are sides of one class that meet: make them markers of one "
            "component; as components of their own each seems to bear out the others, and objects are told that are "
            "not there"
        )


def _adjoining(known: list[Placed]) -> list[list[str]]:
    """Groups of markers of one class that meet along an edge; but for alternatives, and for sides that meet at an
    angle: those of one component are looked for together, of others `split_sides` tells."""
    place = places(known)

    def beside(a: Placed, b: Placed) -> bool:
        if place[a.name] == place[b.name]:
            return False
        return not _aslant(a, b) or (a.component != b.component and a.is_of_solid and b.is_of_solid)

    return [[m.name for m in group] for group in _groups(known, beside)]


def _groups(known: list[Placed], linked: Callable[[Placed, Placed], bool]) -> list[list[Placed]]:
    """Those that meet and are linked, directly or by others."""
    groups = [[m] for m in known]
    for a, b in combinations(known, 2):
        if a.labels == b.labels and linked(a, b) and _meet(a, b):
            first, second = (next(g for g in groups if any(m is one for m in g)) for one in (a, b))
            if first is not second:
                first += second
                groups = [g for g in groups if g is not second]
    return [group for group in groups if len(group) > 1]


def _aslant(a: Placed, b: Placed) -> bool:
    """Whether two markers are rigid to each other and do not lie in one plane."""
    return a.moves == b.moves and abs(float(a.normal @ b.normal)) < ASLANT


def _meet(a: Placed, b: Placed) -> bool:
    """Whether two markers have an edge in common, or much of one's, and may be seen together."""
    near_m = MEETING * min(a.size_m, b.size_m)
    if a.normal @ b.normal <= _BACK_TO_BACK or (a.low > b.high + near_m).any() or (b.low > a.high + near_m).any():
        return False
    along = max((distance_to_outline(x.outline, y.outline) < near_m).mean() for x, y in ((a, b), (b, a)))
    return bool(along > _ALONG)


def _seen_together(known: list[Placed]) -> list[list[str]]:
    """Of each component those of its markers that face the way another one of it faces, and neither meet that nor are
    alternatives of it."""
    place, found = places(known), dict[int, list[str]]()
    for a, b in combinations(known, 2):
        same = a.component == b.component and place[a.name] != place[b.name]
        if same and not a.is_of_solid and a.normal @ b.normal > ONE_WAY and not _meet(a, b):
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
