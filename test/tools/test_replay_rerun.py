"""`artrec replay --rerun`: the recording is read back and held against what the replay found."""

from __future__ import annotations

import os
import subprocess
import sys
from collections import defaultdict
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from artrec_ros.core.base.errors import ImageError
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import Pose, rotation_from_quaternion, rotation_from_rotvec
from artrec_ros.core.model.found import Detection, FrameResult, ImagePose, Instance, Rejection
from artrec_ros.core.model.kinematics import Kinematics
from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.io.messages.marker_messages import component_frames
from artrec_ros.io.parameters.parameter_file import Setup, load_parameters
from artrec_ros.io.results.journal import Recognised
from artrec_ros.io.results.results import read_results
from artrec_ros.tools.main import main

OBJECT = """
format: artrec_object/1
name: crane
markers: {patch: {outline: [[0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1]], axis: [[0, 0.05], [0.2, 0.05]]}}
components:
  base:
    required: true
    markers: {patch: {pose: {xyz: [0.1, 0.0, 0.05], rpy: [1.0, 0.2, 0.3]}}}
    body: {boxes: [{size: [0.4, 0.3, 0.1], xyz: [0.0, 0.0, 0.02], rpy: [0.0, 0.0, 0.5]}]}
  boom:
    markers: {patch: {pose: {xyz: [0.0, 0.3, 0.0], rpy: [0.0, 0.0, 0.0]}}}
    joint: {parent: base, origin: {xyz: [0.0, 0.1, 0.2], rpy: [0.0, 0.4, 0.0]}, axis: [0, 0, 1], limits: [-1.5, 1.5]}
  hook:
    markers: {patch: {pose: {xyz: [0.0, 0.1, 0.0], rpy: [0.0, 0.0, 0.0]}}}
    joint: {parent: boom, origin: {xyz: [0.0, 0.5, 0.0]}, axis: [1, 0, 0], limits: [-1.5, 1.5]}
"""
COLOURS = {"red": {"label": 3, "rgb": [200, 0, 0]}, "blue": {"label": 5, "rgb": [0, 0, 200]}}
PARAMETERS = {
    "objects": ["crane"],
    "crane": {"object_file": "crane.yaml", "label": 3},
    "image": {"kind": "palette", "tolerance": 40, "classes": [*COLOURS], **COLOURS},
}
CAMERA = Camera(np.array([[90.0, 0, 16], [0, 80, 12], [0, 0, 1]]), np.zeros(5), (32, 24), "optical")
STAMPS = [1_700_000_000_000_000_001 + i * 10**8 for i in range(5)]
CONTOUR = np.array([[3.0, 4.0], [9.0, 4.0], [9.0, 8.0]])
_A = np.random.default_rng(3).normal(size=(6, 6))
COVARIANCE = _A @ _A.T * 1e-4
BASE = Instance("base", "patch", 0.9, 6, 5, 0, 100, CONTOUR)
FOUND = Detection(
    "crane", 0, 0.8, ImagePose(6, 5, 0, 100), (BASE,), joints={"boom": 0.7}, pose_covariance=COVARIANCE,
    pose=Pose(rotation_from_rotvec([0.3, -0.5, 0.9]), np.array([0.1, -0.2, 1.5])),
)  # fmt: skip
TURNED_DOWN = Rejection("crane", "its boom is not confirmed", 0.4, 20.0, 10.0)


PNG = cv2.imencode(".png", np.zeros((2, 2), np.uint8))[1].tobytes()


class Recogniser:
    """The object is there in frames 0 and 3, in the latter flat in its image; frame 1 cannot be used."""

    def __init__(self) -> None:
        self.at = -1

    def follow(self, image, camera, stamp_ns, memory) -> tuple[FrameResult, None]:
        self.at += 1
        if self.at % 5 == 1:
            raise ImageError("too dark")
        flat = replace(FOUND, pose=None, joints={}, pose_covariance=None)
        found = {0: (FOUND,), 3: (flat,)}.get(self.at % 5, ())
        turned_down = (TURNED_DOWN,) if self.at % 5 == 2 else ()
        cut = ("recognizer.time_budget_ms",) if self.at % 5 == 4 else ()
        return FrameResult((32, 24), found, turned_down, {"blobs": 1.5, "total": 2.0}, ended_by=cut), None


@pytest.fixture
def params(tmp_path, monkeypatch):
    made = Recogniser()
    monkeypatch.setattr(Setup, "build", lambda self, **how: made)
    (tmp_path / "crane.yaml").write_text(OBJECT)
    path = tmp_path / "params.yaml"
    path.write_text(yaml.safe_dump({"/**": {"ros__parameters": PARAMETERS}}))
    return path


def picture(number: int) -> np.ndarray:
    image = np.full((24, 32, 3), (20, 120, 20), np.uint8)
    image[4:8, 2 + number : 10 + number] = (0, 0, 200)  # BGR: red
    image[12:20, 16:30] = (200, 0, 0)
    return image


@pytest.fixture
def bag(tmp_path):
    path = tmp_path / "bag"
    with BagWriter(path) as writer:
        for i, stamp in enumerate(STAMPS):
            writer.write_camera("/cam/camera_info", stamp, CAMERA)
            writer.write_image("/cam/image", stamp, "optical", picture(i))
    return path


def run(params, output, *sources, more=()) -> int:
    what = ["--images", "none", "--no-video", "-o", str(output.with_suffix("")), "--rerun", str(output), *more]
    return main(["replay", *map(str, sources), "--params-file", str(params), *what])


class Recording:
    """path -> component -> {stamp in ns, None: for good: value}."""

    def __init__(self, path: Path) -> None:
        chunk = pytest.importorskip("rerun.chunk", reason="rerun-sdk is not installed")
        self.rows = defaultdict(lambda: defaultdict(dict))
        self.timelines = set()
        reader = chunk.RrdReader(str(path))
        self.blueprints = reader.blueprints()
        for part in reader.stream():
            self.timelines |= set(part.timeline_names)
            batch = part.to_record_batch()
            times = (
                batch.column("stamp").cast("int64").to_pylist()
                if "stamp" in batch.schema.names
                else [None] * len(batch)
            )
            for name in batch.schema.names:
                if ":" in name:
                    for time, value in zip(times, batch.column(name).to_pylist(), strict=True):
                        if value is not None:
                            self.rows[part.entity_path][name][time] = value

    def at(self, path: str, component: str, number: int):
        """As numbers, where it is made of numbers."""
        value = self.rows[path][component][STAMPS[number]]
        return value if isinstance(value[0], (str, bytes)) else np.array(value)

    def stamps(self, path: str, component: str) -> list[int]:
        return sorted(self.rows[path][component])


@pytest.fixture
def recording(tmp_path, params, bag):
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    assert run(params, tmp_path / "seen.rrd", bag) == 0
    return Recording(tmp_path / "seen.rrd")


def placed(recording, path: str, number: int) -> Pose:
    quaternion, place = (recording.at(path, f"Transform3D:{name}", number)[0] for name in ("quaternion", "translation"))
    return Pose(rotation_from_quaternion(quaternion), np.asarray(place, float))


def test_one_timeline_has_all_stamps(recording):
    assert recording.timelines == {"stamp"} and len(recording.blueprints) == 1
    usable = [STAMPS[i] for i in (0, 2, 3, 4)]
    assert recording.stamps("/camera/classes", "SegmentationImage:buffer") == usable
    assert recording.stamps("/plots/milliseconds/total", "Scalars:scalars") == usable


@pytest.mark.parametrize("number", [0, 4])
def test_images_and_classes_are_those_of_the_frames(recording, params, number):
    blob = bytes(np.array(recording.at("/camera/image", "EncodedImage:blob", number), np.uint8).reshape(-1))
    image = cv2.imdecode(np.frombuffer(blob, np.uint8), cv2.IMREAD_COLOR)
    assert np.abs(image.astype(int) - picture(number)).mean() < 8, "JPEG"
    expected = np.zeros((24, 32), int)
    expected[4:8, 2 + number : 10 + number], expected[12:20, 16:30] = 3, 5
    classes = np.array(recording.at("/camera/classes", "SegmentationImage:buffer", number), np.uint8)
    assert (classes.reshape(24, 32) == expected).all()
    (told,) = recording.rows["/camera"]["AnnotationContext:context"][None]
    names = {entry["class_id"]: entry["class_description"]["info"]["label"] for entry in told}
    assert (names[3], names[5]) == ("red", "blue")


def test_pixels_are_counted_from_their_corners(recording):
    outline = recording.at("/camera/found/crane_0", "LineStrips2D:strips", 0)[0]
    assert np.allclose(outline, np.vstack([CONTOUR, CONTOUR[:1]]) + 0.5)
    K = recording.at("/camera", "Pinhole:image_from_camera", 0).reshape(3, 3, order="F")
    assert np.allclose(K, CAMERA.matrix + [[0, 0, 0.5], [0, 0, 0.5], [0, 0, 0]])


def test_markers_and_bodies_lie_where_pose_and_joints_put_them(recording, params):
    (target,) = load_parameters(params).targets
    frames = component_frames(Kinematics(target.model), FOUND.pose, FOUND.joints)
    seen = placed(recording, "/objects/crane_0", 0)
    for name in ("base", "boom"):
        path, component = f"/objects/crane_0/{name}", target.model.component(name)
        T = seen @ placed(recording, path, 0)
        marker = component.markers[0]
        outline = np.column_stack([marker.outline, np.zeros(4)])
        drawn = recording.at(f"{path}/markers", "LineStrips3D:strips", 0)[0]
        assert np.allclose(T.apply(drawn[:4]), frames[name].apply(marker.T_component_marker.apply(outline)), atol=1e-6)
    box = target.model.component("base").bodies[0]
    half, centre = (
        recording.at("/objects/crane_0/base/bodies", f"Boxes3D:{n}", 0)[0] for n in ("half_sizes", "centers")
    )
    assert np.allclose(2 * half, box.size) and np.allclose(centre, box.T_component_box.position)
    assert not any(path.startswith("/objects/crane_0/hook") for path in recording.rows), "its joint is not known"


def test_the_ellipsoid_holds_95_of_100_places(recording):
    half = recording.at("/uncertainty/crane_0", "Ellipsoids3D:half_sizes", 0)[0].astype(float)
    axes = rotation_from_quaternion(recording.at("/uncertainty/crane_0", "Ellipsoids3D:quaternions", 0)[0])
    assert np.allclose(axes @ np.diag(half**2) @ axes.T / 7.815, COVARIANCE[:3, :3], rtol=1e-4)
    centre = recording.at("/uncertainty/crane_0", "Ellipsoids3D:centers", 0)[0]
    draws = np.random.default_rng(1).multivariate_normal(FOUND.pose.position, COVARIANCE[:3, :3], 4000)
    inside = (((draws - centre) @ axes / half) ** 2).sum(axis=1) < 1
    assert abs(inside.mean() - 0.95) < 0.02


def test_joints_scores_and_what_was_turned_down(recording, tmp_path):
    assert recording.at("/plots/joints/crane_0/boom", "Scalars:scalars", 0) == pytest.approx([0.7])
    told = list(read_results(tmp_path / "seen" / "detections.jsonl"))
    for number in (0, 3):
        score = recording.at("/plots/scores/crane_0", "Scalars:scalars", number)
        assert score == pytest.approx([told[number].detections[0].score], abs=1e-4)
    assert np.allclose(recording.at("/camera/rejected", "Points2D:positions", 2), [[20.5, 10.5]])
    assert recording.at("/camera/rejected", "Points2D:labels", 2) == ["crane: its boom is not confirmed"]


@pytest.mark.parametrize("pose_from", ["fit", "plane"])
def test_an_object_that_is_expected_but_not_seen_is_shown_as_such(params, pose_from):
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    from artrec_ros.tools.replaying.rerun_scene import Scene

    hidden = replace(
        FOUND, components=(), predicted=True, pose_from=pose_from, frame_id="field" * (pose_from == "plane")
    )
    entities = dict(
        ("/".join(path), content)
        for path, content in Scene(load_parameters(params).targets).entities(
            Recognised(0, "x", FrameResult((32, 24), (hidden,))), None
        )
    )
    root = "field/objects/crane_0" if pose_from == "plane" else "objects/crane_0"
    assert root in entities and "(crane_0)" in repr(entities[f"{root}/name"][0])
    assert (f"{root}/boom/markers" in entities) == (pose_from == "fit")


def test_what_is_gone_is_cleared(recording):
    for path in ("/objects/crane_0", "/objects/crane_0/base/bodies", "/uncertainty/crane_0", "/camera/found/crane_0"):
        assert STAMPS[1] in recording.rows[path]["Clear:is_recursive"], path
    assert STAMPS[4] in recording.rows["/camera/found/crane_0"]["Clear:is_recursive"]
    assert STAMPS[3] in recording.rows["/camera/rejected"]["Clear:is_recursive"]
    assert recording.stamps("/objects/crane_0", "Transform3D:translation") == [STAMPS[0]], "flat: no place in space"


def test_frames_that_failed_and_searches_cut_short_are_in_the_log(recording):
    (first,), (second,) = (recording.at("/log", "TextLog:text", i) for i in (1, 4))
    assert "too dark" in first and "recognizer.time_budget_ms" in second
    assert recording.stamps("/log", "TextLog:text") == [STAMPS[1], STAMPS[4]]


def test_each_of_several_sources_has_its_path(tmp_path, params, bag):
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    assert run(params, tmp_path / "two.rrd", bag, bag) == 0
    rows = Recording(tmp_path / "two.rrd").rows
    paths = [{path.removeprefix(f"/source_{i}/") for path in rows if path.startswith(f"/source_{i}/")} for i in (0, 1)]
    assert paths[0] == paths[1] and "objects/crane_0/base/bodies" in paths[0]


def test_rerun_itself_has_nothing_against_the_file(tmp_path, params, bag):
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    assert run(params, tmp_path / "seen.rrd", bag) == 0
    command = [sys.executable, "-m", "rerun", "rrd", "verify", str(tmp_path / "seen.rrd")]
    environment = {**os.environ, "HOME": str(tmp_path)}
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, env=environment)
    assert done.returncode == 0 and "without error" in done.stdout + done.stderr, done.stderr


def test_of_an_interrupted_replay_nothing_is_left_that_looks_whole(tmp_path, params, bag, monkeypatch):
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    from artrec_ros.tools.replaying.rerun_file import RerunFile

    def fails(self, *_):
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(RerunFile, "add", fails)
        assert run(params, tmp_path / "seen.rrd", bag) == 1
    assert not list(tmp_path.glob("seen.rrd*"))
    assert run(params, tmp_path / "seen.rrd", bag) == 0, "the same command goes on, with all frames from the first on"
    assert len(Recording(tmp_path / "seen.rrd").stamps("/camera/classes", "SegmentationImage:buffer")) == 4


def test_where_there_is_no_room_it_ends_and_says_so(tmp_path):
    """Rerun's own writer would be waited for in vain."""
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    program = f"""
import resource, numpy as np
from pathlib import Path
from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.base.errors import SourceError
from artrec_ros.io.results.journal import Recognised
from artrec_ros.tools.replaying.raw_frames import RawFrame
from artrec_ros.tools.replaying.rerun_file import RerunFile
resource.setrlimit(resource.RLIMIT_FSIZE, (100_000, 100_000))
noise = np.random.default_rng(0).integers(0, 255, (40, 30_000), np.uint8)  # nothing packs it
try:
    with RerunFile(Path({str(tmp_path / "seen.rrd")!r}), ImageConfig(), ()) as file:
        for i, picture in enumerate(noise):
            file.add(0, Recognised(i, "x"), RawFrame({PNG!r}, picture.tobytes(), None))
except SourceError as error:
    print("no room:", error)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert "no room:" in done.stdout and "seen.rrd" in done.stdout, done.stderr
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("missing", ["rerun", "folder"])
def test_what_is_missing_is_told_before_any_work(tmp_path, params, bag, capsys, monkeypatch, missing):
    output = tmp_path / "seen.rrd"
    if missing == "rerun":
        monkeypatch.setitem(sys.modules, "rerun", None)
    else:
        pytest.importorskip("rerun", reason="rerun-sdk is not installed")
        output = tmp_path / "nowhere" / "seen.rrd"
    assert run(params, output, bag, more=["-o", str(tmp_path / "out")]) == 1
    told = capsys.readouterr().err.strip()
    assert ("pip install 'artrec_ros[rerun]'" if missing == "rerun" else "make it, or name another") in told
    assert len(told.splitlines()) == 1 and not (tmp_path / "out").exists()


def test_a_recording_has_its_ending(tmp_path, params, bag, capsys):
    assert run(params, tmp_path / "seen.mcap", bag) == 2
    assert "name it FILE.rrd" in capsys.readouterr().err
