"""Places in object files: poses, and what has one and no more than a few lengths."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from ...core.geometry.transforms import Array, Pose
from ...core.model.objects import Box
from ..base.yaml_files import Value
from .solids import Solid, ball_solid, box_solid, cylinder_solid

MOST_M = 1000.0  # of any length: more is a wrong unit, and much more overflows
_MOST_RAD = 1000.0


def read_pose(value: Value) -> Pose:
    """xyz with rpy, or xyz with the directions of the frame's x and y axes; each may be left out."""
    given = value.fields(optional=("xyz", "rpy", "x_axis", "y_axis"))
    xyz = given["xyz"].vector(3, MOST_M) if "xyz" in given else np.zeros(3)
    if "x_axis" not in given and "y_axis" not in given:
        return Pose.from_xyz_rpy(xyz, given["rpy"].vector(3, _MOST_RAD) if "rpy" in given else (0.0, 0.0, 0.0))
    if "rpy" in given or not ("x_axis" in given and "y_axis" in given):
        raise value.error("the turn is given by rpy, or by x_axis and y_axis together")
    x, y = read_direction(given["x_axis"]), read_direction(given["y_axis"])
    if abs(x @ y) > 1e-6:
        raise given["y_axis"].error("must be at a right angle to x_axis")
    return Pose(np.stack([x, y, np.cross(x, y)], axis=1), xyz)


def read_direction(value: Value) -> Array:
    """(3,) of length 1. :raises ConfigError: naming file and key: it is none."""
    v = value.vector(3, 1e6)
    if np.linalg.norm(v) < 1e-9:
        raise value.error("is no direction: its length is zero")
    return v / np.linalg.norm(v)


def _pose_among(value: Value, given: Mapping[str, Value], *others: str) -> Pose:
    """The pose that stands among other keys."""
    return read_pose(Value(value.file, value.key, {k: v.raw for k, v in given.items() if k not in others}))


def read_box(value: Value) -> Box:
    """A box of full size, metres, with the pose beside it. :raises ConfigError: naming file and key."""
    given = value.fields(required=("size",), optional=("xyz", "rpy", "x_axis", "y_axis"))
    size = np.array([v.number(high=MOST_M, above=0) for v in given["size"].items()])
    if len(size) != 3:
        raise given["size"].error(f"needs 3 numbers, has {len(size)}")
    return Box(_pose_among(value, given, "size"), size)


def _read_solid_box(value: Value) -> Solid:
    return box_solid(read_box(value))


def _read_solid_cylinder(value: Value) -> Solid:
    given = value.fields(required=("radius", "length"), optional=("xyz", "rpy", "x_axis", "y_axis"))
    radius, length = (given[key].number(high=MOST_M, above=0) for key in ("radius", "length"))
    return cylinder_solid(radius, length, _pose_among(value, given, "radius", "length"))


def _read_solid_ball(value: Value) -> Solid:
    given = value.fields(required=("radius",), optional=("xyz",))
    radius = given["radius"].number(high=MOST_M, above=0)
    return ball_solid(radius, _pose_among(value, given, "radius"))


# what a component of one colour may be
SOLIDS = {"box": _read_solid_box, "cylinder": _read_solid_cylinder, "ball": _read_solid_ball}
