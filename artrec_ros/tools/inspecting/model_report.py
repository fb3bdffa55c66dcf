"""What `artrec model` says of an object: from where its markers can be told, and what will be ambiguous."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from ...core.alignment.symmetry import ANY_ANGLE
from ...core.design.ambiguity import Ambiguities, Likeness, MarkerLimits
from ...core.design.placement import buried_markers
from ...core.geometry.camera import Camera
from ...core.geometry.transforms import Array
from ...core.model.objects import ObjectModel
from ...core.model.surface import ASLANT, patches_of
from ...core.model.target import Target
from .rows import in_rows
from .shared_classes import shared_classes
from .structure import shortened, split_sides, structure
from .whole_turns import whole_turns

Key = tuple[str, str]

# markers of an object that are larger, or than another one by so much, are none; nor are its other lengths
_LARGE_M, _MOST_TIMES = 20.0, 100.0
_FAR_SIZES = 3.0  # an axis may leave its marker, such as for a joint beside it
_METRES = "lengths are metres: 40 mm are 0.04"
_MOST_TURN_RAD = 2 * math.pi + 0.1


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


def advice(found: Ambiguities, camera: Camera | None, distance_m: float | None) -> list[str]:
    """One line for everything that will be ambiguous, hidden or too small: 'warning: ...', then 'note: ...'.

    :param camera: None: nothing of what depends on how far off the object is.
    """
    lines = [
        *(f"warning: {line}" for line in _hardly_meant(found.model, 0)),
        *(f"warning: {line}" for line in chain(shared_classes(found.model), in_rows(found.model))),
        *whole_turns(found.model),
        *_own_turns(found),
        *_same(found),
        *(_range(found, camera, distance_m) if camera is not None else ()),
        *structure(found.model),
    ]
    return sorted(lines, key=lambda line: line.startswith("note"))


def buried(model: ObjectModel) -> Iterator[str]:
    """A line for each marker that its own component's body hides."""
    for component, marker in buried_markers(model):
        yield (
            f"{component}/{marker} lies within its component's body or looks into it and will never be seen; "
            "check its pose and which way its z axis (x_axis cross y_axis) points"
        )


def unborne(model: ObjectModel) -> Iterator[str]:
    """A line for each component with classes that no identity shows."""
    for c in model.components:
        if c.unborne:
            names = ", ".join(f"'{name}'" for name in c.unborne)
            yield f"no identity has the class {names} for '{c.name}': what shows it is no {c.name}"


def odd_units(model: ObjectModel) -> Iterator[str]:
    """A line for each length or angle that is hardly one in metres or radians."""
    markers = [("/".join(key), m) for key, m in model.markers.items()]
    sizes = {name: _norm(np.ptp(m.outline, axis=0)) for name, m in markers}
    small, large = min(sizes, key=sizes.__getitem__), max(sizes, key=sizes.__getitem__)
    if sizes[large] > _LARGE_M or sizes[large] > _MOST_TIMES * sizes[small]:
        yield f"{large} is {sizes[large]:.4g} m across, {small} {sizes[small]:.4g} m; {_METRES}"
    for what, length in _lengths(model):
        if length > _MOST_TIMES * sizes[large]:
            yield f"{what} {length:.4g} m, and the largest marker is {sizes[large]:.4g} m across; {_METRES}"
    for name, off, size in _beside_bodies(model):
        if off > _FAR_SIZES * size:
            yield f"{name} is {off:.4g} m away from its component's bodies, which are {size:.4g} m across; {_METRES}"
    for name, m in markers:
        off = max(_norm(end - m.centroid) for end in (m.tail, m.head))
        if off > _FAR_SIZES * sizes[name]:
            yield f"{name}: its axis ends {off:.4g} m away from an outline that is {sizes[name]:.4g} m across"
    for name, joint in model.joints.items():
        if joint.kind != "revolute":
            continue
        most, span = max(abs(joint.lower), abs(joint.upper)), joint.upper - joint.lower
        if max(most, span) > _MOST_TURN_RAD:
            what = f"a limit of {most:g} rad" if most > _MOST_TURN_RAD else f"from limit to limit {span:g} rad"
            yield f"joint {name}: {what} is more than a turn; limits are radians: 70 degrees are 1.22"


def _beside_bodies(model: ObjectModel) -> Iterator[tuple[str, float, float]]:
    """Of each marker that has a place how far it is from the nearest of its component's bodies, and how large the
    largest of these is."""
    for c in model.components:
        size = max((_norm(box.size) for box in c.bodies), default=0.0)
        for m in c.markers if c.bodies else ():
            if m.T_component_marker is not None:
                middle = m.T_component_marker.apply(np.array([*m.centroid, 0.0]))
                within = [np.abs(b.T_component_box.inverse().apply(middle)) - b.size / 2 for b in c.bodies]
                yield f"{c.name}/{m.name}", min(_norm(np.maximum(off, 0.0)) for off in within), size


def _lengths(model: ObjectModel) -> Iterator[tuple[str, float]]:
    """What beside outlines is told in metres, as a message begins."""
    for c in model.components:
        for m in c.markers:
            if m.T_component_marker is not None:
                yield f"{c.name}/{m.name} is off its component's frame by", _norm(m.T_component_marker.position)
        for box in c.bodies:
            yield f"a body of {c.name} is off its frame by", _norm(box.T_component_box.position)
            yield f"a body of {c.name} measures", _norm(box.size)
        if c.joint is not None:
            yield f"the joint of {c.name} is off its parent's frame by", _norm(c.joint.T_parent_joint.position)
            if c.joint.kind == "prismatic":
                yield f"the joint of {c.name} slides by", max(abs(c.joint.lower), abs(c.joint.upper))


def _norm(vector: Array) -> float:
    return float(np.linalg.norm(vector))


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


def on_own_colour(model: ObjectModel, label: int = 0) -> Iterator[str]:
    """A line for each component whose markers lie on more of their own class.

    :param label: of those without one of their own; 0: not known.
    """
    own = [n for n, c in enumerate(model.components) if c.body_label is not None and c.body_label in c.labels(label)]
    patches = patches_of(model, label) if own and model.is_spatial else []
    for n in own:
        bare = np.array([p.normal for p in patches if p.component == n and p.marker is None]).reshape(-1, 3)
        borne = np.array([p.normal for p in patches if p.component == n and p.marker is not None]).reshape(-1, 3)
        around = not model.is_spatial or (bare @ borne.T > ASLANT).any()  # else they cover the sides that they are on
        if around:
            c = model.components[n]
            yield f"the markers of '{c.name}' have the class of its body ({c.body_label}) and cannot be seen on it"


def oddities(target: Target) -> Iterator[str]:
    """A line for what is hardly meant in the object file of something that is looked for or drawn."""
    yield from (f"{target.name}: {line}" for line in _hardly_meant(target.model, target.label))


def _hardly_meant(model: ObjectModel, label: int) -> Iterator[str]:
    return chain(buried(model), odd_units(model), on_own_colour(model, label), unborne(model), split_sides(model))


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
