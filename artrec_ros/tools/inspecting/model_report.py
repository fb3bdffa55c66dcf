"""What `artrec model` says of an object: from where its markers can be told, and what will be ambiguous."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from ...core.alignment.symmetry import ANY_ANGLE
from ...core.design.ambiguity import Ambiguities, Likeness, MarkerLimits
from ...core.geometry.camera import Camera
from ...core.model.objects import ObjectModel
from .oddities import hardly_meant
from .rows import in_rows
from .shared_classes import shared_classes
from .structure import shortened, structure
from .turned_identities import turned_identities
from .whole_turns import whole_turns

Key = tuple[str, str]


@dataclass(frozen=True)
class ShapeRow:
    """A shape, the markers that have it, and how far off (m) it can be used, seen straight on."""

    keys: tuple[Key, ...]
    size_m: tuple[float, float]
    found_m: float
    turn_m: float
    told_m: float

    @property
    def names(self) -> str:
        first = "/".join(self.keys[0])
        return first if len(self.keys) == 1 else f"{first} and {len(self.keys) - 1} more"


def focal_px(camera: Camera) -> float:
    """The shorter of both focal lengths."""
    return float(min(camera.matrix[0, 0], camera.matrix[1, 1]))


def shape_rows(found: Ambiguities, camera: Camera) -> list[ShapeRow]:
    """A row for each shape, in the object's order."""
    rows: dict[tuple[bytes, float], tuple[list[Key], MarkerLimits]] = {}
    for limits in found.limits:
        marker = found.model.component(limits.component).marker(limits.marker)
        shape = (np.round(marker.outline, 6).tobytes(), limits.found)
        rows.setdefault(shape, ([], limits))[0].append((limits.component, limits.marker))
    f = focal_px(camera)
    return [
        ShapeRow(tuple(keys), m.size_m, f / m.found, f / max(m.turn, m.found), f / max(found.told[key] for key in keys))
        for keys, m in rows.values()
    ]


def table(found: Ambiguities, camera: Camera) -> Iterator[str]:
    """How far off each shape is found, its direction is told, and it is told from those like it."""
    rows = shape_rows(found, camera)
    width = max(len(r.names) for r in rows)
    yield f"{'marker':{width}}  {'size mm':>9}  {'found to':>8}  {'direction to':>12}  {'told to':>7}"
    for r in rows:
        size = f"{1e3 * r.size_m[0]:.0f} x {1e3 * r.size_m[1]:.0f}"
        turn = f"{r.turn_m:.2f} m" if r.turn_m > 0 else "none"
        yield f"{r.names:{width}}  {size:>9}  {r.found_m:6.2f} m  {turn:>12}  {r.told_m:5.2f} m"


def summary(model: ObjectModel) -> str:
    """One line: components, markers, joints."""
    parts = [f"{name} {j.kind} {j.lower:g}..{j.upper:g} {j.unit}" for name, j in model.joints.items()]
    joints = f"{counted(len(parts), 'joint')} ({', '.join(parts)})" if parts else "no joints"
    components, markers = counted(len(model.components), "component"), counted(len(model.markers), "marker")
    return f"{model.name}: {components}, {markers}, {joints}"


def counted(number: int, noun: str) -> str:
    """`1 joint`, `2 joints`."""
    return f"{number} {noun}{'' if number == 1 else 's'}"


def _unsure(model: ObjectModel) -> Iterator[str]:
    """What some will be taken for it, or for which of its identities."""
    return chain(shared_classes(model), in_rows(model), turned_identities(model))


def advice(found: Ambiguities, camera: Camera | None, distance_m: float | None) -> list[str]:
    """One line for everything that will be ambiguous, hidden or too small: 'warning: ...', then 'note: ...'.

    :param camera: None: nothing of what depends on how far off the object is.
    """
    lines = [
        *(f"warning: {line}" for line in hardly_meant(found.model, 0)),
        *(f"warning: {line}" for line in _unsure(found.model)),
        *whole_turns(found.model),
        *_own_turns(found),
        *_same(found),
        *(_range(found, camera, distance_m) if camera is not None else ()),
        *structure(found.model),
    ]
    return sorted(lines, key=lambda line: line.startswith("note"))


def _own_turns(found: Ambiguities) -> Iterator[str]:
    required = found.model.required.name
    alike: dict[tuple[bool, int], dict[bytes, list[Key]]] = {}
    for m in (m for m in found.limits if m.component not in found.solids):
        shape = np.round(found.model.component(m.component).marker(m.marker).outline, 6).tobytes()
        shapes = alike.setdefault((m.component == required, m.order), {})
        shapes.setdefault(shape, []).append((m.component, m.marker))
    for (is_required, order), shapes in alike.items():
        one = sum(map(len, shapes.values())) == 1
        shown = f"{shortened([_named(group) for group in shapes.values()])} look{'s' if one else ''} the same"
        turn = "any turn" if order == ANY_ANGLE else f"a turn of {360 / max(order, 1):.0f} degrees"
        if order != 1 and is_required:
            yield f"warning: {shown} after {turn}, and all starts there: alone it tells no direction"
        elif order > 1:
            yield f"note: {shown} after {turn}: the joint or the other markers tell which way"


def _same(found: Ambiguities) -> Iterator[str]:
    """Markers of one shape, by groups."""
    required = found.model.required.name
    for group in _groups([p for p in found.alike if p.same]):
        names = shortened(["/".join(key) for key in group])
        components = {component for component, _ in group}
        if components == {required}:
            yield f"warning: {names} are alike in shape: they do not tell which side of the object is seen"
        elif required in components:
            yield f"warning: {names} are alike in shape: '{required}', from which all starts, is taken for others"
        else:
            yield f"note: {names} are alike in shape: only their places tell which is which"


def _groups(pairs: Sequence[Likeness]) -> list[list[Key]]:
    """Markers that are linked by pairs, in order."""
    groups: list[list[Key]] = []
    for p in pairs:
        touched = [g for g in groups if p.first in g or p.second in g]
        merged = [key for g in touched for key in g]
        merged += [key for key in (p.first, p.second) if key not in merged]
        groups = [g for g in groups if g not in touched] + [merged]
    return groups


def _range(found: Ambiguities, camera: Camera, distance_m: float | None) -> Iterator[str]:
    f = focal_px(camera)
    if distance_m is not None:
        for r in shape_rows(found, camera):
            if r.found_m < distance_m:
                scale = distance_m / r.found_m
                yield (
                    f"warning: {r.names} is found to {r.found_m:.2f} m only; for {distance_m:g} m make it "
                    f"{scale:.1f} times as large"
                )
    same = {key: group for group in _groups([p for p in found.alike if p.same]) for key in group}
    told = set[frozenset[Key]]()
    for p in sorted((p for p in found.alike if not p.same), key=lambda p: -p.told):
        reach = f / p.told
        first, second = (same.get(key, [key]) for key in (p.first, p.second))
        both = frozenset((first[0], second[0]))  # of several of one shape those speak for all that are most alike
        if first is second or both in told or (distance_m is not None and reach >= distance_m):
            continue
        told.add(both)
        yield (
            f"{'note' if distance_m is None else 'warning'}: {_named(first)} and {_named(second)} are told "
            f"apart to {reach:.2f} m only ({'mirror images, ' if p.mirrored else ''}most alike at "
            f"{math.degrees(p.turn_rad):.0f} degrees)"
        )


def _named(group: Sequence[Key]) -> str:
    rest = f" (and {len(group) - 1} like it)" if len(group) > 1 else ""
    return "/".join(group[0]) + rest
