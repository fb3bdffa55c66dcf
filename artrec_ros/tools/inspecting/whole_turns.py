"""What `artrec model` says of turns after which all of an object looks the same."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np

from ...core.geometry.transforms import Array
from ...core.model.objects import ObjectModel
from ...core.model.same_turns import SameTurn, same_turns
from .structure import shortened

_NAMED = 0.999  # cosine between an axis and one of the object's frame that gives it its name
_LISTED = 3  # axes


def whole_turns(model: ObjectModel) -> Iterator[str]:
    """A line for the axes about which a turn of one angle does the same."""
    groups: dict[tuple[float, tuple[tuple[str, str], ...], tuple[str, ...]], list[SameTurn]] = {}
    for turn in same_turns(model):
        how = round(turn.angle_rad, 3), tuple(sorted(turn.places.items())), tuple(turn.bent)
        groups.setdefault(how, []).append(turn)
    # one piece that is a brick or a ball cannot help it
    kind, way_out = "note", "no picture tells how it is turned"
    if len(model.components) > 1:
        kind, way_out = "warning", f"{way_out}; a marker of a class, or in a place, of its own does"
    for (angle, places, bent), turns in groups.items():
        turned = "any turn" if turns[0].is_round else f"a turn of {math.degrees(angle):.0f} degrees"
        axes = _axes([turn.axis for turn in turns])
        yield f"{kind}: all of it looks the same after {turned} about {axes}{_besides(dict(places), bent)}: {way_out}"


def _axes(axes: Sequence[Array]) -> str:
    if len(axes) > _LISTED:
        return f"{len(axes)} axes"
    named = [_name(axis) for axis in axes]
    if all(len(name) == 1 for name in named):
        return f"its {' or '.join(named)} axis"
    return " or ".join(named)


def _name(axis: Array) -> str:
    k = int(np.argmax(np.abs(axis)))
    return "xyz"[k] if abs(axis[k]) > _NAMED else f"the axis ({', '.join(f'{v:.2f}' for v in axis)})"


def _besides(places: dict[str, str], bent: Sequence[str]) -> str:
    said = []
    if places:
        said.append(f"{shortened(list(places))} lie where {shortened(list(places.values()))} did")
    if bent:
        said.append(f"{shortened(bent)} bent otherwise")
    return f" ({'; '.join(said)})" if said else ""
