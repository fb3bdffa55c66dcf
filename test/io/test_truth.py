"""Truth from each kind of file: what is told, by what frames go, and what is refused."""

from __future__ import annotations

import json

import numpy as np
import pytest

from artrec_ros.core.base.errors import ArtrecError, SourceError
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.io.inventory.inventory import take_stock
from artrec_ros.io.truth.from_bags import object_name
from artrec_ros.io.truth.reading import read_truth
from artrec_ros.io.truth.records import Told

CAMERA = Camera(np.array([[300.0, 0, 160], [0, 300, 120], [0, 0, 1]]), np.zeros(0), (320, 240), "optical")
POSES = [Pose.from_xyz_rpy([0.1, -0.2, 1.5], [0.3, -1.0, 2.0]), Pose.from_xyz_rpy([0, 0, 2])]


class TestPoses:
    @pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
    def test_they_come_back_as_written(self, tmp_path, storage):
        with BagWriter(tmp_path / "bag", storage) as bag:
            bag.write_camera("/camera_info", 1, CAMERA)
            bag.write_poses("/ground_truth/red/poses", 20, "optical", POSES)
            bag.write_poses("/ground_truth/blue/poses", 20, "optical", POSES[:1])
            bag.write_poses("/ground_truth/red/poses", 30, "optical", [])
        truth = read_truth(tmp_path / "bag")
        assert list(truth.frames) == [20, 30] and not truth.by_name
        assert sorted(o.name for o in truth.frames[20]) == ["blue", "red", "red"] and truth.frames[30] == ()
        first = next(o for o in truth.frames[20] if o.name == "red")
        assert np.allclose(first.pose.rotation, POSES[0].rotation) and np.allclose(
            first.pose.position, POSES[0].position
        )
        assert first.told is Told.REQUIRED and first.label is None
        assert truth.frame_id == "optical" and np.array_equal(truth.camera.matrix, CAMERA.matrix)

    def test_what_a_damaged_bag_lacks_is_told(self, tmp_path):
        with BagWriter(tmp_path / "bag", "mcap") as bag:
            for stamp in range(200):
                bag.write_poses("/ground_truth/red/poses", stamp, "optical", POSES)
        assert read_truth(tmp_path / "bag").problems == ()
        (file,) = (tmp_path / "bag").glob("*.mcap")
        file.write_bytes(file.read_bytes()[: int(0.6 * file.stat().st_size)])
        assert any("truncated" in problem for problem in read_truth(tmp_path / "bag").problems)

    def test_topics_that_are_named_go_before_those_of_ground_truth(self, tmp_path):
        with BagWriter(tmp_path / "bag", "mcap") as bag:
            bag.write_poses("/ground_truth/red/poses", 20, "optical", POSES)
            bag.write_poses("/mocap/red", 20, "optical", POSES[:1])
        assert len(read_truth(tmp_path / "bag").frames[20]) == 2
        assert len(read_truth(tmp_path / "bag", ["/mocap/red"]).frames[20]) == 1
        assert read_truth(tmp_path / "bag").camera is None

    def test_two_topics_of_one_name_must_be_told_apart(self, tmp_path):
        with BagWriter(tmp_path / "bag", "mcap") as bag:
            for space in ("a", "b"):
                bag.write_poses(f"/{space}/red/poses", 20, "optical", POSES)
        with pytest.raises(SourceError, match="/a/red/poses and /b/red/poses.*--truth-topic"):
            read_truth(tmp_path / "bag")
        assert len(read_truth(tmp_path / "bag", ["/b/red/poses"]).frames[20]) == 2

    def test_poses_in_two_frames_are_refused(self, tmp_path):
        with BagWriter(tmp_path / "bag", "mcap") as bag:
            bag.write_poses("/red/poses", 20, "optical", POSES)
            bag.write_poses("/red/poses", 30, "map", POSES)
        with pytest.raises(SourceError, match="different frames: 'map', 'optical'"):
            read_truth(tmp_path / "bag")

    def test_a_pose_that_is_none_is_refused(self, tmp_path):
        with BagWriter(tmp_path / "bag", "mcap") as bag:
            bag.write_poses("/red/poses", 20, "optical", [Pose(np.eye(3), [0, 0, np.nan])])
        with pytest.raises(SourceError, match="/red/poses: a pose of 'red' is none"):
            read_truth(tmp_path / "bag")

    def test_a_bag_without_poses_lists_what_it_has(self, tmp_path):
        with BagWriter(tmp_path / "bag", "mcap") as bag:
            bag.write_camera("/camera_info", 1, CAMERA)
        with pytest.raises(SourceError, match="no topic of geometry_msgs/msg/PoseArray.*/camera_info"):
            read_truth(tmp_path / "bag")

    @pytest.mark.parametrize(
        ("topic", "name"), [("/ground_truth/red/poses", "red"), ("/mocap/red", "red"), ("/poses", "poses")]
    )
    def test_names(self, topic, name):
        assert object_name(topic) == name


def coco(folder, images, annotations=()):
    names = ["base/plate.tail", "base/plate.head", "arm/stripe.tail", "arm/stripe.head"]
    content = {
        "images": [{"id": i, "file_name": name} for i, name in enumerate(images)],
        "annotations": [
            {"id": n, "image_id": i, "category_id": 7, "keypoints": points} for n, (i, points) in enumerate(annotations)
        ],
        "categories": [{"id": 7, "name": "lamp", "keypoints": names}],
    }
    (folder / "coco.json").write_text(json.dumps(content))
    return folder / "coco.json"


class TestAnnotations:
    def test_axes_by_image_and_images_without_objects(self, tmp_path):
        half = [1, 2, 2, 3, 4, 2, 9, 9, 2, 0, 0, 0]  # of the arm one end alone
        truth = read_truth(coco(tmp_path, ["x/a.png", "x/b.png"], [(0, half), (0, [0] * 12)]))
        assert truth.by_name and list(truth.frames) == ["a.png", "b.png"] and truth.frames["b.png"] == ()
        (o,) = truth.frames["a.png"]
        assert o.name == "lamp" and list(o.axes) == ["base/plate"] and o.told is Told.LABELLED and o.pose is None
        assert o.axes["base/plate"].tolist() == [[1, 2], [3, 4]]
        assert o.centre_px.tolist() == pytest.approx([13 / 3, 5])

    def test_which_one_an_object_is_may_be_an_attribute(self, tmp_path):
        path = coco(tmp_path, ["a.png"], [(0, [1, 2, 2, 3, 4, 2, 0, 0, 0, 0, 0, 0])])
        content = json.loads(path.read_text())
        content["annotations"][0]["attributes"] = {"identity": "red"}
        path.write_text(json.dumps(content))
        (o,) = read_truth(path).frames["a.png"]
        assert (o.name, o.identity) == ("lamp", "red")

    def test_files_named_by_stamp_go_by_stamp(self, tmp_path):
        truth = read_truth(coco(tmp_path, ["1700000000000000000.png", "1700000000033333333.png"]))
        assert list(truth.frames) == [1700000000000000000, 1700000000033333333] and not truth.by_name

    def test_two_images_of_one_name_are_refused(self, tmp_path):
        with pytest.raises(SourceError, match="two images are called 'a.png'"):
            read_truth(coco(tmp_path, ["x/a.png", "y/a.png"]))


def test_lines_of_truth_may_bear_names_and_joints(tmp_path):
    o = {
        "object": "lamp",
        "identity": "red",
        "team": 2,
        "position": [0, 0, 1],
        "rotation": np.eye(3).tolist(),
        "components": {},
    }
    (tmp_path / "t.jsonl").write_text(
        json.dumps({"stamp_ns": 5, "objects": [o | {"joints": {"arm": 0.5}}, {**o, "object": None}]}) + "\n"
    )
    first, second = read_truth(tmp_path / "t.jsonl").frames[5]
    assert (first.name, first.label, first.joints, first.told) == ("lamp", 2, {"arm": 0.5}, Told.ALL)
    assert second.name is None and second.joints == {} and second.centre_px is None


def test_truth_of_the_image_plane_has_no_poses_and_objects_go_by_name_or_label(tmp_path):
    part = {"full_px": 50, "visible_px": 40, "centre": [3, 4]}
    (tmp_path / "t.jsonl").write_text(
        json.dumps({"stamp_ns": 5, "objects": [{"object": "a", "components": {"x": part}}]})
    )
    (o,) = read_truth(tmp_path / "t.jsonl").frames[5]
    assert (o.pose, o.label, o.name) == (None, None, "a") and o.components["x"].visible_px == 40
    (tmp_path / "t.jsonl").write_text(json.dumps({"stamp_ns": 5, "objects": [{"components": {}}]}))
    with pytest.raises(SourceError, match="line 1.*team"):
        read_truth(tmp_path / "t.jsonl")


def test_what_is_seen_lies_before_the_camera(tmp_path):
    """It was scored by its place in the image, and poses were never looked at."""
    path, lies_behind = tmp_path / "t.jsonl", ("objects", 0, "position", [0, 0, -1])
    for z in (0, -1):
        path.write_text(f"{wrong_truth('stamp_ns', 4)}\n{wrong_truth('objects', 0, 'position', [0, 0, z])}\n")
        with pytest.raises(SourceError, match=rf"t\.jsonl.*line 2.*objects\[0\]\.position.*z is {z} m") as caught:
            read_truth(path)
        assert "\n" not in str(caught.value)
    line = json.loads(wrong_truth(*lies_behind))
    line["objects"][0] |= {"components": {}, "centre_px": None}
    path.write_text(json.dumps(line))
    assert read_truth(path).frames[5][0].pose.position[2] == -1, "it is not in the image, and may be told of"


def wrong_truth(*change):
    """A line of truth in which the value at some keys is another one."""
    part = {"full_px": 50, "visible_px": 40, "centre": [3, 4]}
    o = {"object": "lamp", "team": 2, "position": [0, 0, 1], "rotation": np.eye(3).tolist(), "joints": {"arm": 0.5}}
    line = {"stamp_ns": 5, "objects": [{**o, "components": {"x": part}, "centre_px": [1, 2]}]}
    *keys, last, value = change
    place = line
    for key in keys:
        place = place[key]
    place[last] = value
    return json.dumps(line)


NAN, FINITE = float("nan"), "must be a finite number, not"


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("[]", "must be a mapping {key: value}, not []"),
        ("5", "must be a mapping {key: value}, not 5"),
        (wrong_truth("stamp_ns", NAN), "stamp_ns: must be a whole number, not nan"),
        (wrong_truth("stamp_ns", 1.5), "stamp_ns: must be a whole number, not 1.5"),
        (wrong_truth("stamp_ns", 10**30), "stamp_ns: must be at least"),
        (wrong_truth("objects", {}), "objects: must be a list, not {}"),
        (wrong_truth("objects", None), "objects: must be a list, not nothing"),
        (wrong_truth("objects", 0, "position", [NAN, 0, 1]), f"objects[0].position[0]: {FINITE} nan"),
        (wrong_truth("objects", 0, "position", "abc"), "objects[0].position: must be a list of 3, not 'abc'"),
        (wrong_truth("objects", 0, "rotation", [[1e308] * 3] * 3), f"objects[0].rotation[0][0]: {FINITE} 1e+308"),
        (
            wrong_truth("objects", 0, "components", None),
            "objects[0].components: must be a mapping {key: value}, not no",
        ),
        (
            wrong_truth("objects", 0, "components", "x", "visible_px", -1),
            "objects[0].components.x.visible_px: must be a",
        ),
        (
            wrong_truth("objects", 0, "components", "x", "centre", 0, NAN),
            f"objects[0].components.x.centre[0]: {FINITE}",
        ),
        (wrong_truth("objects", 0, "joints", "arm", NAN), f"objects[0].joints.arm: {FINITE} nan"),
        (wrong_truth("objects", 0, "joints", 1.5), "objects[0].joints: must be a mapping"),
        (wrong_truth("objects", 0, "object", True), "objects[0].object: must be text, not True"),
    ],
)
def test_wrong_values_of_truth_are_told_by_their_keys(tmp_path, line, said):
    path = tmp_path / "truth.jsonl"
    path.write_text(json.dumps({"stamp_ns": 1, "objects": []}) + f"\n{line}\n")
    with pytest.raises(SourceError) as caught:
        read_truth(path)
    assert str(caught.value).startswith(f"{path}: line 2: {said}")
    assert f"line 2: {said}" in (take_stock([path])[0].error or "")  # inspect says the same


def test_a_byte_order_mark_before_truth_is_passed_over(tmp_path):
    (tmp_path / "t.jsonl").write_text(json.dumps({"stamp_ns": 1, "objects": []}), encoding="utf-8-sig")
    assert list(read_truth(tmp_path / "t.jsonl").frames) == [1]
    content = coco(tmp_path, ["a.png"]).read_text()
    (tmp_path / "coco.json").write_text(content, encoding="utf-8-sig")
    assert list(read_truth(tmp_path / "coco.json").frames) == ["a.png"]


def test_what_is_no_truth(tmp_path):
    with pytest.raises(SourceError, match="truth is read from a bag"):
        read_truth(tmp_path / "truth.yaml")
    with pytest.raises(ArtrecError, match="no bag"):
        read_truth(tmp_path)
