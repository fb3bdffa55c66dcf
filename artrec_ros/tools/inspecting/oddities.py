"""What is hardly meant in an object file: markers that can't be seen, lengths that are no metres, classes of nobody."""

from __future__ import annotations

import math
from collections.abc import Iterator
from itertools import chain

import numpy as np

from ...core.design.placement import buried_markers
from ...core.geometry.transforms import Array
from ...core.model.objects import ObjectModel
from ...core.model.surface import ASLANT, patches_of
from ...core.model.target import Target
from .structure import split_sides

# markers of an object that are larger, or than another one by so much, are none; nor are its other lengths
_LARGE_M, _MOST_TIMES = 20.0, 100.0
_FAR_SIZES = 3.0  # an axis may leave its marker, such as for a joint beside it
_METRES = "lengths are metres: 40 mm are 0.04"
_MOST_TURN_RAD = 2 * math.pi + 0.1


def buried(model: ObjectModel) -> Iterator[str]:
    """A line for each marker that its own component's body hides."""
    for component, marker in buried_markers(model):
        yield (
            f"{component}/{marker} lies within its component's body or looks into it and will never be seen; "
            "check its pose and which way its z axis (x_axis cross y_axis) points"
        )


def unborne(model: ObjectModel) -> Iterator[str]:
    """A line where components have classes that no identity shows."""
    lacking = [(", ".join(f"'{name}'" for name in c.unborne), c.name) for c in model.components if c.unborne]
    if lacking:
        listed = ", nor ".join(f"{classes} for '{component}'" for classes, component in lacking)
        yield f"no identity has the class {listed}: what shows it there is none of the object's"


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
    """A line for what is hardly meant in the object file of something that is looked for or drawn: but for `unborne`,
    which may be meant, as of a team that lacks some of its robots."""
    yield from (f"{target.name}: {line}" for line in _mistakes(target.model, target.label))


def hardly_meant(model: ObjectModel, label: int) -> Iterator[str]:
    """A line for each. :param label: of components without one of their own; 0: not known."""
    return chain(_mistakes(model, label), unborne(model))


def _mistakes(model: ObjectModel, label: int) -> Iterator[str]:
    return chain(buried(model), odd_units(model), on_own_colour(model, label), split_sides(model))
