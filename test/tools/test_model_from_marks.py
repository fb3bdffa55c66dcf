"""`artrec model --marks`: an object file measured in marked pictures."""

import json
import math

import numpy as np
import pytest
from model_runs import OBJECTS, ONE_MARKER, QUADRUPED, run

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.tools.main import main

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


def test_a_distance_that_no_joint_changes_and_marks_do_is_told(tmp_path, capsys):
    """Of a plate beside the base that slides by a tenth of their distance either way."""
    source, marks = marked(tmp_path)
    plate = "  plate: {markers: {bar: {pose: {xyz: [0, 0.1, 0]}}}}\n"
    source.write_text(JOINTED.replace("ROD", "0.08").replace("  arm:\n", plate + "  arm:\n"))
    coco = json.loads(marks.read_text())
    coco["categories"][0]["keypoints"] += ["plate/bar.tail", "plate/bar.head"]
    for row in coco["annotations"]:
        tail, head = np.reshape(row["keypoints"], (-1, 3))[:2, :2]
        aside = np.array([head[1] - tail[1], tail[0] - head[0]]) * (0.89 + 0.02 * row["image_id"])
        row["keypoints"] += [float(v) for end in (tail + aside, head + aside) for v in (*end, 2)]
    marks.write_text(json.dumps(coco))
    assert run(source, "--marks", marks) == 0
    told = [line for line in capsys.readouterr().out.splitlines() if "no joint changes" in line]
    assert len(told) == 1 and told[0].startswith("warning: base/bar and plate/bar: no joint changes their distance")
    assert "0.89 to 1.11 times what it mostly is" in told[0] and "of 12 images" in told[0]
    assert told[0].endswith("or a joint that slides and is not declared")


def test_a_limb_that_leaves_the_plane_is_not_told_to_have_a_second_joint(tmp_path, capsys):
    """A disc on a joint about another one's middle: its distance changes, and no joint can be declared for that."""
    source, marks = marked(tmp_path)
    joint = "{parent: base, axis: [0, 0, 1], limits: [-1, 1]}"
    disc = f"  wheel: {{markers: {{hub: {{pose: {{xyz: [0.3, 0, 0]}}}}}}, joint: {joint}}}\n"
    text = JOINTED.replace("ROD", "0.08").replace(
        "markers:\n  bar", "markers:\n  hub: {disc: {radius: 0.01}}\n  bar", 1
    )
    text = text.replace("bar: {pose: {}}", "bar: {pose: {xyz: [-0.05, 0, 0]}}").replace(
        "origin: {xyz: [0.1", "origin: {xyz: [0.05"
    )
    source.write_text(text.replace("  arm:\n", disc + "  arm:\n"))
    coco = json.loads(marks.read_text())
    coco["categories"][0]["keypoints"] += ["wheel/hub.tail", "wheel/hub.head"]
    for row in coco["annotations"]:
        tail, head = np.reshape(row["keypoints"], (-1, 3))[:2, :2]
        middle = (tail + head) / 2 + (head - tail) * 3 * (0.89 + 0.02 * row["image_id"])
        row["keypoints"] += [float(v) for end in (middle - [10, 0], middle + [10, 0]) for v in (*end, 2)]
    marks.write_text(json.dumps(coco))
    assert run(source, "--marks", marks) == 0
    told = [line for line in capsys.readouterr().out.splitlines() if "base/bar and wheel/hub: no joint" in line]
    assert len(told) == 1 and "a limb that leaves the plane of the image, whose one joint is in use" in told[0]


LEG = """
format: artrec_object/1
name: leg
markers:
  large: {disc: {radius: RADIUS}}
  lamp: {disc: {radius: 0.06}}
  bar: {outline: [[0, -0.02], [0.2, -0.02], [0.2, 0.02], [0, 0.02]], axis: [[0, 0], [0.2, 0]]}
components:
  hip: {required: true, markers: {lamp: {marker: large, pose: {xyz: [0, 0, 0]}}}}
  knee: {label: 2, markers: {lamp: {pose: {xyz: [0, -0.6, 0]}}}}
  ankle:
    label: 3
    markers: {lamp: {pose: {xyz: [0, -0.5, 0]}}}
    joint: {parent: knee, origin: {xyz: [0, -0.6, 0]}, axis: [0, 0, 1], limits: [-1.3, 0.5]}
  side: {label: 4, markers: {bar: {pose: {xyz: [0.2, 0, 0]}}}}
"""


@pytest.mark.parametrize("radius", [0.04, 0.06, 0.08])
def test_radii_of_discs_stay_and_tell_no_scale(tmp_path, capsys, radius):
    """They are as large as their colours look, here 6 px and more, and are marked 4 px far; the shank is 0.46 m."""
    keypoints = [f"{c}/{m}.{end}" for c, m in (("hip", "lamp"), ("knee", "lamp"), ("ankle", "lamp"), ("side", "bar"))
                 for end in ("tail", "head")]  # fmt: skip
    rows = []
    for n in range(10):
        bend, (c, s) = -1.2 + 0.15 * n, (math.cos(0.4 * n), math.sin(0.4 * n))
        middles = [(0, 0), (0, 60), (46 * math.sin(bend), 60 + 46 * math.cos(bend))]
        ends = [(x + aside, y) for x, y in middles for aside in (-4, 4)] + [(20, 0), (38, 0)]  # the bar 0.18 m
        turned = [(150 + c * x - s * y, 150 + s * x + c * y) for x, y in ends]
        points = [float(v) for p in turned for v in (*p, 2)]
        rows.append({"image_id": n, "category_id": 1, "keypoints": points})
    images = [{"id": n, "file_name": f"{n}.png"} for n in range(10)]
    coco = {"images": images, "annotations": rows, "categories": [{"id": 1, "name": "leg", "keypoints": keypoints}]}
    (tmp_path / "marks.json").write_text(json.dumps(coco))
    (tmp_path / "leg.yaml").write_text(LEG.replace("RADIUS", str(radius)))
    assert run(tmp_path / "leg.yaml", "--marks", tmp_path / "marks.json", "-o", tmp_path / "made.yaml") == 0
    told = capsys.readouterr().out
    made = load_object(tmp_path / "made.yaml")
    radii = [made.component(name).markers[0].disc_radius for name in ("hip", "knee", "ankle")]
    assert radii == pytest.approx([radius, 0.06, 0.06])
    at = {c.name: c.markers[0].T_component_marker.position for c in made.components}
    shank = at["ankle"] + made.component("ankle").joint.T_parent_joint.position - at["knee"]
    assert np.linalg.norm(shank) / np.linalg.norm(at["knee"]) == pytest.approx(46 / 60, rel=0.01)
    assert np.linalg.norm(at["knee"]) == pytest.approx(0.6, rel=0.03)
    assert "knee/lamp: its radius stays, though marked ends lie 0.67 times as far apart" in told
    assert "side/bar becomes 8% smaller, as it is marked" in told
    assert "at the scale that distances tell" in told


DISCS = """
format: artrec_object/1
name: discs
markers: {large: {disc: {radius: 0.15}}, small: {disc: {radius: 0.1}}}
components:
  base: {required: true, markers: {large: {pose: {}}}}
  nose:
    markers: {small: {pose: {}}}
    joint: {name: slide, type: prismatic, parent: base, origin: {xyz: [1, 0, 0]}, axis: [1, 0, 0], limits: [-0.4, 0.4]}
"""


def two_discs(folder, times):
    """Marks of that object at 200 pixels a metre, the small disc so many times as large in each picture."""
    rows = []
    for n, larger in enumerate(times):
        along = np.array([math.cos(0.5 * n), math.sin(0.5 * n)])
        base = np.array([300.0, 300.0])
        nose = base + 200 * (1 + 0.3 * math.sin(n)) * along
        points = [base - 30 * along, base + 30 * along, nose - 20 * larger * along, nose + 20 * larger * along]
        rows.append({"image_id": n, "category_id": 1, "keypoints": [float(v) for p in points for v in (*p, 2)]})
    keypoints = ["base/large.tail", "base/large.head", "nose/small.tail", "nose/small.head"]
    coco = {
        "images": [{"id": n, "file_name": f"{n}.png"} for n in range(len(rows))],
        "annotations": rows,
        "categories": [{"id": 1, "name": "discs", "keypoints": keypoints}],
    }
    (folder / "marks.json").write_text(json.dumps(coco))
    (folder / "discs.yaml").write_text(DISCS)
    return folder / "discs.yaml", folder / "marks.json"


@pytest.mark.parametrize("command", ["model", "train"])
def test_sizes_that_differ_from_picture_to_picture_are_told_by_all_that_read_marks(command, tmp_path, capsys):
    """Positions fit whatever the object's lengths are: that was told as an object file that holds."""
    for times, told in ([1.0] * 6, False), ([0.6, 1.0, 1.0, 1.0, 1.0, 1.6], True):
        source, marks = two_discs(tmp_path, times)
        files = ["--object", source, "--annotations", marks, "-o", tmp_path / "constraints.yaml"]
        arguments = [source, "--marks", marks] if command == "model" else files
        assert main([command, *map(str, arguments)]) == 0
        out = capsys.readouterr().out
        assert ("nose/small is marked 0.60 to 1.60 times as large beside base/large" in out) == told
        assert ("in 2 of 6 pictures" in out and "radius 0.13 nine in ten" in out) == told
        assert "holds as it is" not in out and ("Pose and joints take up" in out) == (command == "model")
