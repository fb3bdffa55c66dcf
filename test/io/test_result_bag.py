from __future__ import annotations

import os
import struct
import subprocess
import sys
import zlib

import cv2
import numpy as np
import pytest
from rosbags.highlevel import AnyReader

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.found import Detection, ImagePose, Instance
from artrec_ros.core.model.frame_result import FrameResult
from artrec_ros.core.model.target import Target
from artrec_ros.io.bags.topics import decode_message
from artrec_ros.io.images.cameras import load_camera
from artrec_ros.io.images.decoding import read_image
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.io.results.journal import Recognised
from artrec_ros.io.results.result_bag import ResultBag
from artrec_ros.io.sources.opening import SourceOptions, open_sources

TOY = """
format: artrec_object/1
name: toy
markers: {hull: {outline: [[-0.1, -0.05], [0.1, -0.05], [0.1, 0.05]], axis: [[-0.1, 0], [0.1, 0]]}}
components: {body: {required: true, markers: {hull: {pose: {xyz: [0, 0, 0]}}}}}
"""
CALIBRATION = """
image_width: 8
image_height: 6
camera_name: eye
camera_matrix: {rows: 3, cols: 3, data: [100, 0, 4, 0, 100, 3, 0, 0, 1]}
distortion_model: plumb_bob
distortion_coefficients: {rows: 1, cols: 5, data: [0, 0, 0, 0, 0]}
"""


@pytest.fixture
def targets(tmp_path):
    (tmp_path / "toy.yaml").write_text(TOY)
    return [Target("toy", load_object(tmp_path / "toy.yaml", {}), 3)]


def recognised(stamp_ns: int, found: bool) -> Recognised:
    parts = (Instance("body", "hull", 1.0, 0, 0, 0, 1),)
    pose = Pose.from_xyz_rpy((0.25, -0.5, 2))
    detection = Detection("toy", 4, 0.5, ImagePose(1, 2, 3, 4), parts, pose, pose_covariance=np.eye(6))
    return Recognised(stamp_ns, "x", FrameResult((8, 6), (detection,) if found else ()), "optical")


def write(path, source_path, targets, frames, options=None, storage="mcap"):
    overlay = np.full((12, 16, 3), 90, np.uint8)
    with (
        open_sources([source_path], options) as sources,
        ResultBag(path, storage, sources.parts[0], targets) as bag,
    ):
        for frame in frames:
            bag.add(frame, overlay)
    with AnyReader([path]) as reader:
        return [(c.topic, log_ns, reader.deserialize(raw, c.msgtype)) for c, log_ns, raw in reader.messages()]


def of_topic(messages, topic):
    return [m for t, _, m in messages if t == topic]


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_bag_beside_its_images(tmp_path, targets, ros2, write_rosbag2, pictures, storage):
    images = pictures(3)
    script = [("/cam/camera_info", 5, ros2.info(5, 100.0, (8, 6)))]
    script += [("/cam/image", 10 * i + 12, ros2.image(10 * i + 10, p)) for i, p in enumerate(images)]
    source = write_rosbag2(tmp_path / "source", script)
    frames = [recognised(10, True), recognised(20, False), Recognised(30, "x", error="dark")]
    messages = write(tmp_path / "out", source, targets, frames, storage=storage)
    assert [m.data.tobytes() for m in of_topic(messages, "/cam/image")] == [p.tobytes() for p in images]
    assert of_topic(messages, "/cam/camera_info")[0].k[0] == 100
    poses = of_topic(messages, "/toy/poses")
    assert [len(p.poses) for p in poses] == [1, 0]  # for every image that could be used, empty too
    assert poses[0].header.frame_id == "optical" and poses[0].header.stamp.nanosec == 10
    assert [m.joint_names for m in of_topic(messages, "/toy/robots")] == [["toy_4"], []]
    assert len(of_topic(messages, "/toy/joint_states")) == 2 and len(of_topic(messages, "/toy/pose")) == 1
    image = of_topic(messages, "/toy/image_poses")
    assert [len(p.poses) for p in image] == [1, 0] and image[0].header.frame_id == "optical_image"
    assert [m.joint_names for m in of_topic(messages, "/toy/image_robots")] == [["toy_4"], []]
    assert [m.joint_names for m in of_topic(messages, "/toy/image_components")] == [["toy_4/body/hull"], []]
    shown, gone = of_topic(messages, "/markers")
    assert {m.action for m in shown.markers} == {0} and {m.action for m in gone.markers} == {2}
    overlay = of_topic(messages, "/debug/image/compressed")[0]
    assert cv2.imdecode(overlay.data, cv2.IMREAD_COLOR).shape == (12, 16, 3)
    assert {log for topic, log, _ in messages if topic == "/toy/poses"} == {12, 22}  # recorded when their image was


def test_the_last_images_calibration_may_come_behind_it(tmp_path, targets, ros2, write_rosbag2, pictures):
    script = []
    for i, picture in enumerate(pictures(3)):
        script.append(("/cam/image", 10 * i + 12, ros2.image(10 * i + 10, picture)))
        script.append(("/cam/camera_info", 10 * i + 13, ros2.info(10 * i + 10, 100.0 + i, (8, 6))))
    source = write_rosbag2(tmp_path / "source", script)
    messages = write(tmp_path / "out", source, targets, [recognised(10 * i + 10, True) for i in range(3)])
    assert [m.k[0] for m in of_topic(messages, "/cam/camera_info")] == [100, 101, 102]
    assert sorted({log for topic, log, _ in messages if topic == "/toy/poses"}) == [12, 22, 32]
    with open_sources([tmp_path / "out"], SourceOptions(topic="/cam/image")) as sources:
        assert [f.camera.matrix[0, 0] for f in sources] == [100, 101, 102]


def test_ros1_images_become_ros2_images(tmp_path, targets, ros1, write_rosbag1, pictures):
    (image,) = pictures(1)
    script = [("/cam/camera_info", 5, ros1.info(5, 100.0, (8, 6))), ("/cam/image", 12, ros1.image(10, image))]
    messages = write(tmp_path / "out", write_rosbag1(tmp_path / "s.bag", script), targets, [recognised(10, True)])
    (copied,) = of_topic(messages, "/cam/image")
    assert copied.data.tobytes() == image.tobytes() and copied.header.stamp.nanosec == 10
    assert of_topic(messages, "/cam/camera_info")[0].k[0] == 100
    assert len(of_topic(messages, "/toy/poses")[0].poses) == 1


def test_images_of_a_folder_go_to_the_nodes_topics(tmp_path, targets, pictures):
    folder = tmp_path / "images"
    folder.mkdir()
    image = pictures(1)[0].astype(np.uint16) * 300
    cv2.imwrite(str(folder / "0.png"), image)
    (folder / "1.png").write_bytes(b"none")
    (tmp_path / "camera.yaml").write_text(CALIBRATION)
    options = SourceOptions(camera=load_camera(tmp_path / "camera.yaml"), rate_hz=10)
    frames = [recognised(0, True), Recognised(10**8, "1.png", error="unreadable")]
    messages = write(tmp_path / "out", folder, targets, frames, options)
    (copied,) = of_topic(messages, "/image/compressed")
    assert copied.format == "mono16; png compressed mono16" and not of_topic(messages, "/image")
    assert copied.data.tobytes() == (folder / "0.png").read_bytes()
    assert np.array_equal(decode_message(copied), image)
    assert of_topic(messages, "/camera_info")[0].k[0] == 100
    assert len(of_topic(messages, "/toy/poses")) == 1


@pytest.mark.parametrize("suffix", [".jpg", ".png", ".bmp"])
@pytest.mark.parametrize("shape", [(60, 80), (60, 80, 3), (60, 80, 4)])
def test_encoded_images_of_a_folder_stay_as_they_are(tmp_path, targets, suffix, shape):
    folder = tmp_path / "images"
    folder.mkdir()
    smooth = np.broadcast_to(np.linspace(0, 200, 80, dtype=np.uint8).reshape(1, 80, *[1] * (len(shape) - 2)), shape)
    cv2.imwrite(str(folder / f"0{suffix}"), np.ascontiguousarray(smooth))
    messages = write(tmp_path / "out", folder, targets, [recognised(0, True)])
    raw, packed = of_topic(messages, "/image"), of_topic(messages, "/image/compressed")
    if suffix == ".bmp":
        assert len(raw) == 1 and not packed  # image_transport knows no such format
        return
    assert not raw and packed[0].data.tobytes() == (folder / f"0{suffix}").read_bytes()
    channels = shape[2] if len(shape) == 3 else 1
    expected = {1: "mono8", 3: "bgr8", 4: "bgra8" if suffix == ".png" else "bgr8"}[channels]
    assert packed[0].format.startswith(f"{expected}; {'jpeg' if suffix == '.jpg' else 'png'} compressed")
    assert np.array_equal(decode_message(packed[0]), read_image(folder / f"0{suffix}"))


def test_a_file_that_exif_data_turn_is_written_upright(tmp_path, targets):
    (folder := tmp_path / "images").mkdir()
    exif = b"Exif\0\0MM\0*" + struct.pack(">IHHHIHHI", 8, 1, 0x112, 3, 1, 6, 0, 0)
    encoded = cv2.imencode(".jpg", np.full((60, 80, 3), 90, np.uint8))[1].tobytes()
    segment = b"\xff\xe1" + struct.pack(">H", len(exif) + 2) + exif
    (folder / "0.jpg").write_bytes(encoded[:2] + segment + encoded[2:])
    messages = write(tmp_path / "out", folder, targets, [recognised(0, True)])
    (raw,) = of_topic(messages, "/image")
    assert (raw.width, raw.height) == (60, 80) and not of_topic(messages, "/image/compressed")


def test_grey_of_few_bits_is_written_as_class_numbers(tmp_path, targets):
    """Whoever decodes its PNG spreads them over all of a byte."""
    (folder := tmp_path / "images").mkdir()
    kinds = (b"IHDR", struct.pack(">IIBBBBB", 2, 1, 4, 0, 0, 0, 0)), (b"IDAT", zlib.compress(b"\0\x2a")), (b"IEND", b"")
    parts = [struct.pack(">I", len(d)) + k + d + struct.pack(">I", zlib.crc32(k + d)) for k, d in kinds]
    (folder / "0.png").write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(parts))
    messages = write(tmp_path / "out", folder, targets, [recognised(0, True)])
    (raw,) = of_topic(messages, "/image")
    assert bytes(raw.data) == bytes([2, 10]) and not of_topic(messages, "/image/compressed")


def test_the_objects_frames_go_to_tf_for_viewers(tmp_path, targets, ros2, write_rosbag2, pictures):
    script = [("/cam/image", 10 * i + 12, ros2.image(10 * i + 10, p)) for i, p in enumerate(pictures(2))]
    source = write_rosbag2(tmp_path / "source", script)
    frames = [recognised(10, True), recognised(20, False)]
    (sent,) = of_topic(write(tmp_path / "out", source, targets, frames), "/tf")
    (transform,) = sent.transforms
    assert (transform.header.frame_id, transform.child_frame_id) == ("optical", "toy_4")
    assert transform.header.stamp.nanosec == 10
    t, q = transform.transform.translation, transform.transform.rotation
    assert (t.x, t.y, t.z, q.w) == (0.25, -0.5, 2, 1)


def test_a_bag_of_labels_is_packed_and_other_tools_read_it(tmp_path, targets, ros2, write_rosbag2):
    labels = np.zeros((480, 640), np.uint8)
    script = [("/cam/image", 10 * i + 12, ros2.image(10 * i + 10, labels)) for i in range(5)]
    source = write_rosbag2(tmp_path / "source", script)
    write(tmp_path / "out", source, targets, [recognised(10 * i + 10, True) for i in range(5)])
    assert sum(f.stat().st_size for f in (tmp_path / "out").iterdir()) < 0.1 * 5 * labels.size
    convert = [sys.executable, "-m", "rosbags.convert", "--src", tmp_path / "out", "--dst", tmp_path / "c.bag"]
    subprocess.run([*map(str, convert)], check=True, capture_output=True, timeout=120)
    with AnyReader([tmp_path / "c.bag"]) as reader:
        assert {c.topic: c.msgcount for c in reader.connections}["/tf"] == 5


@pytest.fixture
def coloured(tmp_path, targets, ros2, write_rosbag2):
    """A bag of five colour images, with calibration and results."""
    colour = np.full((6, 8, 3), (10, 200, 90), np.uint8)
    script = [("/cam/camera_info", 5, ros2.info(5, 100.0, (8, 6)))]
    script += [("/cam/image", 10 * i + 12, ros2.image(10 * i + 10, colour)) for i in range(5)]
    write(
        tmp_path / "out",
        write_rosbag2(tmp_path / "source", script),
        targets,
        [recognised(10 * i + 10, True) for i in range(5)],
    )
    (path,) = (tmp_path / "out").glob("*.mcap")
    return path


def test_foxgloves_reader_knows_every_message(coloured):
    """With no definitions but those in the file, as viewers have them."""
    reader = pytest.importorskip("mcap_ros2.reader", reason="mcap-ros2-support is not installed")
    messages = {m.channel.topic: m.ros_msg for m in reader.read_ros2_messages(coloured)}
    assert {"/cam/image", "/cam/camera_info", "/toy/poses", "/toy/joint_states", "/markers", "/tf"} <= set(messages)
    (transform,) = messages["/tf"].transforms
    assert (transform.child_frame_id, transform.transform.translation.z) == ("toy_4", 2.0)
    assert [m.ns for m in messages["/markers"].markers] == ["toy/frame", "toy/name", "toy/outline"]
    assert messages["/toy/pose"].pose.covariance[0] == 1.0


def test_rerun_draws_images_camera_and_transforms(coloured, tmp_path):
    chunk = pytest.importorskip("rerun.chunk", reason="rerun-sdk is not installed")
    out = tmp_path / "bag.rrd"
    convert = [sys.executable, "-m", "rerun", "mcap", "convert", str(coloured), "-o", str(out)]
    environment = {**os.environ, "HOME": str(tmp_path)}
    subprocess.run(convert, check=True, capture_output=True, timeout=120, env=environment)
    drawn: dict[str, set[str]] = {}
    for part in chunk.RrdReader(str(out)).stream():
        drawn.setdefault(part.entity_path, set()).update(part.to_record_batch().schema.names)
    assert "Image:buffer" in drawn["/cam/image"] and "EncodedImage:blob" in drawn["/debug/image/compressed"]
    assert "Pinhole:image_from_camera" in drawn["/cam/camera_info"]
    assert {"Transform3D:translation", "Transform3D:child_frame"} <= drawn["/tf"]
