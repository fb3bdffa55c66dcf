"""`artrec inspect` as users call it: what it tells of files alone and together."""

import json
import math

import cv2
import numpy as np
import pytest
import yaml
from inspections import CONFIG, STAMP, inspect, write_bag, write_truth

from artrec_ros.core.geometry.projection import project
from artrec_ros.io.images.cameras import camera_yaml
from artrec_ros.io.inventory import inventory
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.simulation.simulator import pinhole_camera
from artrec_ros.tools import getting_ready
from artrec_ros.tools.inspecting.oddities import oddities
from artrec_ros.tools.main import main


def test_markers_that_have_their_bodys_class_are_told(tmp_path, config, capsys):
    path = config / "excavator.yaml"
    assert inspect(capsys, path)[2] == []
    path.write_text(path.read_text().replace("label: 2", "label: 6", 1))
    problems = inspect(capsys, path)[2]
    assert any("have the class of its body (6) and cannot be seen on it" in p for p in problems)


def test_markers_that_are_specks_at_the_least_scale_are_told(config, capsys):
    path = config / "excavator.yaml"
    text = path.read_text()

    def warned(least_scale):
        path.write_text(text.replace("recognizer:\n", f"recognizer:\n      min_scale: {least_scale}\n", 1))
        return [line for line in inspect(capsys, path)[1].splitlines() if "min_blob_px" in line]

    stick = load_object(config / "objects/excavator.yaml").component("stick")
    least = math.sqrt(8 / stick.marker("stick_left").area)
    assert warned(0.0) == warned(1.01 * least) == []
    (line,) = warned(0.99 * least)
    assert line.startswith(f"warning: {path}: excavator: stick/stick_right, stick/stick_left: 7.84 px at recognizer.")
    assert f"they are not seen there, but from {least:.4g} px/m on; make them larger or lower min_blob_px" in line
    (line,) = warned(1.0)
    assert "the object is not found there" in line


@pytest.mark.parametrize(("limits", "said"), [((73, 136), 1), ((73, 0), 1), ((95, 136), 0), ((0, 105), 0), ((0, 0), 0)])
def test_limits_of_the_scale_that_say_nothing_beside_a_plane_are_told(config, capsys, limits, said):
    """By the plane objects have 91 to 110 px/m."""
    plane = {"image_points": [0.0, 0, 1280, 0, 1280, 720, 0, 720], "field_points": [0.0, 7.2, 12.8, 7.2, 12.8, 0, 0, 0]}
    path, said_of = config / "excavator.yaml", dict(zip(("min_scale", "max_scale"), map(float, limits), strict=True))
    parameters = yaml.safe_load(path.read_text())
    (node,) = parameters.values()
    plane = {name: [float(n) for n in numbers] for name, numbers in plane.items()} | {"scale_tolerance": 0.1}
    node["ros__parameters"].setdefault("recognizer", {}).update(said_of)
    node["ros__parameters"]["scene"] = {"plane": plane}
    path.write_text(yaml.safe_dump(parameters))
    lines = [line for line in inspect(capsys, path)[1].splitlines() if "say nothing beside scene.plane" in line]
    assert len(lines) == said and all("90.9 to 110 px/m" in line for line in lines)


def test_what_fits_gives_no_problem(tmp_path, config, capsys):
    bag = write_bag(tmp_path / "bag")
    truth = write_truth(tmp_path / "truth.jsonl")
    files = [config / p for p in ("excavator.yaml", "objects/excavator.yaml", "constraints/excavator.yaml")]
    code, printed, problems = inspect(capsys, *files, bag, truth)
    assert (code, problems) == (0, [])
    assert "all 5 fit together" in printed
    for expected in (
        "3 joints",
        "40x30, 1 channel, labels 0 2 6",
        "focal lengths 34.6, 34.6 px",
        "in space, 24 learned",
        "2: 1",
    ):
        assert expected in printed


def test_constraints_of_another_object_are_told(config, capsys):
    code, _, problems = inspect(capsys, config / "objects/excavator.yaml", config / "constraints/quadruped.yaml")
    assert code == 1 and len(problems) == 1
    assert "are of object 'quadruped', but the objects here are 'excavator'" in problems[0]
    changed = config / "objects/excavator.yaml"
    changed.write_text(changed.read_text().replace("bucket_left", "bucket_port"))
    code, _, problems = inspect(capsys, changed, config / "constraints/excavator.yaml")
    assert code == 1 and "'bucket/bucket_left' is no component/marker" in problems[0]


def test_what_takes_long_is_shown(tmp_path, config, capsys, monkeypatch):
    looked = []
    monkeypatch.setattr(inventory, "bar", lambda work, desc, **_: looked.append(desc) or work)
    monkeypatch.setattr(getting_ready, "share_compiled", lambda some: 0.5)
    truth = write_truth(tmp_path / "truth.jsonl")
    main(["inspect", str(config / "excavator.yaml"), str(write_bag(tmp_path / "bag")), str(truth)])
    assert looked == ["looking into", "reading", "reading stamps"]
    assert "compiling, once on a machine" in capsys.readouterr().err


def test_a_calibration_may_be_named_as_replay_wants_it(tmp_path, config, capsys):
    camera = tmp_path / "camera.yaml"
    camera.write_text(camera_yaml(pinhole_camera((64, 48), 60)))
    named, placed = (
        inspect(capsys, config / "excavator.yaml", *words) for words in (["--camera-info", camera], [camera])
    )
    assert named == placed and "calibration, 64x48" in named[1]


def test_that_a_file_is_not_there_is_said_once(tmp_path, capsys):
    code, printed, _ = inspect(capsys, tmp_path / "colours.yaml")
    assert code == 1
    assert printed == f"problem: {tmp_path / 'colours.yaml'}: there is no such file or folder\n"


def test_truth_and_results_must_share_labels_names_and_stamps(tmp_path, config, capsys):
    bag = write_bag(tmp_path / "bag")
    far = write_truth(tmp_path / "truth.jsonl", label=7, first=STAMP + 5 * 10**9)
    _, _, problems = inspect(capsys, config / "excavator.yaml", bag, far)
    assert len(problems) == 2
    assert "its objects have labels 7" in problems[0]
    assert "the nearest two are 4.8 s apart" in problems[1]
    detection = {"object": "red", "id": 0, "score": 1, "image": {"x": 0, "y": 0, "theta": 0, "scale": 1}, "pose": None}
    line = {
        "stamp_ns": STAMP,
        "frame": "f",
        "size": [40, 30],
        "objects": [detection | {"joints": {}, "components": []}],
    }
    (tmp_path / "detections.jsonl").write_text(json.dumps(line) + "\n")
    _, printed, problems = inspect(capsys, config / "excavator.yaml", tmp_path / "detections.jsonl")
    assert "objects found: red: 1" in printed
    assert len(problems) == 1 and "'red' is no object of" in problems[0]


def test_an_object_that_the_parameters_do_not_use_is_told(config, capsys):
    code, _, problems = inspect(capsys, config / "excavator.yaml", config / "objects/vss.yaml")
    assert code == 1 and "object 'vss' is none of" in problems[0]


def test_components_that_nothing_puts_together_are_told(config, capsys):
    text = (config / "vss.yaml").read_text()
    lines = [line for line in text.splitlines() if "constraint_file" not in line]
    (config / "vss.yaml").write_text("\n".join(lines))
    code, _, problems = inspect(capsys, config / "vss.yaml")
    assert code == 1 and "has no constraint_file" in problems[0]


def test_folders_are_looked_into(tmp_path, capsys):
    assert main(["simulate", str(CONFIG / "objects/excavator.yaml"), "-o", str(tmp_path / "s"), "--frames", "2"]) == 0
    code, printed, problems = inspect(capsys, tmp_path / "s")
    assert (code, problems) == (0, [])
    for kind in ("bag, ", "annotations, ", "truth, "):
        assert kind in printed
    code, printed, _ = inspect(capsys, tmp_path / "s/images")
    assert code == 0 and "images, 2 files, 320x240, 1 channel" in printed and "passed over" not in printed
    (tmp_path / "s/images/0002.TIF").touch()
    code, printed, _ = inspect(capsys, tmp_path / "s/images")
    assert code == 0 and "passed over: 1 .tif" in printed


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("none.yaml", None, "there is no such file"),
        ("a.txt", "x", "'.txt' is no kind of file"),
        ("a.yaml", "x: 1", "neither an object, constraints"),
        ("a.yaml", "format: artrec_object/9", "this release reads version 1"),
        ("a.yaml", "x: [", "expected"),
        ("a.yaml", "name: x\nmarkers: {}\ncomponents: {}", "must begin with 'format: artrec_object/1'"),
        ("a.yaml", "object: x\ncoverage: 1\npairs: []", "must begin with 'format: artrec_constraints/1'"),
        ("a.yaml", "objects: [red]", "no parameters found; they stand under '/**:' and 'ros__parameters:'"),
        ("a.json", "{", "no valid JSON"),
        ("a.jsonl", "{}", "line 1: stamp_ns: this key is missing"),
        ("a.mcap", "no bag", "nothing could be read"),
        ("a.png", "no picture", "neither PNG, JPEG, WebP, BMP nor GIF"),
    ],
)
def test_what_cannot_be_read_is_one_line(tmp_path, capsys, name, text, message):
    if text is not None:
        (tmp_path / name).write_text(text)
    code, _, problems = inspect(capsys, tmp_path / name)
    assert code == 1 and len(problems) == 1
    assert str(tmp_path / name) in problems[0] and message in problems[0]


def test_of_a_folder_of_bags_each_is_looked_at(tmp_path, capsys):
    for name in ("a.bag", "b.bag"):
        (tmp_path / name).write_text("no bag")
    code, _, problems = inspect(capsys, tmp_path)
    assert code == 1 and [p.partition(": ")[2].partition(":")[0] for p in problems] == [
        str(tmp_path / "a.bag"),
        str(tmp_path / "b.bag"),
    ]


def test_what_model_warns_of_is_a_warning_here_too(tmp_path, capsys):
    """It works, and may be meant: scripts that ask for the exit code go on."""
    text = (CONFIG / "objects/mirosot.yaml").read_text()
    (tmp_path / "robot.yaml").write_text(text[: text.index("  gv: {left: g")] + "unique: true\n")  # gr alone
    named = "{classes: [green, red, violet], green: {label: 2}, red: {label: 3}, violet: {label: 4}, kind: labels}"
    (tmp_path / "params.yaml").write_text(
        "/**:\n  ros__parameters:\n    objects: [robot, rival]\n    robot: {object_file: robot.yaml, label: 1}\n"
        f"    rival: {{object_file: robot.yaml, label: 5}}\n    image: {named}\n"
    )
    code, printed, problems = inspect(capsys, tmp_path / "params.yaml")
    assert code == 0 and not problems
    (line,) = [line for line in printed.splitlines() if "no identity has" in line]  # of both, by one file
    assert line.startswith("warning: ") and ": robot, rival: no identity has the class 'r', 'v' for 'left'" in line
    targets = load_parameters(tmp_path / "params.yaml").targets
    assert [line for t in targets for line in oddities(t)] == []  # other commands take it as meant


def test_an_empty_folder_is_told(tmp_path, capsys):
    code, _, problems = inspect(capsys, tmp_path)
    assert code == 1 and "neither a bag, nor images" in problems[0]


def test_parameters_without_objects_go_with_those_that_have_some(tmp_path, config, capsys):
    (tmp_path / "more.yaml").write_text(
        "/**: {ros__parameters: {image: {kind: colour, classes: [red], red: {label: 2, hue: [345, 15]}}}}"
    )
    code, printed, problems = inspect(capsys, config / "excavator.yaml", tmp_path / "more.yaml")
    assert (code, problems) == (0, []), printed
    assert "image.kind 'colour'" in printed and "without objects, to be read after others: image.kind" in printed
    assert inspect(capsys, tmp_path / "more.yaml")[0] == 0


def test_parameter_files_are_taken_as_other_commands_take_them(tmp_path, config, capsys):
    """Named as in `artrec replay`, and the same as by their paths."""
    (more := tmp_path / "more.yaml").write_text("/**: {ros__parameters: {recognizer: {min_blob_px: 5}}}")
    files, bag = (config / "excavator.yaml", more), write_bag(tmp_path / "bag")
    named = inspect(capsys, bag, "--params-file", files[0], "--params-file", files[1])
    assert named == inspect(capsys, *files, bag)
    twice = inspect(capsys, files[0], bag, *("--params-file", files[1]) * 2)
    assert sorted(twice[1].splitlines()) == sorted(named[1].splitlines())
    assert inspect(capsys, "--params-file", files[0]) == inspect(capsys, files[0])
    assert "recognizer.min_blob_px 5" in named[1]
    assert main(["inspect"]) == 1 and "PATH, or --params-file" in capsys.readouterr().err


def test_reports_of_artrec_are_told(tmp_path, config, capsys):
    bag = write_bag(tmp_path / "bag")
    truth = write_truth(tmp_path / "truth.jsonl")
    for name in ("a", "b"):
        command = ["replay", bag, "--params-file", config / "excavator.yaml", "-o", tmp_path / name, "--no-video"]
        assert main([*map(str, command), "--images", "none"]) == 0
    evaluate = ["evaluate", tmp_path / "a", tmp_path / "b", "--truth", truth, "--no-page"]
    assert main(list(map(str, evaluate))) == 0
    capsys.readouterr()
    told = {
        "summary.json": ("the summary of a replay", "3 frames, 0 of them unusable; objects found: none"),
        "replay.json": ("the plan of a replay", "objects: excavator", str(bag)),
        "metrics.json": ("the metrics of an evaluation", "1 frames, 0 objects, 0 found"),
        "comparison.json": ("the comparison of an evaluation", f"run: {tmp_path / 'b'}; truth: {truth}"),
    }
    for name, expected in told.items():
        code, printed, problems = inspect(capsys, tmp_path / "a" / name)
        assert (code, problems) == (0, [])
        for part in expected:
            assert part in printed
    (tmp_path / "summary.json").write_text('{"looked_for": {}, "frames_with_error": 1}')
    assert (
        "is the summary of a replay, but damaged: sources: this key is missing"
        in inspect(capsys, tmp_path / "summary.json")[2][0]
    )
    code, printed, _ = inspect(capsys, tmp_path / "a")  # the folder, with all that lies in it
    assert all(what in printed for what, *_ in told.values())


def test_drawings_and_urdfs_are_told(tmp_path, capsys):
    (tmp_path / "a.svg").write_text(
        '<svg xmlns="http://www.w3.org/2000/svg" width="100mm" height="100mm" viewBox="0 0 100 100">'
        '<g id="base"><rect id="plate" x="10" y="10" width="40" height="20"/></g></svg>'
    )
    (tmp_path / "a.urdf").write_text(
        '<robot name="arm"><link name="base"/><link name="boom"/><joint name="lift" type="revolute">'
        '<parent link="base"/><child link="boom"/></joint></robot>'
    )
    code, printed, _ = inspect(capsys, tmp_path / "a.svg")
    assert code == 0 and "base: plate (40.0 x 20.0 mm)" in printed
    code, printed, _ = inspect(capsys, tmp_path / "a.urdf")
    assert code == 0 and "the URDF of 'arm'" in printed and "2 links: base, boom" in printed
    assert "1 joints, 1 of them moving: lift revolute" in printed


def test_objects_that_cannot_be_found_are_told(tmp_path, config, capsys):
    params = yaml.safe_load((config / "excavator.yaml").read_text())
    del params["/**"]["ros__parameters"]["excavator"]["constraint_file"]
    (config / "excavator.yaml").write_text(yaml.safe_dump(params))
    assert inspect(capsys, config / "excavator.yaml")[0] == 0  # in space
    code, _, problems = inspect(capsys, config / "excavator.yaml", write_bag(tmp_path / "bag", camera=None))
    assert code == 1 and any("excavator: will not be found: it has no constraint_file" in p for p in problems)


def test_components_that_stand_in_no_pair_are_told(tmp_path, config, capsys):
    file, bag = config / "constraints" / "excavator.yaml", write_bag(tmp_path / "bag", camera=None)
    learned = yaml.safe_load(file.read_text())

    def told(pairs):
        file.write_text(yaml.safe_dump({**learned, "pairs": pairs}))
        assert inspect(capsys, config / "excavator.yaml")[0] == 0, "in space"
        return [p for p in inspect(capsys, config / "excavator.yaml", bag)[2] if "constraint_file" in p]

    assert not told(learned["pairs"])
    (line,) = told([p for p in learned["pairs"] if "stick/" not in p["first"] + p["second"]])
    assert "excavator: stick stands in no pair of its constraint_file" in line and "artrec train" in line
    (line,) = told([])
    assert "excavator: will not be found: its constraint_file has no pairs" in line


SCENE = {
    "region": [0.0, 0.0, 20.0, 0.0, 20.0, 30.0, 0.0, 30.0],
    "plane": {
        "image_points": [5.0, 25.0, 35.0, 25.0, 35.0, 5.0, 5.0, 5.0, 20.0, 15.0],
        "field_points": [0.0, 0.0, 0.3, 0.0, 0.3, 0.2, 0.0, 0.2, 0.15, 0.1],
    },
    "floor": {"camera_height_m": 0.5, "object_height_m": 0.2},
}


def test_the_scene_is_told_and_drawn(tmp_path, config, capsys):
    bag, picture = write_bag(tmp_path / "bag"), tmp_path / "scene.png"
    scene = config / "scene.yaml"
    scene.write_text(yaml.safe_dump({"/**": {"ros__parameters": {"scene": SCENE}}}))
    code, printed, _ = inspect(capsys, config / "excavator.yaml", scene, bag, "--scene", picture)
    assert "scene: region of 4 corners, 50% of the image" in printed
    assert "plane by 5 points, frame 'field', 100 to 100 px/m, a pixel is 10 mm" in printed
    assert "the points lie" in printed and "blobs of the objects' classes lie in the region" in printed
    assert "floor 0.5 m below the camera" in printed and "frames 0.1 to 0.3 m above it" in printed
    drawn = cv2.imread(str(picture))
    assert drawn.shape[1] >= 600
    halves = drawn[:, : drawn.shape[1] // 2].mean(), drawn[:, drawn.shape[1] // 2 :].mean()
    assert halves[0] > 1.5 * halves[1]  # what lies outside is dark


def test_no_scene_is_drawn_where_there_is_none(tmp_path, config, capsys):
    code, printed, _ = inspect(
        capsys, config / "excavator.yaml", write_bag(tmp_path / "bag"), "--scene", tmp_path / "s.png"
    )
    assert "not drawn: it takes a parameter file with scene.region or scene.plane, and images" in printed
    assert not (tmp_path / "s.png").exists()


LAID = """
format: artrec_object/1
name: toy
markers: {plate: {rectangle: {width: 0.04, height: 0.08}}}
components:
  base: {required: true, markers: {plate: {marker: plate, pose: {xyz: [0, 0, 0]}}}}
  top: {markers: {plate: {marker: plate, pose: {xyz: [ALONG, 0, HEIGHT]}}}}
"""


@pytest.mark.parametrize(
    ("along", "height", "calibrated", "told"),
    [
        ("0.2", "0.03", False, "12%"),
        ("0.2", "0.03", True, ""),
        ("0.2", "0", False, ""),
        ("0", "0.03", False, "32%"),
        ("0", "0.001", False, ""),
    ],
)
def test_markers_of_unlike_heights_are_told_where_images_have_no_calibration(
    tmp_path, capsys, along: str, height: str, calibrated: bool, told: str
) -> None:
    """They are taken for a figure in one plane. What lies on another in its middle is as high as a sticker."""
    (tmp_path / "toy.yaml").write_text(LAID.replace("HEIGHT", height).replace("ALONG", along))
    params = tmp_path / "params.yaml"
    params.write_text("/**: {ros__parameters: {objects: [toy], toy: {object_file: toy.yaml, label: 1}}}")
    bag = write_bag(tmp_path / "bag", **({} if calibrated else {"camera": None}))
    problems = inspect(capsys, params, bag)[2]
    said = [p for p in problems if "toy: its markers stand one above the other" in p]
    assert len(said) == bool(told) and all(f"by {told} of their extent" in p for p in said)


@pytest.mark.parametrize(
    ("moved_px", "unit", "told"),
    [(0.0, 1.0, ""), (0.4, 1.0, ""), (9.0, 1.0, "x and y meet at"), (0.0, 1000.0, "are field_points metres?")],
)
def test_a_plane_that_the_calibration_contradicts_is_told(
    tmp_path, config, capsys, moved_px: float, unit: float, told: str
) -> None:
    """Four points make a plane whatever they are; a calibrated camera knows what a right angle looks like."""
    camera = pinhole_camera((64, 48), 60)
    field = np.array([[0, 0], [0.3, 0], [0.3, 0.2], [0, 0.2]])
    lean = np.array([[1, 0, 0], [0, -0.8, -0.6], [0, 0.6, -0.8]])  # a camera that looks down at a slant
    image = project(camera, np.column_stack([field, np.zeros(4)]) @ lean.T + [-0.15, 0.05, 0.4])
    image[1, 1] += moved_px
    plane = {"image_points": image.ravel().tolist(), "field_points": (unit * field).ravel().tolist()}
    scene = config / "scene.yaml"
    scene.write_text(yaml.safe_dump({"/**": {"ros__parameters": {"scene": {"plane": plane}}}}))
    (tmp_path / "camera.yaml").write_text(camera_yaml(camera))
    problems = inspect(capsys, config / "excavator.yaml", scene, tmp_path / "camera.yaml")[2]
    said = [p for p in problems if "scene.plane" in p]
    assert len(said) == bool(told) and all(told in p for p in said), problems
