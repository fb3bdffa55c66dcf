"""What `artrec inspect` tells of images and calibrations, beside parameters."""

import cv2
import numpy as np
import pytest
import yaml
from inspections import PATCH_ON_BODY, STAMP, inspect, write_bag

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.simulation.simulator import pinhole_camera


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


def test_labels_that_are_not_in_the_images_are_told(tmp_path, config, capsys):
    bag = write_bag(tmp_path / "bag", labels=(0, 5, 6))
    code, _, problems = inspect(capsys, config / "excavator.yaml", bag)
    assert code == 1 and len(problems) == 1
    assert "no pixel has label 2, that of 'excavator'" in problems[0] and "labels there: 0, 5, 6" in problems[0]


@pytest.mark.parametrize(("bgr", "hinted"), [((200, 40, 40), True), ((40, 200, 40), False)])
def test_a_class_that_red_and_blue_hide_from_each_other_is_told_with_the_way_out(tmp_path, config, capsys, bgr, hinted):
    image = np.full((60, 80, 3), 90, np.uint8)
    image[20:40, 20:60] = bgr
    cv2.imwrite(str(tmp_path / "0.png"), image)
    more = tmp_path / "red.yaml"
    red = "{label: 2, rgb: [200, 40, 40]}"
    more.write_text(f"/**: {{ros__parameters: {{image: {{kind: colour, classes: [red], red: {red}}}}}}}")
    _, _, problems = inspect(capsys, config / "excavator.yaml", more, tmp_path / "0.png")
    (told,) = [p for p in problems if "no pixel has label 2" in p]
    assert ("red and blue are exchanged" in told) == hinted


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


def test_the_wrong_kind_of_images_is_told(tmp_path, config, capsys):
    code, _, problems = inspect(capsys, config / "pendulum.yaml", write_bag(tmp_path / "bag"))
    assert code == 1 and "no images of 3 channel(s), which image.kind 'colour'" in problems[0]
    with BagWriter(tmp_path / "two") as bag:
        for topic in ("/a/image", "/b/image"):
            bag.write_camera(f"{topic[:2]}/camera_info", STAMP, pinhole_camera((40, 30), 60))
            bag.write_image(topic, STAMP, "cam", PATCH_ON_BODY)
    _, _, problems = inspect(capsys, config / "excavator.yaml", tmp_path / "two")
    assert len(problems) == 1 and "choose one with --topic" in problems[0]


def test_colours_that_a_later_step_learns_are_the_next_step_and_no_problem(tmp_path, config, capsys):
    parameters, more = config / "excavator.yaml", tmp_path / "colours to learn.yaml"
    more.write_text(
        "/**: {ros__parameters: {image: {kind: colour, classes: [red, blue], red: {label: 2}, blue: {label: 6}}}}"
    )
    code, printed, problems = inspect(capsys, parameters, more)
    assert (code, problems) == (0, []), printed
    command = f"artrec learn-colours --annotations COCO.json --params-file {parameters} --params-file '{more}' -o"
    assert f"next: {parameters} has no colours yet for red, blue: {command} colours.yaml" in printed
    _, printed, _ = inspect(capsys, parameters, more, "--images", tmp_path)
    assert f"'{more}' --images {tmp_path} -o colours.yaml learns them" in printed
    more.write_text(more.read_text().replace("label: 2", "label: 2, hue: [345, 15]"))  # some are told: one is forgotten
    code, printed, problems = inspect(capsys, parameters, more)
    assert code == 1 and any("no colour is given for blue" in line for line in problems) and "next: " not in printed


def test_a_bag_that_lost_messages_is_told(tmp_path, capsys):
    bag = write_bag(tmp_path / "bag")
    text = (bag / "metadata.yaml").read_text()
    (bag / "metadata.yaml").write_text(text.replace("message_count: 3", "message_count: 5"))
    code, _, problems = inspect(capsys, bag)
    assert code == 1
    told = f"{bag}: '/camera/segmentation': 3 messages were read, but metadata.yaml tells of 5: 2 are lost"
    assert any(told in problem for problem in problems)


def test_parameters_that_leave_nothing_of_the_images_are_told(tmp_path, config, capsys):
    bag, params = write_bag(tmp_path / "bag"), config / "excavator.yaml"
    content = yaml.safe_load(params.read_text())
    content["/**"]["ros__parameters"]["recognizer"]["min_blob_px"] = 5000
    params.write_text(yaml.safe_dump(content))
    code, _, problems = inspect(capsys, params, bag)
    assert code == 1 and len(problems) == 1
    assert "'excavator' has nothing to be found in: 1 blobs of its classes, the largest of" in problems[0]


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
