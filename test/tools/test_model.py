import argparse
import json
import math
from pathlib import Path

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.design.ambiguity import find_ambiguities
from artrec_ros.core.model.target import Target
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.simulation import sheet
from artrec_ros.simulation.sheet import MarkerCell, model_sheet
from artrec_ros.simulation.simulator import pinhole_camera
from artrec_ros.tools import main as command_line
from artrec_ros.tools import model
from artrec_ros.tools.inspecting.model_report import advice, shape_rows

OBJECTS = Path(__file__).parents[2] / "config" / "objects"
QUADRUPED = OBJECTS / "quadruped.yaml"

TOY = """
format: artrec_object/1
name: toy
markers:
  bar: {rectangle: {width: 0.1, height: 0.02}}
  flag:
    outline: [[-0.05, -0.02], [0.05, -0.02], [0.05, 0.0], [-0.01, 0.0], [-0.01, 0.03], [-0.05, 0.03]]
    axis: [[0, 0], [1, 0]]
components:
  base: {required: true, markers: {bar: {pose: {xyz: [0, 0, 0]}}}, body: {boxes: [{size: [0.2, 0.2, 0.1]}]}}
  arm: {label: 5, markers: {flag: {pose: {}}}, body: {label: 5, boxes: [{xyz: [0, 0, -1], size: [1, 1, 1]}]}}
  lid: {markers: {bar: {pose: {xyz: [1, 0, 0]}}}}
"""


def run(*arguments):
    parser = argparse.ArgumentParser()
    model.add_parser(parser.add_subparsers())
    args = parser.parse_args(["model", *map(str, arguments)])
    return args.run(args)


def advice_on(folder, text, camera=None, distance_m=None, labels=None):
    """What is said of an object file of this text."""
    (path := folder / "object.yaml").write_text(text)
    return advice(find_ambiguities(load_object(path, labels or {})), camera, distance_m)


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


SIDES = """
format: artrec_object/1
name: box
markers: {side: {rectangle: {width: 0.06, height: 0.06}}}
components:
  front:
    required: true
    markers: {side: {pose: {xyz: [0.03, 0, 0], x_axis: [0, 1, 0], y_axis: [0, 0, 1]}}}
    body: {boxes: [{size: [0.06, 0.06, 0.06]}]}
  back: {label: 2, markers: {back: {marker: side, pose: {xyz: [-0.03, 0, 0], x_axis: [0, -1, 0], y_axis: [0, 0, 1]}}}}
  sign: {label: 3, markers: {sign: {marker: side, pose: {xyz: [0.03, 0, 0.1], x_axis: [0, 1, 0], y_axis: [0, 0, 1]}}}}
  flap:
    label: 4
    markers: {flap: {marker: side, pose: {xyz: [-0.03, 0.1, 0], x_axis: [0, -1, 0], y_axis: [0, 0, 1]}}}
    joint: {parent: front, axis: [0, 0, 1], limits: [-1, 1]}
"""


def test_sides_from_which_the_required_component_is_out_of_sight_are_named(tmp_path):
    """What a joint moves is no side of it; what a rigid body hides is known of all its sides."""
    lines = advice_on(tmp_path, SIDES)
    (said,) = [line for line in lines if "recognizer.required: visible" in line]
    assert "where back face the camera, 'front' may be out of sight" in said
    (bare,) = [line for line in lines if "without body" in line]
    assert bare.endswith("is not known: flap")


@pytest.mark.parametrize(("side", "label", "said"), [(0.06, 1, True), (0.054, 1, False), (0.06, 2, False)])
def test_sides_of_one_class_that_meet_are_to_be_one_components(tmp_path, side, label, said):
    """Around a corner they are one blob, in which each of them seems to bear out the others."""
    text = f"""
format: artrec_object/1
name: box
markers: {{side: {{rectangle: {{width: {side}, height: {side}}}}}}}
components:
  front:
    required: true
    label: 1
    markers: {{side: {{pose: {{xyz: [0.03, 0, 0], x_axis: [0, 1, 0], y_axis: [0, 0, 1]}}}}}}
  left:
    label: {label}
    markers: {{left: {{marker: side, pose: {{xyz: [0, 0.03, 0], x_axis: [-1, 0, 0], y_axis: [0, 0, 1]}}}}}}
"""
    told = [n for n in advice_on(tmp_path, text) if "one component" in n]
    assert len(told) == said
    assert all(n.startswith("warning: front/side, left/left are sides of one class that meet") for n in told)
    one = text.replace(f"  left:\n    label: {label}\n    markers: {{left", "      left").replace(
        ": {side: {pose", ":\n      side: {pose", 1
    )
    one = one.replace("[0, 0, 1]}}}\n", "[0, 0, 1]}}\n")
    assert not [n for n in advice_on(tmp_path, one) if "meet" in n or "adjoin" in n]
    assert len(load_object(tmp_path / "object.yaml", {}).components) == 1


@pytest.mark.parametrize(("size", "said"), [(0.06, False), (0.05, True)])
def test_markers_that_cover_a_body_of_their_own_class_can_be_seen(tmp_path, size, said):
    """A box of one colour; on more of their colour they cannot."""
    text = f"""
format: artrec_object/1
name: box
markers: {{side: {{rectangle: {{width: {size}, height: {size}}}}}}}
components:
  box:
    required: true
    label: 1
    markers: {{side: {{pose: {{xyz: [0.0301, 0, 0], x_axis: [0, 1, 0], y_axis: [0, 0, 1]}}}}}}
    body: {{label: 1, boxes: [{{size: [0.06, 0.06, 0.06]}}]}}
"""
    assert any("cannot be seen on it" in line for line in advice_on(tmp_path, text)) == said


def test_markers_of_one_component_that_are_seen_at_once_are_named(tmp_path):
    """A board of squares is found by all of them where each is a component."""
    text = """
format: artrec_object/1
name: board
markers: {square: {rectangle: {width: 0.05, height: 0.05}}}
components:
  board:
    required: true
    markers:
      a: {marker: square, pose: {xyz: [0, 0, 0]}}
      b: {marker: square, pose: {xyz: [0.1, 0, 0]}}
      back: {marker: square, pose: {xyz: [0.1, 0, -0.01], x_axis: [-1, 0, 0], y_axis: [0, 1, 0]}}
"""
    (told,) = [n for n in advice_on(tmp_path, text) if "seen at once" in n]
    assert told.startswith("warning: board/a, board/b are of one component")
    apart = text.replace("      b: {", "  other:\n    markers:\n      b: {")
    assert not [n for n in advice_on(tmp_path, apart) if "seen at once" in n]


def test_what_looks_the_same_throughout_is_told_once(tmp_path):
    """Not of each of a box's sides: they are seen together."""
    frame = "  frame: {required: true, label: 2, box: {size: [0.3, 0.25, 0.36]}}\n"
    drawer = (
        "  drawer_{}: {{label: {}, box: {{size: [0.26, 0.2, 0.09], xyz: [0.035, 0, 0]}}, joint: {{parent: frame, "
        "type: prismatic, origin: {{xyz: [0, 0, {}]}}, axis: [1, 0, 0], limits: [0, 0.2]}}}}\n"
    )
    parts = frame + drawer.format(0, 3, -0.1) + drawer.format(1, 3, 0.1)
    (path := tmp_path / "cabinet.yaml").write_text(f"format: artrec_object/1\nname: cabinet\ncomponents:\n{parts}")
    (line,) = advice(find_ambiguities(load_object(path, {})), None, None)
    assert line.startswith("warning: all of it looks the same after a turn of 180 degrees about its x axis")
    assert "drawer_0, drawer_1 lie where drawer_1, drawer_0 did" in line
    path.write_text(path.read_text().replace("drawer_1: {label: 3", "drawer_1: {label: 4"))
    assert not advice(find_ambiguities(load_object(path, {})), None, None)


@pytest.mark.parametrize("shape", ["box: {size: [0.1, 0.06, 0.04]}", "cylinder: {radius: 0.03, length: 0.001}"])
def test_solids_are_not_told_to_be_what_they_are(tmp_path, shape):
    """A coin's sides are of one component and many; of two of one class side by side there is but one way out."""
    text = f"""
format: artrec_object/1
name: toy
components:
  one: {{required: true, label: 1, {shape}}}
"""
    assert not [n for n in advice_on(tmp_path, text) if "component" in n]
    if "box" in shape:
        lines = advice_on(tmp_path, text + "  two: {label: 1, box: {size: [0.1, 0.06, 0.04], xyz: [0.1, 0, 0]}}\n")
        assert not [n for n in lines if "one component" in n] and [n for n in lines if "leave a gap" in n]


BOARD = """
format: artrec_object/1
name: board
markers:
  large: {rectangle: {width: 0.1, height: 0.1}}
  small: {rectangle: {width: 0.02, height: 0.02}}
components:
  front: {required: true, label: 1, markers: {large: {pose: {xyz: [0, 0, 0]}}}}
  other: {label: 1, markers: {SHAPE: {pose: POSE}}}
"""


@pytest.mark.parametrize(
    ("shape", "pose", "said"),
    [
        ("small", "{xyz: [0.06, 0, 0]}", True),
        ("large", "{xyz: [0, 0, -0.004], x_axis: [-1, 0, 0], y_axis: [0, 1, 0]}", False),
    ],
    ids=["a small one at a large one's edge", "back to back"],
)
@pytest.mark.parametrize("turned", [False, True])
def test_markers_adjoin_that_may_be_seen_together(tmp_path, shape, pose, said, turned):
    """Whichever of them comes first."""
    text = BOARD.replace("SHAPE", "back: {marker: large, pose: POSE}" if shape == "large" else "small: {pose: POSE}")
    text = text.replace(": {pose: POSE}}}", "}}").replace("POSE", pose)
    if turned:
        lines = text.splitlines()
        text = "\n".join([*lines[:-2], lines[-1], lines[-2]]) + "\n"
    assert len([n for n in advice_on(tmp_path, text) if "adjoin" in n]) == said


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
    said = "warning: no identity has the class 'r', 'v' for 'left': what shows it is no left"
    assert said in advice_on(tmp_path, first, labels=labels)
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


def test_a_drawing_becomes_an_object_file(tmp_path, capsys):
    pytest.importorskip("svgelements")
    (tmp_path / "d.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="50mm" viewBox="0 0 100 50">'
        '<g id="base"><path id="side" d="M 10 10 h 60 l 10 20 h -70 z"/></g></svg>'
    )
    assert run(tmp_path / "d.svg", "-o", tmp_path / "my-toy.yaml") == 0
    made = load_object(tmp_path / "my-toy.yaml")
    assert made.name == "my_toy" and made.required.name == "base"
    assert "no pose" in capsys.readouterr().out
    with pytest.raises(ConfigError, match="--overwrite"):
        run(tmp_path / "d.svg", "-o", tmp_path / "my-toy.yaml")
    assert run(tmp_path / "d.svg", "-o", tmp_path / "my-toy.yaml", "--overwrite") == 0


def test_pictures_become_components(tmp_path, capsys):
    for name in ("foot", "arm"):
        image = np.zeros((60, 80), np.uint8)
        cv2.rectangle(image, (20, 20), (50, 35), 2, -1)
        cv2.imwrite(str(tmp_path / f"{name}.png"), image)
    pictures = [tmp_path / "foot.png", tmp_path / "arm.png"]
    assert run(*pictures, "--width", 0.1, 0.2, "--name", "lamp", "-o", tmp_path / "lamp.yaml") == 0
    told = [line for line in capsys.readouterr().out.splitlines() if "A slant does not show in one side" in line]
    assert len(told) == 2 and told[0].startswith("warning: foot.png: with its width of 0.1 m as given it is 0.05")
    assert "--height" in told[0] and "--corners" in told[0]
    assert run(*pictures, "--width", 0.1, 0.2, "--height", 0.0516, 0.1032) == 0
    told = capsys.readouterr().out.splitlines()
    assert sum("as given, and the picture agrees" in line for line in told) == 2
    assert not [line for line in told if line.startswith("warning: foot.png")]
    made = load_object(tmp_path / "lamp.yaml")
    assert (made.name, [c.name for c in made.components]) == ("lamp", ["foot", "arm"])
    assert [np.ptp(c.markers[0].outline[:, 0]) for c in made.components] == pytest.approx([0.1, 0.2], abs=1e-3)


JOINTED = """
format: artrec_object/1
name: jointed
classes: {red: 7}
markers:
  bar: {outline: [[0, -0.01], [0.1, -0.01], [0.1, 0.01], [0, 0.01]], axis: [[0, 0], [0.1, 0]]}
  rod: {outline: [[0, -0.01], [ROD, -0.01], [ROD, 0.01], [0, 0.01]], axis: [[0, 0], [ROD, 0]]}
components:
  base:
    required: true
    markers: {bar: {pose: {}}}
    body: {label: green, boxes: [{xyz: [0, 0, -0.01], size: [0.1, 0.1, 0.01]}]}
  arm:
    label: red
    markers: {rod: {pose: {}}}
    joint: {parent: base, origin: {xyz: [0.1, 0, 0]}, axis: [0, 0, 1], limits: [-2, 2]}
"""


ONE_MARKER = """
format: artrec_object/1
name: sign
markers: {plate: {outline: [[0, 0], [0.1, 0], [0, 0.1]], axis: [[0, 0], [0.1, 0]]}}
components: {plate: {required: true, markers: {plate: {pose: {xyz: [0, 0, 0]}}}}}
"""


def marked(folder, count=12, swapped=()):
    """Marks of that object with a rod of 0.08 m, at 1000 pixels a metre, in `count` pictures."""
    rows = []
    for n in range(count):
        turn, bend = np.array([0.5, 0.3]) * n + 0.1, 1.5 * math.sin(2.0 * n)
        at = np.array([200.0, 150.0])
        along = [np.array([math.cos(a), -math.sin(a)]) for a in (turn[0], turn[0] + bend)]
        end = at + 100 * along[0]
        points = [at, end, end, end + 80 * along[1]]
        if n in swapped:
            points[2:] = points[:1:-1]
        rows.append({"image_id": n, "category_id": 1, "keypoints": [float(v) for p in points for v in (*p, 2)]})
    keypoints = ["base/bar.tail", "base/bar.head", "arm/rod.tail", "arm/rod.head"]
    other = {"id": 2, "name": "other", "keypoints": ["wheel/disc.tail", "wheel/disc.head"]}
    coco = {
        "images": [{"id": n, "file_name": f"{n}.png"} for n in range(count)],
        "annotations": rows,
        "categories": [{"id": 1, "name": "jointed", "keypoints": keypoints}, other],
    }
    (folder / "marks.json").write_text(json.dumps(coco))
    (folder / "jointed.yaml").write_text(JOINTED.replace("ROD", "0.07"))
    return folder / "jointed.yaml", folder / "marks.json"


def test_marked_pictures_measure_an_object_file(tmp_path, capsys):
    source, marks = marked(tmp_path, swapped=[5])
    assert run(source, "--marks", marks, "-o", tmp_path / "measured.yaml") == 0
    told = capsys.readouterr()
    assert "Measuring 'jointed' in 12 marked objects" in told.err
    assert "All sizes are beside base/bar's, which stays." in told.out
    assert "moved, % of object" in told.out and " mm" not in told.out and "With a camera" not in told.out
    assert "Limits of joints stay" in told.out
    row = next(line for line in told.out.splitlines() if line.startswith("  arm/rod"))
    assert float(row.split()[2]) == pytest.approx(8 / 7, abs=0.01)
    assert any("annotations[5]" in line and "tail and head" in line for line in told.out.splitlines())
    made = load_object(tmp_path / "measured.yaml", {"green": 4})
    assert made.component("arm").markers[0].head[0] == pytest.approx(0.08, abs=5e-4)
    assert (made.component("arm").label, made.component("base").body_label) == (7, 4)  # by name, as they were given
    assert "label: green" in (tmp_path / "measured.yaml").read_text()


def test_an_object_file_with_which_marks_agree_stays(tmp_path, capsys):
    source, marks = marked(tmp_path)
    source.write_text(JOINTED.replace("ROD", "0.08"))
    assert run(source, "--marks", marks, "-o", tmp_path / "same.yaml") == 0
    told = capsys.readouterr().out
    assert "holds as it is" in told and "warning: joint" not in told
    assert load_object(tmp_path / "same.yaml").component("arm").markers[0].head[0] == pytest.approx(0.08)


def test_limits_that_hold_less_than_marks_show_are_widened(tmp_path, capsys):
    source, marks = marked(tmp_path)
    source.write_text(JOINTED.replace("ROD", "0.07").replace("[-2, 2]", "[-2, 1.3]"))  # bends go to 1.49
    assert run(source, "--marks", marks, "-o", tmp_path / "wider.yaml") == 0
    (told,) = (line for line in capsys.readouterr().out.splitlines() if line.startswith("  arm: "))
    assert "limits -2.000..1.300 become " in told and "annotations[7] (7.png)" in told
    joint = load_object(tmp_path / "wider.yaml").component("arm").joint
    assert joint.lower == pytest.approx(-2.0, abs=0.02) and joint.upper == pytest.approx(1.49, abs=0.01)


def test_marks_that_measure_nothing_are_refused_with_the_reason(tmp_path):
    source, marks = marked(tmp_path, count=3)
    with pytest.raises(ConfigError, match="3 marked objects, of which 3 show .* of 3 looked at 3 lie .*; 4 such"):
        run(source, "--marks", marks)
    coco = json.loads(marked(tmp_path, count=5)[1].read_text())
    for row in coco["annotations"][1:4]:  # rods far from their joints
        row["keypoints"][6] += 150
        row["keypoints"][9] += 150
    coco["annotations"][0]["keypoints"][6:] = [0] * 6
    marks.write_text(json.dumps(coco))
    said = r"5 marked objects, of which 4 show two .*; of 4 looked at 1 lie about.*; 4 such.* ends lie \d+ px off \("
    with pytest.raises(ConfigError, match=said):
        run(source, "--marks", marks)
    (tmp_path / "one.yaml").write_text(ONE_MARKER)
    with pytest.raises(ConfigError, match="'sign' has one marker"):
        run(tmp_path / "one.yaml", "--marks", marks)
    with pytest.raises(ConfigError, match=r"'quadruped' is not flat.*--camera-info"):
        run(QUADRUPED, "--marks", marks)
    with pytest.raises(ConfigError, match="link of 'pendulum' has no pose"):
        run(OBJECTS / "pendulum.yaml", "--marks", marks)
    with pytest.raises(ConfigError, match="keypoint 'base/bar.tail'"):
        run(OBJECTS / "mirosot.yaml", "--marks", marks)
    with pytest.raises(ConfigError, match="measures what an object file has"):
        run(tmp_path / "drawing.svg", "--marks", marks)


def test_the_sheet_shows_markers_and_the_object(tmp_path):
    assert run(QUADRUPED, "--sheet", tmp_path / "new" / "sheet.png", "--label", 3) == 0
    sheet = cv2.imread(str(tmp_path / "new" / "sheet.png"))
    # four shapes, seven sides, both ends of four joints; four in a row
    assert sheet.shape[1] == 4 * 300 and sheet.shape[0] == 5 * 342
    assert np.all(sheet[42 + 150, 150] == (40, 30, 200)) or np.any(np.all(sheet[42:342, :300] == (40, 30, 200), axis=2))


def test_a_rim_lies_around_letters_whatever_the_font_does_with_thickness():
    plain, rimmed = np.full((2, 40, 120, 3), 90, np.uint8)
    sheet._text(plain, "lateral_right", (10, 25), (255, 255, 255), 0.34)
    sheet._text(rimmed, "lateral_right", (10, 25), (255, 255, 255), 0.34, (0, 0, 0))
    letters, rim = ([np.flatnonzero((p != 90).any(axis=(2, axis))) for axis in (0, 1)] for p in (plain, rimmed))
    for inner, outer in zip(letters, rim, strict=True):
        assert (inner[0] - outer[0], outer[-1] - inner[-1]) == (1, 1)


def test_joints_on_the_sheet_have_units(monkeypatch):
    captions = []
    monkeypatch.setattr(sheet, "_captioned", lambda image, caption, notes: captions.append(caption) or image)
    model_sheet(Target("quadruped", load_object(QUADRUPED, {}), 2), [])
    assert "front_left at -0.7 rad" in captions


def test_a_sheet_of_markers_alone_has_no_object():
    pendulum = load_object(OBJECTS / "pendulum.yaml")
    cells = [MarkerCell(m, 2, m.name, (0.1, 0.05)) for c in pendulum.components for m in c.markers]
    sheet = model_sheet(Target("pendulum", pendulum, 2), cells)
    assert sheet.shape[0] == 342 * math.ceil(len(cells) / 4)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ([QUADRUPED, QUADRUPED], "several pictures, or one"),
        (["a.doc"], "'.doc' is no kind of file"),
        (["a.urdf"], "go together"),
        ([QUADRUPED, "--markers", QUADRUPED], "go together"),
        (["a.png"], "--width: 0 given for 1"),
        (["a.png", "--width", "-1"], "--width"),
        (["a.png", "b.png", "c.png", "--width", "1", "2"], "--width: 2 given for 3"),
        (["a.png", "b.png", "c.png", "--width", "1", "--height", "1", "2"], "--height: 2 given for 3"),
        (["a.png", "--width", "1", "--height", "0"], "--height"),
        (["a.png", "--rectangle", "1", "2"], "--corners and --rectangle go together"),
        (["a.png", "b.png", "--rectangle", "1", "1", "--corners", *"00901099"], "--corners: given 1 times for 2"),
        (["a.png", "--rectangle", "1", "1", "--corners", *"00099990"], "do not go round a rectangle clockwise"),
        (["a.png", "--rectangle", "1", "2", "--corners", *"00909404"], "slant of 77 degrees"),
        ([QUADRUPED, "--height", "1"], "are for pictures"),
        ([QUADRUPED, "--distance", "0"], "--distance"),
        ([QUADRUPED, "--label", "300"], "--label: 300"),
        ([QUADRUPED, "--sheet", "a.tif"], "must end in .png"),
    ],
)
def test_wrong_usage_is_told(arguments, message):
    with pytest.raises(ConfigError, match=message):
        run(*arguments)
