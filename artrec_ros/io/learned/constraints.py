"""Constraint files: what `artrec train` learned about an object's components, readable and editable by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from ...core.base.errors import ConfigError
from ...core.constraints.constraint_set import ConstraintSet
from ...core.constraints.pairs import DIMENSIONS
from ...core.model.objects import ObjectModel
from ..base.whole_files import save_file
from ..base.yaml_files import Value, load_yaml, nearest

FORMAT = "artrec_constraints/1"
_MOST = 1e6  # of metres, pixels, radians and ratios: what lies beyond is damage, and squares of it may overflow

_HEADER = """\
# Learned by `artrec train`: for each pair of markers, how the second lies as the first sees it, over all examples.
# distance_m: between the centroids, over the scale; bearing_rad: direction to the second, from the first's axis;
# turn_rad: from the first's axis to the second's; offset_x_m, offset_y_m: in place of distance and bearing where the
# centroids nearly coincide; scale_ratio: second over first; distance_px: for the published method only.
# Intervals are [low, high]; angles run from low to high and may pass pi; a third number is the angle's period.
# allowed: what the recogniser checks; seen: the examples' own span.
"""
_AXES = """\
# axes: how annotated axes differ from fitted outlines'. shift_m: their head lies so far from the fitted one, along the
# image's x and y, over the scale, the tail held; turn_rad: they are turned by so much; before_deg, after_deg: median
# error of the direction in the examples.
"""
_CLASSES = """\
# classes: kinds of configurations, each with the region that its own examples span in all pairs, or in all joints, at
# once. joints: positions in radians (metres where a joint slides), checked where poses in space are known; else pairs,
# here with the scale of the object's largest marker throughout.
"""


def load_constraints(path: str | Path, model: ObjectModel) -> ConstraintSet:
    """The constraints of `model` from their file; `ConfigError` where they are another object's, or there
    are none and the object needs them."""
    value = load_yaml(path, FORMAT)
    top = value.fields(required=("object", "coverage", "pairs"), optional=("classes", "axes"))
    if top["object"].text() != model.name:
        raise top["object"].error(f"these constraints are of '{top['object'].raw}', not of object '{model.name}'")
    top["coverage"].number(0, 1)
    known = ["/".join(key) for key in model.markers]
    if not top["pairs"].items() and len(model.components) > 1 and not model.is_spatial:
        raise top["pairs"].error(
            f"is empty, and not every marker of object '{model.name}' has a pose: nothing tells how its components lie "
            "to one another; learn that with artrec train"
        )
    for row in top["pairs"].items():
        _check_pair(row, known)
    for row in top["classes"].items() if "classes" in top else ():
        _check_class(row, known, list(model.joint_names))
    for row in top["axes"].items() if "axes" in top else ():
        _check_axis(row, known)
    try:
        return ConstraintSet.from_dict(value.raw)
    except ConfigError as error:
        raise value.error(str(error)) from None


def _check_class(row: Value, known: list[str], joints: list[str]) -> None:
    given = row.fields(required=("name", "examples", "pairs"), optional=("joints",))
    given["name"].text()
    given["examples"].integer(0)
    for pair in given["pairs"].items():
        _check_pair(pair, known)
    for name, joint in given["joints"].entries().items() if "joints" in given else ():
        if name not in joints:
            raise joint.error(f"'{name}' is no joint of the object{nearest(name, joints)}")
        inner = joint.fields(required=("examples", "allowed", "seen"))
        inner["examples"].integer(0)
        for key in ("allowed", "seen"):
            _check_numbers(inner[key])


def _check_axis(row: Value, known: list[str]) -> None:
    given = row.fields(required=("marker", "shift_m", "turn_rad", "examples", "before_deg", "after_deg"))
    name = given["marker"].text()
    if name not in known:
        raise given["marker"].error(f"'{name}' is no component/marker of the object{nearest(name, known)}")
    if len([v.number() for v in given["shift_m"].items()]) != 2:
        raise given["shift_m"].error("must be [x, y] in metres, along the image's axes")
    for key in ("turn_rad", "before_deg", "after_deg"):
        given[key].number()
    given["examples"].integer(0)


def _check_pair(row: Value, known: list[str]) -> None:
    given = row.fields(required=("first", "second", "examples", "allowed", "seen"))
    for key in ("first", "second"):
        name = given[key].text()
        if name not in known:
            raise given[key].error(f"'{name}' is no component/marker of the object{nearest(name, known)}")
    given["examples"].integer(0)
    for key in ("allowed", "seen"):
        for interval in given[key].fields(optional=DIMENSIONS).values():
            _check_numbers(interval)


def _check_numbers(interval: Value) -> None:
    """What they mean, the constraints themselves know."""
    for end in interval.items():
        end.number(-_MOST, _MOST)


def save_constraints(path: str | Path, constraints: ConstraintSet) -> None:
    """Writes a constraint file; `ConfigError` where that is not possible."""
    rows = constraints.to_dict()
    notes = _HEADER + (_AXES if constraints.axes else "") + (_CLASSES if constraints.classes else "")
    text = f"format: {FORMAT}\n{notes}" + yaml.dump(rows, Dumper=_Dumper, sort_keys=False, width=120)
    save_file(path, text)


class _Dumper(yaml.SafeDumper):
    """Intervals on one line, everything else in blocks."""

    def represent_sequence(self, tag: str, sequence: Any, flow_style: bool | None = None) -> Any:
        numbers = all(isinstance(item, (int, float)) for item in sequence)
        return super().represent_sequence(tag, sequence, flow_style=numbers)
