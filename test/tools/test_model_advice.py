"""What `artrec model` says of markers: from where they are told, what is ambiguous, and what is hardly meant."""

import math

import pytest
from model_runs import OBJECTS, QUADRUPED, TOY, advice_on, run

from artrec_ros.core.design.ambiguity import find_ambiguities
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.simulation.simulator import pinhole_camera
from artrec_ros.tools import main as command_line
from artrec_ros.tools.inspecting.model_report import advice, shape_rows


def test_distances_follow_from_the_cameras_focal_length():
    found = find_ambiguities(load_object(QUADRUPED, {}))
    near, far = (shape_rows(found, pinhole_camera((640, 480), angle)) for angle in (90, 53.130102))
    assert [r.names for r in near][-1] == "front_left/leg and 5 more"
    for a, b in zip(near, far, strict=True):
        assert b.found_m == pytest.approx(2 * a.found_m, rel=1e-6)  # tan 45 = 2 tan 26.57
        assert b.told_m == pytest.approx(2 * a.told_m, rel=1e-6) and a.told_m <= a.found_m
    lateral = near[0]
    assert math.sqrt(150 / 0.00803) == pytest.approx(320 / lateral.found_m, rel=0.1)  # some 80 cm2, 150 px


def test_what_will_be_ambiguous_is_told(tmp_path):
    lines = advice_on(tmp_path, TOY, pinhole_camera((640, 480), 60), 4.0)
    text = "\n".join(lines)
    for expected in (
        "warning: base/bar looks the same after a turn of 180 degrees, and all starts there",
        "warning: base/bar lies within its component's body",
        "warning: base/bar, lid/bar are alike in shape: 'base', from which all starts",
        "warning: the markers of 'arm' have the class of its body (5)",
        "for 4 m make it",
        "note: without joint, and so taken to be fixed to the object's frame: arm, lid",
    ):
        assert expected in text, expected
    assert [line.split(":")[0] for line in lines] == sorted((line.split(":")[0] for line in lines), reverse=True)


@pytest.mark.parametrize(("base", "lid", "said"), [("", "red", False), ("blue", "blue", True), ("", "", True)])
def test_markers_of_classes_with_other_names_are_not_taken_for_each_other(base, lid, said, tmp_path, capsys):
    """Though nothing says yet which numbers these have. Without a label a component has the object's."""
    text = TOY
    for name, label in (("base", base), ("lid", lid)):
        text = text.replace(f"  {name}: {{", f"  {name}: {{label: {label}, " if label else f"  {name}: {{")
    (path := tmp_path / "toy.yaml").write_text(text)
    assert run(path, "-o", tmp_path / "again.yaml") == 0
    assert ("base/bar, lid/bar are alike in shape" in capsys.readouterr().out) == said
    assert f"label: {lid}" in (tmp_path / "again.yaml").read_text()  # as it stood there


def test_classes_that_no_identity_shows_are_named(tmp_path):
    text = (OBJECTS / "mirosot.yaml").read_text()
    first = text[: text.index("  gv: {left: g")] + "unique: true\n"  # gr alone
    labels = dict(green=2, red=3, violet=4)
    said = "warning: no identity has the class 'r', 'v' for 'left', nor 'g', 'v' for 'right': what shows it"
    (line,) = [line for line in advice_on(tmp_path, first, labels=labels) if "no identity has" in line]
    assert line.startswith(said)
    assert not [line for line in advice_on(tmp_path, text, labels=labels) if "no identity has" in line]


@pytest.mark.parametrize(
    ("required", "other", "said"),
    [
        ("label: 4", "classes: {g: 2, r: 3}", None),
        ("label: 2", "classes: {g: 2, r: 3}", "lid may be of the class of the required component 'base'"),
        ("classes: {g: 2, r: 3}", "label: 4", "the required component 'base' may be of 2 classes"),
    ],
)
def test_a_required_component_that_much_else_may_be_taken_for_is_named(required, other, said, tmp_path):
    text = TOY.replace("  base: {", f"  base: {{{required}, ").replace("  lid: {", f"  lid: {{{other}, ")
    lines = [line for line in advice_on(tmp_path, text) if "a class of its own that no other component has" in line]
    assert [line.startswith(f"warning: {said}") for line in lines] == [True] * (said is not None)


def test_long_lists_of_markers_are_shortened():
    lines = advice(find_ambiguities(load_object(QUADRUPED, {})), pinhole_camera((640, 480), 60), None)
    assert not [line for line in lines if line.count("/") > 8]
    assert [line for line in lines if "like it) look" in line or "more are alike in shape" in line], lines


def test_a_good_object_gives_no_warning_near_by_and_some_far_off():
    found = find_ambiguities(load_object(OBJECTS / "excavator.yaml", {}))
    camera = pinhole_camera((640, 480), 60)
    assert not [line for line in advice(found, camera, 1.0) if line.startswith("warning")]
    assert [line for line in advice(found, camera, 10.0) if line.startswith("warning")]


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("limits: [-1.2, 1.2]", "limits: [-70, 70]", "joint arm: a limit of 70 rad is more than a turn"),
        ("limits: [-1.2, 1.2]", "limits: [-2, 5]", "joint arm: from limit to limit 7 rad is more than a turn"),
        (
            "axis: [[-0.04, 0.0], [0.05, 0.0]]",
            "axis: [[-0.04, 0.0], [5, 0.0]]",
            "base/plate: its axis ends 4.99",
        ),
        ("width: 0.02, height: 0.10", "width: 20, height: 100", "arm/near is 102 m across, base/plate 0.1"),
        ("width: 0.02, height: 0.10", "width: 2, height: 15", "arm/near is 15.13 m across, base/plate 0.1"),
        ("xyz: [0, -0.01, 0.06]", "xyz: [0, -10, 60]", "arm/near is off its component's frame by 60.83 m"),
        (
            "origin: {xyz: [0.05, 0, 0.04]}",
            "origin: {xyz: [50, 0, 40]}",
            "the joint of arm is off its parent's frame by 64",
        ),
    ],
)
def test_wrong_units_are_told(old, new, said, tmp_path, capsys):
    path = tmp_path / "crane.yaml"
    path.write_text(CRANE)
    assert run(path) == 0 and "warning" not in capsys.readouterr().out
    path.write_text(CRANE.replace(old, new))
    assert run(path) == 0 and capsys.readouterr().out.count(f"warning: {said}") == 1
    assert command_line.main(["inspect", str(path)]) == 1 and f"problem: {path}: {said}" in capsys.readouterr().out


CRANE = """\
format: artrec_object/1
name: crane
markers:
  plate:
    outline: [[-0.04, -0.03], [0.04, -0.03], [0.05, 0.0], [0.04, 0.03], [-0.04, 0.03]]
    axis: [[-0.04, 0.0], [0.05, 0.0]]
  stripe: {rectangle: {width: 0.02, height: 0.10}}
components:
  base:
    required: true
    markers:
      plate: {pose: {xyz: [0, -0.05, 0], x_axis: [1, 0, 0], y_axis: [0, 0, 1]}}
  arm:
    label: 4
    markers:
      near: {marker: stripe, pose: {xyz: [0, -0.01, 0.06], x_axis: [1, 0, 0], y_axis: [0, 0, 1]}}
    joint: {parent: base, origin: {xyz: [0.05, 0, 0.04]}, axis: [0, 1, 0], limits: [-1.2, 1.2]}
"""

FINGERS = """\
format: artrec_object/1
name: fingers
markers:
  palm: {outline: [[-0.05, -0.04], [0.05, -0.04], [0.06, 0.05], [-0.04, 0.05]], axis: [[0, -0.04], [0, 0.05]]}
  near: {outline: [[-0.014, 0.008], [0.014, 0.008], [0.011, 0.05], [-0.011, 0.05]], axis: [[0, 0.008], [0, 0.05]]}
  far: {outline: [[-0.012, 0.014], [0.012, 0.014], [0.007, 0.049], [-0.007, 0.049]], axis: [[0, 0.014], [0, 0.049]]}
components:
  palm: {required: true, markers: {palm: {pose: {xyz: [0, 0, 0]}}}}
  one: {markers: {near: {pose: {xyz: [-0.03, 0.07, 0]}}}}
  two: {markers: {near: {pose: {xyz: [0.03, 0.07, 0]}}}}
  three: {markers: {far: {pose: {xyz: [-0.03, 0.13, 0]}}}}
  four: {markers: {far: {pose: {xyz: [0.03, 0.13, 0]}}}}
"""


def test_of_several_markers_of_one_shape_one_speaks_for_all(tmp_path):
    lines = advice_on(tmp_path, FINGERS, pinhole_camera((640, 480), 60))
    (told,) = [line for line in lines if "told apart" in line]
    assert "one/near (and 1 like it) and three/far (and 1 like it)" in told
    assert "without body" not in "".join(lines)  # flat: there is no far side
