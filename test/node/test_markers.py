from __future__ import annotations

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

from dataclasses import replace

import numpy as np
from std_msgs.msg import Header
from visualization_msgs.msg import Marker

from artrec_ros.core.base.config import TrackingConfig
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.found import Detection, ImagePose, Instance
from artrec_ros.core.model.frame_result import FrameResult
from artrec_ros.core.model.objects import Box, Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.tracking.tracker import Tracker
from artrec_ros.io.objects.solids import box_solid
from artrec_ros.io.parameters.parameter_file import Setup
from artrec_ros.node.markers import MarkerScene

HEADER = Header(frame_id="eye")
FACING = (np.pi, 0, 0)  # the object's y up, the camera's down


def detection(number: int, *components: str, arm_rad: float = 0.0, posed: bool = True) -> Detection:
    names = {"body": "hull", "arm": "lever"}
    parts = tuple(Instance(c, names[c], 1.0, 0, 0, 0, 1) for c in components)
    pose = Pose.from_xyz_rpy((0, 0, 1), FACING) if posed else None
    return Detection("toy", number, 0.5, ImagePose(0, 0, 0, 1), parts, pose, {"arm": arm_rad})


def keys(markers: list[Marker], action: int) -> list[tuple[str, int]]:
    return [(m.ns, m.id) for m in markers if m.action == action]


@pytest.fixture
def scene(setup: Setup) -> MarkerScene:
    return MarkerScene(setup.targets)


def test_outlines_lie_where_pose_and_joint_put_them(scene: MarkerScene) -> None:
    markers = scene.update([detection(0, "body", "arm", arm_rad=np.pi / 2)], HEADER).markers
    hull, lever = (m for m in markers if m.ns == "toy/outline")
    corner = hull.points[0]
    assert (corner.x, corner.y, corner.z) == pytest.approx((-0.10, 0.05, 1))
    assert hull.points[0] == hull.points[-1]
    # the lever's tip, 0.14 m from its joint, points up after a quarter turn
    tip = np.mean([[p.x, p.y, p.z] for p in lever.points[1:3]], axis=0)
    assert tip == pytest.approx((0, -0.08 - 0.14, 1))


def test_all_sides_of_a_box_of_one_colour_are_drawn() -> None:
    box = Box(Pose.identity(), np.array([0.2, 0.1, 0.1]))
    model = ObjectModel("brick", (Component("box", box_solid(box)[0], required=True, bodies=(box,)),))
    one = Instance("box", "top", 1.0, 0, 0, 0, 1)
    pose = Pose.from_xyz_rpy((0, 0, 1), FACING)
    found = Detection("brick", 0, 0.5, ImagePose(0, 0, 0, 1), (one,), pose, {})
    markers = MarkerScene([Target("brick", model, 3)]).update([found], HEADER).markers
    corners = np.array([[p.x, p.y, p.z] for m in markers if m.ns == "brick/outline" for p in m.points])
    assert sum(m.ns == "brick/outline" for m in markers) == 6
    assert np.ptp(corners, axis=0) == pytest.approx(box.size)


def test_name_and_frame_come_along(scene: MarkerScene) -> None:
    markers = {m.ns: m for m in scene.update([detection(3, "body")], HEADER).markers}
    assert markers["toy/name"].text == "toy_3 0.50"
    assert len(markers["toy/frame"].points) == len(markers["toy/frame"].colors) == 6
    assert all(m.header == HEADER for m in markers.values())


def test_names_stay_and_only_what_vanished_is_deleted(scene: MarkerScene) -> None:
    first = scene.update([detection(0, "body", "arm"), detection(1, "body")], HEADER).markers
    second = scene.update([detection(1, "body"), detection(0, "body")], HEADER).markers
    gone = keys(second, Marker.DELETE)
    assert len(gone) == 1 and gone[0] in keys(first, Marker.ADD)
    assert set(keys(second, Marker.ADD)) == set(keys(first, Marker.ADD)) - set(gone)
    third = scene.update([], HEADER).markers
    assert sorted(keys(third, Marker.DELETE)) == sorted(keys(second, Marker.ADD))
    assert scene.update([], HEADER).markers == []


def test_an_object_keeps_its_markers_wherever_it_stands_in_the_list(scene: MarkerScene) -> None:
    """The recogniser counts anew in each frame; the tracker names objects, and markers bear these names."""
    tracker = Tracker(TrackingConfig())

    def at(number: int, x: float) -> Detection:
        pose = Pose.from_xyz_rpy((x, 0, 1), FACING)
        return replace(detection(number, "body"), pose=pose, image=ImagePose(300 * x, 0, 0, 300))

    def markers(stamp_ns: int, *found: Detection) -> list[Marker]:
        return scene.update(tracker.update(stamp_ns, FrameResult((320, 240), found)).detections, HEADER).markers

    both = markers(10**9, at(0, 0.0), at(1, 0.4))
    swapped = markers(10**9 + 10**8, at(0, 0.4), at(1, 0.0))
    assert set(keys(swapped, Marker.ADD)) == set(keys(both, Marker.ADD)) and not keys(swapped, Marker.DELETE)
    one = markers(10**9 + 2 * 10**8, at(0, 0.4))
    assert set(keys(one, Marker.ADD)) | set(keys(one, Marker.DELETE)) == set(keys(both, Marker.ADD))
    places = {m.id: m.pose.position.x for m in one if m.ns == "toy/frame" and m.action == Marker.ADD}
    assert places == {1: 0.4}


def test_ids_that_have_grown_large_fit_the_message(scene: MarkerScene) -> None:
    markers = scene.update([detection(2**31 + 5, "body", "arm")], HEADER).markers
    assert len(markers) == 4 and all(0 <= m.id < 2**31 for m in markers)


def test_no_two_markers_share_a_name(scene: MarkerScene) -> None:
    markers = scene.update([detection(i, "body", "arm") for i in range(4)], HEADER).markers
    assert len(set(keys(markers, Marker.ADD))) == len(markers) == 16


def flat(number: int = 0, pose: Pose | None = None) -> Detection:
    """The hull as the image shows it, a square turned by 30 degrees."""
    turn = np.pi / 6
    c, s = np.cos(turn), np.sin(turn)
    hull = Instance(
        "body", "hull", 1.0, 120.0, 80.0, turn, 200.0, np.array([[c, s], [-c, -s], [-s, c]]) * 10 + (120, 80)
    )
    return Detection("toy", number, 0.5, ImagePose(120, 80, turn, 200), (hull,), pose, pose_from="size")


def test_without_a_pose_the_image_is_shown_in_pixels(scene: MarkerScene) -> None:
    markers = {m.ns: m for m in scene.update([flat()], HEADER).markers}
    assert set(markers) == {"toy/frame", "toy/name", "toy/outline"}
    assert {m.header.frame_id for m in markers.values()} == {"eye_image"}
    outline, frame, name = (markers[f"toy/{ns}"] for ns in ("outline", "frame", "name"))
    corners = [[p.x, p.y, p.z] for p in outline.points[:2]]
    np.testing.assert_allclose(corners, [[120 + 8.66, 85, 0], [120 - 8.66, 75, 0]], atol=0.01)
    assert outline.points[0] == outline.points[-1] and outline.scale.x == 1.0
    assert (frame.pose.position.x, frame.pose.position.y) == (120, 80) and len(frame.points) == 4
    assert 2 * np.arctan2(frame.pose.orientation.z, frame.pose.orientation.w) == pytest.approx(np.pi / 6)
    assert (name.pose.position.x, name.pose.position.y, name.scale.z) == (120, 60, 10)  # above it: y is down


def test_a_pose_that_comes_moves_an_objects_markers_to_its_frame(scene: MarkerScene) -> None:
    """The same ns and id, so that nothing stays behind in the image's frame."""
    image = scene.update([flat()], HEADER).markers
    space = scene.update([detection(0, "body")], HEADER).markers
    assert set(keys(space, Marker.ADD)) == set(keys(image, Marker.ADD)) and not keys(space, Marker.DELETE)
    assert {m.header.frame_id for m in space} == {"eye"}
    gone = scene.update([], HEADER).markers
    assert {m.header.frame_id for m in gone} == {"eye"}


@pytest.mark.parametrize("frame_id", ["", "field"])
def test_an_object_placed_by_its_size_is_drawn_in_the_plane_of_its_marker(scene: MarkerScene, frame_id: str) -> None:
    """Wherever its frame is: of the marker's centroid, and of where its axis points, the pose says all."""
    marker = scene._scene._models["toy"].required.markers[0]
    pose = Pose.from_xyz_rpy((0.3, -0.2, 1.5), (np.pi, 0.0, 0.7))
    markers = scene.update([replace(flat(pose=pose), frame_id=frame_id)], HEADER).markers
    assert {m.header.frame_id for m in markers} == {frame_id or "eye"}
    (outline,) = (m for m in markers if m.ns == "toy/outline")
    points = np.array([[p.x, p.y, p.z] for p in outline.points])
    centre = pose.apply([[*marker.centroid, 0]])[0]
    along = np.array([np.cos(-marker.axis_angle), np.sin(-marker.axis_angle), 0])  # tail to head, y up
    np.testing.assert_allclose(points[0], centre + pose.rotation @ along * 10 / 200, atol=1e-9)
    np.testing.assert_allclose(points[1], centre - pose.rotation @ along * 10 / 200, atol=1e-9)
    left = np.cross([0, 0, 1], along)  # a quarter turn clockwise in the image is one to the marker's right
    np.testing.assert_allclose(points[2], centre - pose.rotation @ left * 10 / 200, atol=1e-9)
