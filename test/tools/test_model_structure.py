"""What `artrec model` says of how components lie to each other."""

import pytest
from model_runs import advice_on

from artrec_ros.core.design.ambiguity import find_ambiguities
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.tools.inspecting.model_report import advice

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


LEGS = """
format: artrec_object/1
name: toy
markers: {trunk: {rectangle: {width: 0.12, height: 0.1}}, foot: {rectangle: {width: 0.06, height: 0.04}}}
components:
  trunk: {required: true, label: 1, markers: {trunk: {pose: {xyz: [0, 0.2, 0]}}}}
  left:
    label: 2
    markers: {front: {marker: foot, pose: {xyz: [-0.1, 0, 0]}}, aside: {marker: foot, pose: {xyz: [-0.12, 0.002, 0]}}}
  right:
    label: 2
    markers: {front: {marker: foot, pose: {xyz: [0.1, 0, 0]}}, aside: {marker: foot, pose: {xyz: [0.11, 0.02, 0]}}}
"""


def test_markers_of_one_component_that_lie_on_each_other_are_alternatives(tmp_path):
    """Views of one foot: no neighbours of which both are there, wherever their edges come to lie."""
    assert not [n for n in advice_on(tmp_path, LEGS) if "adjoin" in n or "seen at once" in n]
    apart = LEGS.replace("[-0.12, 0.002, 0]", "[-0.2, 0, 0]").replace("[0.11, 0.02, 0]", "[0.2, 0, 0]")
    told = [n.partition(" but one")[0] for n in advice_on(tmp_path, apart) if "seen at once" in n]
    assert told == [f"warning: {c}/front, {c}/aside are of one component and seen at once," for c in ("left", "right")]


def test_alternatives_that_lie_on_one_between_them_are_no_neighbours(tmp_path):
    """To the left, to the right and in front."""
    marker = ", back: {marker: foot, pose: {xyz: [-0.08, 0, 0]}}, far: {marker: foot, pose: {xyz: [-0.06, 0, 0]}}}"
    lines = advice_on(tmp_path, LEGS.replace("[-0.12, 0.002, 0]}}}", "[-0.14, 0, 0]}}" + marker))
    assert not [n for n in lines if "adjoin" in n or "seen at once" in n]


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
