"""Constraint files: what `artrec train` learned about an object's components, readable and editable by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from ..core.constraints import DIMENSIONS, ConstraintSet
from ..core.errors import ConfigError
from ..core.objects import ObjectModel
from .files import Value, load_yaml, nearest

FORMAT = "artrec_constraints/1"

_HEADER = """\
# Learned by `artrec train`: for each pair of markers, how the second lies as the first sees it, over all examples.
# distance_m: between the centroids, over the scale; bearing_rad: direction to the second, from the first's axis;
# turn_rad: from the first's axis to the second's; offset_x_m, offset_y_m: in place of distance and bearing where the
# centroids nearly coincide; scale_ratio: second over first; distance_px: for the published method only.
# Intervals are [low, high]; angles run from low to high and may pass pi; a third number is the angle's period.
# allowed: what the recogniser checks; seen: the examples' own span.
"""


def load_constraints(path: str | Path, model: ObjectModel) -> ConstraintSet:
    """The constraints of `model` from their file; `ConfigError` where they are another object's."""
    value = load_yaml(path, FORMAT)
    top = value.fields(required=("object", "coverage", "pairs"))
    if top["object"].text() != model.name:
        raise top["object"].error(f"these constraints are of '{top['object'].raw}', not of object '{model.name}'")
    top["coverage"].number(0, 1)
    known = [f"{c.name}/{m.name}" for c in model.components for m in c.markers]
    for row in top["pairs"].items():
        _check_pair(row, known)
    try:
        return ConstraintSet.from_dict(value.raw)
    except ConfigError as error:
        raise value.error(str(error)) from None


def _check_pair(row: Value, known: list[str]) -> None:
    given = row.fields(required=("first", "second", "examples", "allowed", "seen"))
    for key in ("first", "second"):
        name = given[key].text()
        if name not in known:
            raise given[key].error(f"'{name}' is no component/marker of the object{nearest(name, known)}")
    given["examples"].integer(0)
    for key in ("allowed", "seen"):
        for interval in given[key].fields(optional=DIMENSIONS).values():
            _check_interval(interval)


def _check_interval(interval: Value) -> None:
    angle = interval.key.endswith("_rad")
    ends = [end.number() for end in interval.items()]
    if len(ends) not in ((2, 3) if angle else (2,)):
        wanted = "[low, high] or [low, high, period]" if angle else "[low, high]"
        raise interval.error(f"must be {wanted}, has {len(ends)} numbers")
    if ends[0] > ends[1]:
        raise interval.error(f"low {ends[0]:g} is above high {ends[1]:g}")
    if len(ends) == 3 and not 0 < ends[2] < 6.2832:
        raise interval.error(f"the period {ends[2]:g} must lie between 0 and 2 pi")


def save_constraints(path: str | Path, constraints: ConstraintSet) -> None:
    """Writes a constraint file; `ConfigError` where that is not possible."""
    rows = constraints.to_dict()
    text = f"format: {FORMAT}\n{_HEADER}" + yaml.dump(rows, Dumper=_Dumper, sort_keys=False, width=120)
    try:
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        Path(path).write_text(text, encoding="utf-8")
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written: {error.strerror}") from None


class _Dumper(yaml.SafeDumper):
    """Intervals on one line, everything else in blocks."""

    def represent_sequence(self, tag: str, sequence: Any, flow_style: bool | None = None) -> Any:
        numbers = all(isinstance(item, (int, float)) for item in sequence)
        return super().represent_sequence(tag, sequence, flow_style=numbers)
