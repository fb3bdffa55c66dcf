import json
import shutil
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.io.inventory import inventory
from artrec_ros.simulation.simulator import pinhole_camera
from artrec_ros.tools import getting_ready
from artrec_ros.tools.main import main

CONFIG = Path(__file__).parents[2] / "config"
STAMP = 1_700_000_000_000_000_000
PATCH_ON_BODY = np.repeat(np.array([[2] * 20 + [6] * 20], np.uint8), 30, axis=0)  # (30, 40) the excavator's labels


def inspect(capsys, *paths):
    """(exit code, all that is printed, the problems)."""
    code = main(["inspect", *map(str, paths)])
    printed = capsys.readouterr().out
    return code, printed, [line for line in printed.splitlines() if line.startswith("problem: ")]


def write_bag(path, labels=(0, 2, 6), size=(40, 30), camera=(40, 30), topic="/camera/segmentation", frames=3):
    image = np.zeros((size[1], size[0]), np.uint8)
    for n, label in enumerate(labels):
        image[:, 4 * n : 4 * n + 4] = label
    with BagWriter(path) as bag:
        for n in range(frames):
            stamp = STAMP + n * 10**8
            if camera is not None:
                bag.write_camera("/camera/camera_info", stamp, pinhole_camera(camera, 60))
            bag.write_image(topic, stamp, "cam", image)
    return path


@pytest.fixture
def config(tmp_path):
    """The shipped excavator, where it can be changed."""
    shutil.copytree(CONFIG, tmp_path / "config")
    return tmp_path / "config"


def write_truth(path, label=2, first=STAMP):
    record = {"team": label, "position": [0, 0, 1], "rotation": np.eye(3).tolist(), "joints": {}, "components": {}}
    path.write_text(json.dumps({"stamp_ns": first, "objects": [record | {"centre_px": [1, 1]}]}) + "\n")
    return path


def test_of_a_folder_each_image_that_is_odd_is_named(tmp_path, capsys):
    """Though only a few are looked at."""
    folder = tmp_path / "images"
    folder.mkdir()
    for n in range(20):
        cv2.imwrite(str(folder / f"{n:02}.png"), np.zeros((30 if n != 7 else 20, 40), np.uint8))
    (folder / "08.png").write_bytes(b"")
    (folder / "00.png").write_bytes(b"none")
    _, printed, problems = inspect(capsys, folder)
    assert "images, 20 files, 40x30, 1 channel, labels 0, in 4 images looked at" in printed
    assert [p.partition(f"{folder}: ")[2] for p in problems] == [
        "00.png: 4 bytes that are neither PNG, JPEG, WebP, BMP nor GIF (they start with '6e 6f 6e 65')",
        "08.png: it is empty",
        "1 of 20 images have 40x20 pixels, not 40x30: 07.png",
    ]


def test_markers_that_have_their_bodys_class_are_told(tmp_path, config, capsys):
    path = config / "excavator.yaml"
    assert inspect(capsys, path)[2] == []
    path.write_text(path.read_text().replace("label: 2", "label: 6", 1))
    problems = inspect(capsys, path)[2]
    assert any("have the class of its body (6) and cannot be seen on it" in p for p in problems)


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


def test_labels_that_are_not_in_the_images_are_told(tmp_path, config, capsys):
    bag = write_bag(tmp_path / "bag", labels=(0, 5, 6))
    code, _, problems = inspect(capsys, config / "excavator.yaml", bag)
    assert code == 1 and len(problems) == 1
    assert "no pixel has label 2, that of 'excavator'" in problems[0] and "labels there: 0, 5, 6" in problems[0]


@pytest.mark.parametrize(
    ("camera", "expected"),
    [
        (None, "no topic '/camera/camera_info': no poses in space of excavator"),
        ((80, 60), "calibration beside them is for 80x60"),
    ],
)
def test_calibration_that_is_missing_or_of_another_size_is_told(tmp_path, config, capsys, camera, expected):
    bag = write_bag(tmp_path / "bag", camera=camera)
    code, _, problems = inspect(capsys, config / "excavator.yaml", bag)
    assert code == 1 and len(problems) == 1 and expected in problems[0]


def test_an_uncalibrated_camera_is_told_where_poses_are_wanted(tmp_path, config, capsys):
    with BagWriter(tmp_path / "bag") as bag:
        bag.write_camera("/camera/camera_info", STAMP, Camera(np.zeros((3, 3)), np.zeros(0), (40, 30)))
        bag.write_image("/camera/image", STAMP, "cam", PATCH_ON_BODY)
    code, _, problems = inspect(capsys, config / "excavator.yaml", tmp_path / "bag")
    assert code == 1 and "not calibrated" in problems[0]
    cv2.imwrite(str(tmp_path / "0.png"), PATCH_ON_BODY)
    problems = inspect(capsys, config / "excavator.yaml", tmp_path / "0.png")[2]
    assert any("no calibration: name a calibration file beside it: no poses" in p for p in problems)
    assert inspect(capsys, tmp_path / "bag")[0] == 0  # nobody wants poses


def test_a_calibration_file_stands_in_and_must_fit(tmp_path, config, capsys):
    bag = write_bag(tmp_path / "bag", camera=None)
    content = {"image_width": 40, "image_height": 30, "camera_matrix": {"data": [35, 0, 20, 0, 35, 15, 0, 0, 1]}}
    (tmp_path / "camera.yaml").write_text(yaml.safe_dump(content))
    assert inspect(capsys, config / "excavator.yaml", bag, tmp_path / "camera.yaml")[0] == 0
    (tmp_path / "camera.yaml").write_text(yaml.safe_dump(content | {"image_width": 50}))
    code, _, problems = inspect(capsys, config / "excavator.yaml", bag, tmp_path / "camera.yaml")
    assert code == 1 and "is for 50x30 pixels" in problems[0]


def test_constraints_of_another_object_are_told(config, capsys):
    code, _, problems = inspect(capsys, config / "objects/excavator.yaml", config / "constraints/quadruped.yaml")
    assert code == 1 and len(problems) == 1
    assert "are of object 'quadruped', but the objects here are 'excavator'" in problems[0]
    changed = config / "objects/excavator.yaml"
    changed.write_text(changed.read_text().replace("bucket_left", "bucket_port"))
    code, _, problems = inspect(capsys, changed, config / "constraints/excavator.yaml")
    assert code == 1 and "'bucket/bucket_left' is no component/marker" in problems[0]


def test_the_wrong_kind_of_images_is_told(tmp_path, config, capsys):
    code, _, problems = inspect(capsys, config / "pendulum.yaml", write_bag(tmp_path / "bag"))
    assert code == 1 and "no images of 3 channel(s), which image.kind 'colour'" in problems[0]
    with BagWriter(tmp_path / "two") as bag:
        for topic in ("/a/image", "/b/image"):
            bag.write_camera(f"{topic[:2]}/camera_info", STAMP, pinhole_camera((40, 30), 60))
            bag.write_image(topic, STAMP, "cam", PATCH_ON_BODY)
    _, _, problems = inspect(capsys, config / "excavator.yaml", tmp_path / "two")
    assert len(problems) == 1 and "choose one with --topic" in problems[0]


def test_annotations_must_be_of_the_object_and_their_images_there(tmp_path, config, capsys):
    names = ["base/side_right.tail", "base/side_right.head"]
    content = {
        "images": [{"id": 1, "file_name": "a.png"}],
        "annotations": [{"image_id": 1, "category_id": 1, "keypoints": [1, 1, 2, 9, 9, 2]}],
        "categories": [{"id": 1, "name": "digger", "keypoints": names}],
    }
    (tmp_path / "coco.json").write_text(json.dumps(content))
    code, _, problems = inspect(capsys, tmp_path / "coco.json", config / "objects/excavator.yaml")
    assert code == 1 and len(problems) == 1 and "a.png" in problems[0]
    (tmp_path / "elsewhere").mkdir()
    cv2.imwrite(str(tmp_path / "elsewhere/a.png"), np.zeros((30, 40), np.uint8))
    assert inspect(capsys, tmp_path / "coco.json", "--images", tmp_path / "elsewhere")[0] == 0
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((30, 40), np.uint8))
    assert inspect(capsys, tmp_path / "coco.json", config / "objects/excavator.yaml")[0] == 0
    code, _, problems = inspect(capsys, tmp_path / "coco.json", config / "objects/vss.yaml")
    assert code == 1 and "category 'digger' is of none of the objects: keypoint 'base/side_right.tail'" in problems[0]


@pytest.mark.parametrize(
    ("category", "attributes", "said"),
    [
        ("yellow", {"identity": "gr"}, ()),
        ("yellow_gr", {}, ()),
        ("yellow", {"left": "g", "right": "r"}, ()),
        ("yellow", {"identity": "gg"}, ("object 'mirosot' has no identity 'gg'",)),
        ("yellow", {}, ("is not told which one it is, of 1 of 1", "gr, gv, rg, vg, vr")),
    ],
)
def test_annotations_tell_which_one_of_several_like_objects_it_is(tmp_path, config, capsys, category, attributes, said):
    names = [f"{part}/{part}.{end}" for part in ("team", "left", "right") for end in ("tail", "head")]
    points = [v for n in range(6) for v in (10.0 + 7 * n, 12.0 + n * n, 2)]
    one = {"image_id": 1, "id": 1, "category_id": 1, "keypoints": points, "attributes": attributes}
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((60, 80), np.uint8))
    content = {
        "images": [{"id": 1, "file_name": "a.png", "width": 80, "height": 60}],
        "categories": [{"id": 1, "name": category, "keypoints": names}],
        "annotations": [one],
    }
    (tmp_path / "coco.json").write_text(json.dumps(content))
    code, _, problems = inspect(capsys, tmp_path / "coco.json", config / "objects/mirosot.yaml")
    assert (code != 0) == bool(said) == bool(problems), problems
    assert all(any(words in line for line in problems) for words in said)


def test_a_category_is_of_the_object_that_it_names_though_others_have_its_keypoints(tmp_path, config, capsys):
    text = (config / "objects/mirosot.yaml").read_text()
    (tmp_path / "one.yaml").write_text(text)
    (tmp_path / "two.yaml").write_text(text.replace("  gr: {", "  first: {"))
    objects = {"objects": ["blue", "pink"], "blue": {"object_file": "one.yaml", "label": 1}}
    objects |= {"pink": {"object_file": "two.yaml", "label": 2}}
    colours = {name: {"label": label} for label, name in enumerate(("green", "red", "violet"), 3)}
    objects["image"] = {"kind": "labels", "classes": list(colours), **colours}
    for team in ("blue", "pink"):
        names = [f"{part}/{part}.{end}" for part in ("team", "left", "right") for end in ("tail", "head")]
        points = [v for n in range(6) for v in (10.0 + 7 * n, 12.0 + n * n, 2)]
        one = {"image_id": 1, "id": 1, "category_id": 1, "keypoints": points}
        one["attributes"] = {"identity": "gr" if team == "blue" else "first"}
        cv2.imwrite(str(tmp_path / "a.png"), np.zeros((60, 80), np.uint8))
        content = {
            "images": [{"id": 1, "file_name": "a.png"}],
            "categories": [{"id": 1, "name": team, "keypoints": names}],
            "annotations": [one],
        }
        (tmp_path / "coco.json").write_text(json.dumps(content))
        (tmp_path / "robots.yaml").write_text(yaml.safe_dump({"/**": {"ros__parameters": objects}}))
        _, printed, problems = inspect(capsys, tmp_path / "robots.yaml", tmp_path / "coco.json")
        assert "told below" not in printed
        assert not [line for line in problems if "identity" in line or "none of the objects" in line], problems


def test_other_objects_in_the_same_file_are_no_problem(tmp_path, config, capsys):
    """Of two teams' robots, and a ball, in one file of annotations the file of one team knows its own."""
    names = [f"{part}/{part}.{end}" for part in ("team", "left", "right") for end in ("tail", "head")]
    categories = [("blue_gr", names), ("yellow_first", names), ("ball", ["ball/ball.centre", "ball/ball.edge"])]
    points = [[v for n in range(len(keys)) for v in (10.0 + 7 * n, 12.0 + n * n, 2)] for _, keys in categories]
    content = {
        "images": [{"id": 1, "file_name": "a.png"}],
        "categories": [{"id": n, "name": name, "keypoints": keys} for n, (name, keys) in enumerate(categories)],
        "annotations": [{"image_id": 1, "id": n, "category_id": n, "keypoints": own} for n, own in enumerate(points)],
    }
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((60, 80), np.uint8))
    (tmp_path / "coco.json").write_text(json.dumps(content))
    assert inspect(capsys, config / "objects/mirosot.yaml", tmp_path / "coco.json")[2] == []
    content["categories"] = content["categories"][2:]
    content["annotations"] = content["annotations"][2:]
    (tmp_path / "coco.json").write_text(json.dumps(content))
    (problem,) = inspect(capsys, config / "objects/mirosot.yaml", tmp_path / "coco.json")[2]
    assert "category 'ball' is of none of the objects" in problem


def test_regions_are_told_beside_objects_and_are_no_problem_alone(tmp_path, capsys):
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((60, 80, 3), np.uint8))
    content = {
        "images": [{"id": 1, "file_name": "a.png"}],
        "categories": [{"id": n, "name": name} for n, name in enumerate(("wheel", "shadow", "cable"))],
        "annotations": [{"image_id": 1, "category_id": c, "bbox": [1, 2, 8, 8]} for c in (0, 1, 0)],
    }
    (tmp_path / "regions.json").write_text(json.dumps(content))
    code, printed, problems = inspect(capsys, tmp_path / "regions.json")
    assert (code, problems) == (0, [])
    assert "  regions, of categories without keypoints: wheel: 2, shadow: 1, cable: 0\n" in printed


def test_what_takes_long_is_shown(tmp_path, config, capsys, monkeypatch):
    looked = []
    monkeypatch.setattr(inventory, "bar", lambda work, desc, **_: looked.append(desc) or work)
    monkeypatch.setattr(getting_ready, "share_compiled", lambda some: 0.5)
    truth = write_truth(tmp_path / "truth.jsonl")
    main(["inspect", str(config / "excavator.yaml"), str(write_bag(tmp_path / "bag")), str(truth)])
    assert looked == ["looking into", "reading", "reading stamps"]
    assert "compiling, once on a machine" in capsys.readouterr().err


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
        "/**:\n  ros__parameters:\n    objects: [robot]\n    robot: {object_file: robot.yaml, label: 1}\n"
        f"    image: {named}\n"
    )
    code, printed, problems = inspect(capsys, tmp_path / "params.yaml")
    assert code == 0 and not problems
    assert "robot: no identity has the class 'r', 'v' for 'left'" in printed and "\nwarning: " in printed


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


def test_colours_that_a_later_step_learns_are_the_next_step_and_no_problem(tmp_path, config, capsys):
    parameters, more = config / "excavator.yaml", tmp_path / "colours to learn.yaml"
    more.write_text(
        "/**: {ros__parameters: {image: {kind: colour, classes: [red, blue], red: {label: 2}, blue: {label: 6}}}}"
    )
    code, printed, problems = inspect(capsys, parameters, more)
    assert (code, problems) == (0, []), printed
    command = f"artrec learn-colours --annotations COCO.json --params-file {parameters} --params-file '{more}' -o"
    assert f"next: {parameters} has no colours yet for red, blue: {command} colours.yaml" in printed
    more.write_text(more.read_text().replace("label: 2", "label: 2, hue: [345, 15]"))  # some are told: one is forgotten
    code, printed, problems = inspect(capsys, parameters, more)
    assert code == 1 and any("no colour is given for blue" in line for line in problems) and "next: " not in printed


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


def test_a_bag_that_lost_messages_is_told(tmp_path, capsys):
    bag = write_bag(tmp_path / "bag")
    text = (bag / "metadata.yaml").read_text()
    (bag / "metadata.yaml").write_text(text.replace("message_count: 3", "message_count: 5"))
    code, _, problems = inspect(capsys, bag)
    assert code == 1
    told = f"{bag}: '/camera/segmentation': 3 messages were read, but metadata.yaml tells of 5: 2 are lost"
    assert any(told in problem for problem in problems)


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


def test_parameters_that_leave_nothing_of_the_images_are_told(tmp_path, config, capsys):
    bag, params = write_bag(tmp_path / "bag"), config / "excavator.yaml"
    content = yaml.safe_load(params.read_text())
    content["/**"]["ros__parameters"]["recognizer"]["min_blob_px"] = 5000
    params.write_text(yaml.safe_dump(content))
    code, _, problems = inspect(capsys, params, bag)
    assert code == 1 and len(problems) == 1
    assert "'excavator' has nothing to be found in: 1 blobs of its classes, the largest of" in problems[0]


def test_no_scene_is_drawn_where_there_is_none(tmp_path, config, capsys):
    code, printed, _ = inspect(
        capsys, config / "excavator.yaml", write_bag(tmp_path / "bag"), "--scene", tmp_path / "s.png"
    )
    assert "not drawn: it takes a parameter file with scene.region or scene.plane, and images" in printed
    assert not (tmp_path / "s.png").exists()


def test_flat_objects_want_no_calibration(tmp_path, capsys):
    object_file = "format: artrec_object/1\nname: robot\nmarkers: {patch: {rectangle: {width: 0.04, height: 0.02}}}\n"
    object_file += "components: {team: {required: true, markers: {patch: {pose: {xyz: [0, 0, 0]}}}}}\n"
    (tmp_path / "robot.yaml").write_text(object_file)
    node = {"objects": ["robot"], "robot": {"object_file": "robot.yaml", "label": 2}, "image": {"kind": "labels"}}
    (tmp_path / "robots.yaml").write_text(yaml.safe_dump({"/**": {"ros__parameters": node}}))
    (tmp_path / "images").mkdir()
    image = np.zeros((30, 40), np.uint8)
    image[10:20, 10:30] = 2
    cv2.imwrite(str(tmp_path / "images/0.png"), image)
    code, printed, problems = inspect(capsys, tmp_path / "robots.yaml", tmp_path / "images")
    assert (code, problems) == (0, []) and "image_poses" in printed
