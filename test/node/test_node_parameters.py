from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

from rclpy.parameter import Parameter

from artrec_ros.io.parameters.specs import Spec, all_specs
from artrec_ros.node.parameters import base_directory, beside_files, coerce, describe, parameter_files

SPECS = all_specs(["red"], ["pale"])
TIME = SPECS["recognizer.time_budget_ms"]


@pytest.mark.parametrize("spec", SPECS.values(), ids=list(SPECS))
def test_every_parameter_is_described(spec: Spec) -> None:
    descriptor = describe(spec)
    assert descriptor.description
    ranges = [*descriptor.integer_range, *descriptor.floating_point_range]
    bounded = spec.low is not None or spec.high is not None
    assert bool(ranges or "within" in descriptor.additional_constraints) == bounded
    assert all(c in descriptor.additional_constraints for c in spec.choices)
    if ranges and spec.default:
        assert ranges[0].from_value <= spec.default <= ranges[0].to_value


def test_what_works_while_it_runs_may_be_changed() -> None:
    live = {name for name, spec in SPECS.items() if not describe(spec).read_only}
    assert {"recognizer.min_match", "image.pale.hue", "tracking.enabled"} <= live
    assert not live & {"objects", "image.classes", "red.object_file", "red.label", "image_transport"}


def test_ints_become_doubles_and_empty_lists_get_their_type() -> None:
    budget = coerce(TIME, Parameter(TIME.name, value=15))
    assert budget.type_ == Parameter.Type.DOUBLE and budget.value == 15.0
    hue = SPECS["image.pale.hue"]
    assert list(coerce(hue, Parameter(hue.name, value=[10, 20])).value) == [10.0, 20.0]
    for empty in (Parameter(hue.name, value=[]), Parameter(hue.name, Parameter.Type.BOOL_ARRAY, [])):
        assert coerce(hue, empty).type_ == Parameter.Type.DOUBLE_ARRAY


@pytest.mark.parametrize("value", ["15", True, [1, 2], None])
def test_other_types_are_left_to_be_refused(value: object) -> None:
    parameter = Parameter(TIME.name, value=value)
    assert coerce(TIME, parameter) is parameter


def test_relative_files_start_at_the_parameter_file_that_names_them(tmp_path: Path) -> None:
    ours, other = tmp_path / "ours", tmp_path / "launch"
    for folder in (ours, other):
        folder.mkdir()
    (ours / "toy.yaml").touch()
    argv = ["--ros-args", "--params-file", str(other / "a.yaml"), "--params-file", str(ours / "b.yaml")]
    files = parameter_files(argv)
    assert files == [other / "a.yaml", ours / "b.yaml"]
    named = {"red.object_file": "toy.yaml"}
    assert base_directory(named, files) == ours
    assert base_directory({"red.object_file": "package://artrec_ros/x.yaml"}, files) == other
    assert base_directory({**named, "config_dir": str(tmp_path)}, files) == tmp_path
    assert base_directory(named, []) == Path.cwd()


def test_each_of_several_files_names_what_lies_beside_it(tmp_path: Path) -> None:
    one, two = tmp_path / "one", tmp_path / "two"
    for folder, names in ((one, ("red.yaml", "both.yaml")), (two, ("blue.yaml", "both.yaml"))):
        folder.mkdir()
        for name in names:
            (folder / name).touch()
    files = [one / "a.yaml", two / "b.yaml"]
    given = {"red.object_file": "red.yaml", "blue.object_file": "blue.yaml", "red.constraint_file": "both.yaml"}
    given |= {"blue.constraint_file": "neither.yaml", "green.object_file": "package://artrec_ros/red.yaml"}
    found = {"red.object_file": one / "red.yaml", "blue.object_file": two / "blue.yaml"}
    found["red.constraint_file"] = two / "both.yaml"
    assert beside_files(given, files) == {**given, **{key: str(path) for key, path in found.items()}}
    assert beside_files({**given, "config_dir": "."}, files) == {**given, "config_dir": "."}
