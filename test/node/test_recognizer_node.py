"""The node as users meet it: another process, real messages."""

from __future__ import annotations

import array
from collections.abc import Iterator
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

import numpy as np
import toy
from diagnostic_msgs.msg import DiagnosticStatus
from geometry_msgs.msg import PoseArray
from peer import STARTED, NodeProcess, Peer, label_image, ros
from rcl_interfaces.msg import Parameter as ParameterMsg
from rcl_interfaces.msg import ParameterType, ParameterValue
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from sensor_msgs.msg import Image, JointState, MultiDOFJointState
from visualization_msgs.msg import MarkerArray

from artrec_ros.core.drawing import class_picture
from artrec_ros.core.geometry.projection import project
from artrec_ros.io.parameters.parameter_file import Setup

NO_CALIBRATION = np.zeros(9)


@pytest.fixture(scope="module")
def node(parameter_file: Path, tmp_path_factory: pytest.TempPathFactory) -> Iterator[NodeProcess]:
    with NodeProcess(*ros(parameter_file), log=tmp_path_factory.mktemp("node") / "log") as process:
        process.wait_for_output(STARTED)
        yield process
        assert process.running, process.output


@pytest.fixture(scope="module")
def one_peer(node: NodeProcess) -> Iterator[Peer]:
    with Peer() as peer:
        peer.listen("toy/poses", PoseArray)
        peer.listen("toy/robots", MultiDOFJointState)
        peer.listen("toy/joint_states", JointState)
        peer.listen("markers", MarkerArray)
        peer.connect(label_image(np.zeros((240, 320), np.uint8)))
        yield peer


@pytest.fixture
def peer(one_peer: Peer) -> Peer:
    one_peer.forget()
    return one_peer


def test_every_topic_bears_the_images_header(peer: Peer, picture: np.ndarray) -> None:
    stamp = peer.send(label_image(picture))
    for topic in ("toy/poses", "toy/robots", "toy/joint_states"):
        header = peer.answer(topic, stamp).header
        assert (header.stamp.nanosec, header.frame_id) == (250, "eye")


def test_answers_are_the_recognizers_own(peer: Peer, setup: Setup, picture: np.ndarray) -> None:
    peer.send_camera(toy.CAMERA.matrix)
    stamp = peer.send(label_image(picture))
    expected = setup.build().recognize(picture, toy.CAMERA).detections
    assert len(expected) == 1
    poses = [d.pose.position for d in expected if d.pose is not None]
    answer = peer.answer("toy/poses", stamp)
    np.testing.assert_allclose([[p.position.x, p.position.y, p.position.z] for p in answer.poses], poses)
    (named,) = peer.answer("toy/robots", stamp).joint_names
    assert named.startswith("toy_")  # its number is the tracker's, and there were images before
    joints = {f"{named}/{name}": q for d in expected for name, q in d.joints.items()}
    states = peer.answer("toy/joint_states", stamp)
    assert dict(zip(states.name, states.position, strict=True)) == pytest.approx(joints)
    assert peer.diagnose("recognition", "object(s) in")


def test_an_empty_image_is_answered_too(peer: Peer) -> None:
    empty = label_image(np.zeros((240, 320), np.uint8))
    assert peer.answer("toy/poses", peer.send(empty)).poses == []
    assert peer.diagnose("recognition", "nothing found", sending=empty).level == DiagnosticStatus.OK


def test_images_that_cannot_be_are_counted_and_survived(peer: Peer, node: NodeProcess, picture: np.ndarray) -> None:
    short = Image(height=480, width=640, step=640, encoding="mono8", data=array.array("B", bytes(30)))
    bad = peer.send(short)
    status = peer.diagnose("input", "could not be used: ")
    assert status.level == DiagnosticStatus.ERROR
    assert "30 bytes" in {v.key: v.value for v in status.values}["last_error"]
    peer.send(Image(height=2, width=2, step=4, encoding="bayer_rggb8", data=array.array("B", bytes(8))))
    assert "bayer_rggb8" in peer.diagnose("input", "bayer_rggb8").message
    good = peer.send(label_image(picture))
    assert peer.answer("toy/poses", good)
    assert bad not in [m.header.stamp.sec for m in peer.heard["toy/poses"]]
    assert "Traceback" not in node.output and node.told_s("image skipped")
    assert all(np.diff(node.told_s("image skipped")) > 4.9), "not a line for each image"


def test_without_calibration_poses_are_withheld_with_a_warning(peer: Peer, picture: np.ndarray) -> None:
    peer.send_camera(NO_CALIBRATION)
    stamp = peer.send(label_image(picture))
    assert peer.answer("toy/poses", stamp).poses == []
    assert peer.diagnose("recognition", "object(s) in")
    assert peer.diagnose("calibration", "not calibrated").level == DiagnosticStatus.WARN


def test_calibration_of_another_size_withholds_poses(peer: Peer, picture: np.ndarray) -> None:
    peer.send_camera(toy.CAMERA.matrix)
    stamp = peer.send(label_image(np.ascontiguousarray(picture[:, :200])))
    assert peer.answer("toy/poses", stamp).poses == []
    assert "320x240" in peer.diagnose("calibration", "200x240").message


def look(peer: Peer, topic: str, picture: np.ndarray) -> Image:
    """A picture that comes while somebody subscribes to it."""
    peer.listen(topic, Image)
    assert peer.spin_until(lambda: peer.node.count_publishers(topic))

    def ask() -> bool:  # discovery takes a moment
        stamp = peer.send(label_image(picture))
        peer.answer("toy/poses", stamp)
        return bool(peer.heard[topic])

    assert peer.spin_until(ask)
    return peer.heard[topic][-1]


def test_the_overlay_comes_while_somebody_looks(peer: Peer, picture: np.ndarray) -> None:
    overlay = look(peer, "debug/image", picture)
    assert overlay.encoding == "bgr8" and len(overlay.data) == overlay.step * overlay.height > picture.size
    assert overlay.header.frame_id == "eye"


def test_what_the_recognizer_saw_is_shown_in_colours(peer: Peer, picture: np.ndarray) -> None:
    seen = look(peer, "debug/labels", picture)
    assert seen.encoding == "bgr8" and seen.header.frame_id == "eye"
    pixels = np.frombuffer(seen.data, np.uint8).reshape(seen.height, seen.width, 3)
    np.testing.assert_array_equal(pixels, class_picture(picture))
    assert len(np.unique(pixels.reshape(-1, 3), axis=0)) == 2, "the toy and the rest"


def test_all_parameters_are_read_at_once(peer: Peer) -> None:
    """As `ros2 param dump` does; those that hold nothing must not cost it the others."""
    listed = peer.call(ListParameters, "list_parameters", ListParameters.Request()).result.names
    assert {"image.classes", "image.blank", "recognizer.min_match"} <= set(listed)
    values = peer.call(GetParameters, "get_parameters", GetParameters.Request(names=listed)).values
    assert len(values) == len(listed)
    assert ParameterType.PARAMETER_NOT_SET not in {v.type for v in values}
    classes = values[listed.index("image.classes")]
    assert classes.type == ParameterType.PARAMETER_STRING_ARRAY and classes.string_array_value == []
    assert "read" in peer.set_parameters(image__classes=["red"]).reason


def test_a_bad_change_is_refused_whole_with_its_reason(peer: Peer) -> None:
    before = peer.get_parameter("recognizer.min_components")
    result = peer.set_parameters(recognizer__min_components=before + 1, recognizer__profile="papr")
    assert not result.successful
    assert "recognizer.profile" in result.reason and "papr" in result.reason and "paper" in result.reason
    assert peer.get_parameter("recognizer.min_components") == before


def test_a_good_change_is_taken_and_works(peer: Peer, picture: np.ndarray) -> None:
    whole = array.array("q", [0, 0, *toy.SIZE])
    assert peer.set_parameters(image__blank=whole).successful
    assert peer.diagnose("recognition", "nothing found", sending=label_image(picture))
    assert peer.set_parameters(image__blank=[]).successful
    assert peer.get_parameter("image.blank") == []
    assert peer.diagnose("recognition", "object(s) in", sending=label_image(picture))


def test_a_plane_and_a_region_given_while_it_runs_are_used(peer: Peer, setup: Setup, picture: np.ndarray) -> None:
    peer.send_camera(toy.CAMERA.matrix)
    (seen,) = setup.build().recognize(picture, toy.CAMERA).detections
    assert seen.pose is not None
    corners = np.array([[-0.3, -0.2], [0.3, -0.2], [0.3, 0.2], [-0.3, 0.2]])  # metres, y up, as deep as the object
    pixels = project(toy.CAMERA, np.column_stack([corners * (1, -1), np.full(4, seen.pose.position[2])]))
    plane = {
        "scene__plane__image_points": pixels.ravel().tolist(),
        "scene__plane__field_points": corners.ravel().tolist(),
    }
    alone = peer.set_parameters(scene__plane__image_points=pixels.ravel().tolist())
    assert not alone.successful and "field_points 0" in alone.reason
    assert peer.set_parameters(**plane).successful

    def in_field() -> PoseArray | None:
        answer = peer.answer("toy/poses", peer.send(label_image(picture)))
        return answer if answer.header.frame_id == "field" else None

    answer = next(found for _ in range(50) if (found := in_field()) is not None)
    (pose,) = answer.poses
    x, y, _ = seen.pose.position
    assert (pose.position.x, pose.position.y) == pytest.approx((x, -y), abs=0.01)
    assert peer.set_parameters(scene__region=[0.0, 0.0, 5.0, 0.0, 5.0, 5.0, 0.0, 5.0]).successful
    assert peer.diagnose("recognition", "nothing found", sending=label_image(picture))
    assert peer.set_parameters(scene__region=[], **dict.fromkeys(plane, [])).successful
    assert peer.diagnose("recognition", "object(s) in", sending=label_image(picture))


def test_a_change_that_leaves_no_distance_is_refused_where_the_camera_is_known(peer: Peer, picture: np.ndarray) -> None:
    peer.send_camera(toy.CAMERA.matrix)
    peer.answer("toy/poses", peer.send(label_image(picture)))
    refused = peer.set_parameters(recognizer__min_scale=1e308, recognizer__min_range_m=3.0)
    assert not refused.successful and "min_scale 1e+308 and max_scale 0 leave no distance" in refused.reason
    assert peer.get_parameter("recognizer.min_scale") < 1e308
    assert peer.set_parameters(image__kind="").reason.startswith("image.kind: must be text")


def test_out_of_range_read_only_and_unknown_changes_are_refused(peer: Peer) -> None:
    assert not peer.set_parameters(recognizer__min_match=1.5).successful
    assert "read" in peer.set_parameters(toy__label=3).reason
    assert not peer.set_parameters(objects=["toy", "more"]).successful
    before = peer.get_parameter("recognizer.min_components")
    unknown = peer.set_parameters(recognizer__min_components=before + 1, recognizer__profil="paper")
    assert not unknown.successful and "did you mean 'recognizer.profile'?" in unknown.reason
    assert peer.get_parameter("recognizer.min_components") == before
    assert peer.set_parameters(recognizer__min_components=before).successful
    assert "read" in peer.set_parameters(toy__label=3, recognizer__profil="paper").reason
    assert peer.set_parameters(recognizer__min_components=before).successful, "what was refused before is another thing"


def test_experts_parameters_are_there_where_they_were_given(peer: Peer) -> None:
    assert peer.get_parameter("expert.alignment.refine_steps") == 6
    assert peer.set_parameters(expert__alignment__refine_steps=7).successful
    assert peer.get_parameter("expert.alignment.refine_steps") == 7
    assert peer.set_parameters(expert__alignment__refine_steps=6).successful
    assert "at the start" in peer.set_parameters(expert__alignment__refine_keep=9).reason
    assert "expert.alignment.refine_keep" in peer.set_parameters(recognizer__refine_keep=9).reason


def test_a_request_that_is_none_is_survived(peer: Peer, node: NodeProcess, picture: np.ndarray) -> None:
    """rclpy's own services raise at some; the node must not end by that."""
    nonsense = ParameterMsg(name="recognizer.min_match", value=ParameterValue(type=99))
    client = peer.node.create_client(SetParameters, "artrec_node/set_parameters")
    assert peer.spin_until(client.service_is_ready)
    client.call_async(SetParameters.Request(parameters=[nonsense]))
    assert peer.spin_until(lambda: "a callback failed" in node.output)
    assert peer.answer("toy/poses", peer.send(label_image(picture)))


def test_an_int_is_taken_for_a_double(peer: Peer) -> None:
    assert peer.set_parameters(recognizer__time_budget_ms=900).successful
    assert peer.get_parameter("recognizer.time_budget_ms") == 900.0
