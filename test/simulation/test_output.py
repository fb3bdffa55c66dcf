import json
from pathlib import Path
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.errors import SourceError
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.objects import Box, Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.io.bags.reader import Bag
from artrec_ros.io.images.cameras import load_camera
from artrec_ros.io.learned.annotations import load_coco
from artrec_ros.io.objects.solids import ball_solid, box_solid
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.output import write_frames
from artrec_ros.simulation.records import is_annotated, keypoint_names, truth_record
from artrec_ros.simulation.simulator import simulate
from artrec_ros.simulation.truth import MarkerTruth, ObjectTruth

from .conftest import square


@pytest.fixture
def frames(target, camera):
    config = SceneConfig(objects=(1, 2), size=(0.3, 0.6))
    return list(simulate([target], camera, config, SensorConfig(), 3, 6))


def contents(folder: Path):
    return {str(p.relative_to(folder)): p.read_bytes() for p in sorted(folder.rglob("*")) if p.is_file()}


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_the_same_frames_give_the_same_bytes(tmp_path, frames, target, storage):
    for name in ("a", "b"):
        write_frames(frames, [target], tmp_path / name, storage, colour=True)
    assert contents(tmp_path / "a") == contents(tmp_path / "b")


def test_the_folder_holds_a_line_of_truth_an_image_and_an_annotation_for_each_frame(tmp_path, frames, target):
    write_frames(frames, [target], tmp_path / "out")
    lines = [json.loads(line) for line in (tmp_path / "out/truth.jsonl").read_text().splitlines()]
    assert [line["stamp_ns"] for line in lines] == [f.stamp_ns for f in frames]
    coco = json.loads((tmp_path / "out/annotations.json").read_text())
    for image, frame in zip(coco["images"], frames, strict=True):
        pixels = cv2.imread(str(tmp_path / "out" / image["file_name"]), cv2.IMREAD_UNCHANGED)
        assert np.array_equal(pixels, frame.labels)
        assert (image["width"], image["height"]) == frame.camera.size


def test_annotations_mark_the_axes_of_the_markers_one_can_see(tmp_path, frames, target):
    write_frames(frames, [target], tmp_path / "out")
    coco = json.loads((tmp_path / "out/annotations.json").read_text())
    (category,) = coco["categories"]
    assert category["name"] == "pump"
    assert category["keypoints"] == ["base/front.tail", "base/front.head", "arm/side.tail", "arm/side.head"]
    assert category["keypoints"] == keypoint_names(target.model)
    expected = [
        (f.index, {m.marker: (m.tail, m.head) for m in t.markers if is_annotated(m)}) for f in frames for t in f.truths
    ]
    expected = [(index, marked) for index, marked in expected if marked]
    assert expected and len(coco["annotations"]) == len(expected)
    for annotation, (index, marked) in zip(coco["annotations"], expected, strict=True):
        assert annotation["image_id"] == index and annotation["num_keypoints"] == 2 * len(marked)
        points = np.array(annotation["keypoints"]).reshape(2, 2, 3)  # marker, end, (x, y, visibility)
        for row, marker in zip(points, ("front", "side"), strict=True):
            if marker in marked:
                np.testing.assert_allclose(row[:, :2], marked[marker], atol=0.006)
            assert (row[:, 2] == (2 if marker in marked else 0)).all()


def test_truth_names_the_best_seen_marker_of_a_component_by_the_component(frames):
    names = set()
    for frame in frames:
        for truth, record in zip(frame.truths, truth_record(frame)["objects"], strict=True):
            names |= set(record["components"])
            assert {c["marker"] for c in record["components"].values()} == {m.marker for m in truth.markers}
            assert record["team"] == 3 and record["object"] == "pump"
            assert set(record["joints"]) == {"arm"}
    assert names <= {"base", "arm"} and "base" in names


def test_a_folder_that_holds_files_is_refused(tmp_path, frames, target):
    (tmp_path / "notes.txt").write_text("mine")
    with pytest.raises(SourceError, match="holds files already"):
        write_frames(frames, [target], tmp_path)
    assert contents(tmp_path) == {"notes.txt": b"mine"}


@pytest.mark.parametrize("error", [KeyboardInterrupt, MemoryError])
def test_what_was_interrupted_is_begun_anew_and_is_the_same(tmp_path, frames, target, error):
    def breaking_off():
        yield from frames[:3]
        raise error

    with pytest.raises(error):
        write_frames(breaking_off(), [target], tmp_path / "out")
    (tmp_path / "out" / "notes.txt").write_text("mine")
    write_frames(frames, [target], tmp_path / "out")
    write_frames(frames, [target], tmp_path / "whole")
    assert contents(tmp_path / "out") == {**contents(tmp_path / "whole"), "notes.txt": b"mine"}
    with pytest.raises(SourceError, match="holds files already"):
        write_frames(frames, [target], tmp_path / "whole")


def test_two_runs_do_not_write_into_one_folder(tmp_path, frames, target):
    def another_at_the_same_time():
        yield frames[0]
        with pytest.raises(SourceError, match="another run is writing there"):
            write_frames(frames, [target], tmp_path / "out")
        yield frames[1]

    write_frames(another_at_the_same_time(), [target], tmp_path / "out")
    assert len((tmp_path / "out" / "truth.jsonl").read_text().splitlines()) == 2


def test_other_markers_of_a_component_are_named_with_it():
    def seen(marker, visible_px):
        return MarkerTruth("base", marker, 1.0, 100.0, visible_px, np.zeros(2), np.zeros(2), np.ones(2), None)

    pose = Pose(np.eye(3), np.array([0, 0, 1.0]))
    target = SimpleNamespace(name="pump", label=3, solids=frozenset(), balls={}, model=None)
    target.model = SimpleNamespace(components=(), required=SimpleNamespace(name="base"))
    placed = SimpleNamespace(target=target, T_camera_object=pose, joints={}, identity=None)
    truth = ObjectTruth(placed, np.zeros(2), (seen("rear", 10.0), seen("front", 90.0)))
    frame = SimpleNamespace(stamp_ns=1, truths=(truth,))
    components = truth_record(frame)["objects"][0]["components"]
    assert {name: c["marker"] for name, c in components.items()} == {"base": "front", "base@rear": "rear"}


def test_a_box_of_one_colour_is_all_of_it_that_shows_beside_its_sides(camera):
    box = Box(Pose.identity(), np.array([0.2, 0.1, 0.1]))
    brick = Target("brick", ObjectModel("brick", (Component("box", box_solid(box)[0], True, bodies=(box,)),)), 3)
    (frame,) = simulate([brick], camera, SceneConfig(objects=(1, 1), size=(0.3, 0.3)), SensorConfig(), 3, 1)
    components = truth_record(frame)["objects"][0]["components"]
    whole, sides = components.pop("box"), list(components.values())
    assert len(sides) > 1
    assert {name.split("@")[0] for name in components} == {"box"}
    assert whole["visible_px"] == pytest.approx(sum(side["visible_px"] for side in sides))
    shares = [side["visible_px"] / whole["visible_px"] for side in sides]
    assert whole["centre"] == pytest.approx(np.array(shares) @ [side["centre"] for side in sides])


def test_so_is_one_that_is_not_required(camera):
    boxes = [Box(Pose(np.eye(3), np.array([x, 0.0, 0.0])), np.full(3, 0.1)) for x in (0.0, 0.3)]
    parts = [
        Component(n, box_solid(b)[0], n == "one", bodies=(b,)) for n, b in zip(("one", "other"), boxes, strict=True)
    ]
    (frame,) = simulate(
        [Target("pair", ObjectModel("pair", tuple(parts)), 3)], camera, SceneConfig(), SensorConfig(), 3, 1
    )
    components = truth_record(frame)["objects"][0]["components"]
    assert {name.split("@")[0] for name in components if "@" in name} == {"one", "other"}


def test_a_ball_of_one_colour_is_where_its_centre_is(camera):
    sides, bodies = ball_solid(0.06, Pose.identity())
    ball = Target("ball", ObjectModel("ball", (Component("all", sides, True, bodies=bodies),)), 3)
    (frame,) = simulate([ball], camera, SceneConfig(objects=(1, 1), size=(0.3, 0.3)), SensorConfig(), 3, 1)
    (one,) = truth_record(frame)["objects"]
    assert one["components"]["all"]["centre"] == pytest.approx(one["centre_px"])


def test_solids_are_told_in_the_objects_order():
    """Whatever a set of names comes in: the same seed gives the same bytes."""
    names = [f"part_{n}" for n in range(8)]

    def seen(name):
        return MarkerTruth(name, "top", 1.0, 100.0, 90.0, np.zeros(2), np.zeros(2), np.ones(2), None)

    box = Box(Pose.identity(), np.full(3, 0.1))
    parts = tuple(Component(n, box_solid(box)[0], n == names[0], bodies=(box,)) for n in names)
    target = Target("stack", ObjectModel("stack", parts), 3)
    placed = SimpleNamespace(target=target, T_camera_object=Pose.identity(), joints={}, identity=None)
    frame = SimpleNamespace(stamp_ns=1, truths=(ObjectTruth(placed, np.zeros(2), tuple(map(seen, names[::-1]))),))
    assert [n for n in truth_record(frame)["objects"][0]["components"] if "@" not in n] == names


def test_the_bag_bears_true_joints_and_the_calibration_a_file(tmp_path, frames, target, camera):
    write_frames(frames, [target], tmp_path / "out")
    with Bag(tmp_path / "out/bag") as bag:
        messages = [bag.parse(m) for m in bag.messages(["/ground_truth/pump/joint_states"])]
    assert len(messages) == len(frames)
    for message, frame in zip(messages, frames, strict=True):
        truth = {f"pump_{n}/{k}": q for n, p in enumerate(frame.scene.objects) for k, q in p.joints.items()}
        assert dict(zip(message.name, message.position, strict=True)) == pytest.approx(truth)
    read = load_camera(tmp_path / "out/camera.yaml")
    np.testing.assert_allclose(read.matrix, camera.matrix)
    assert read.size == camera.size and read.frame_id == camera.frame_id and not read.distortion.any()


def test_truth_and_annotations_tell_which_one_it_is(tmp_path, camera):
    side, beside = (square(0.08, place=Pose(np.eye(3), np.array([x, 0.0, 0.01]))) for x in (0.0, 0.1))
    team = Component("team", (side,), required=True)
    accent = Component("accent", (beside,), classes={"red": 3, "blue": 4})
    target = Target("robot", ObjectModel("robot", (team, accent)), 2)
    frames = list(simulate([target], camera, SceneConfig(distractors=0), SensorConfig(), 1, 4))
    write_frames(frames, [target], tmp_path / "out")
    shown = [p.identity for frame in frames for p in frame.scene.objects]
    truth = [json.loads(line) for line in (tmp_path / "out/truth.jsonl").read_text().splitlines()]
    assert [o["identity"] for record in truth for o in record["objects"]] == shown
    annotated = load_coco([tmp_path / "out/annotations.json"]).objects
    assert shown and [a.attributes["identity"] for a in annotated] == shown
