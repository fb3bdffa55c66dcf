"""Objects that were found flat, placed by their size: exact where they face the camera, honest where they do not."""

from dataclasses import replace

import numpy as np
import pytest

from artrec_ros.core.base.config import PlaneConfig, RecognizerConfig, SceneConfig
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.scene import Scene
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.found import Detection, ImagePose, Instance
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.by_size import SizePlacer
from artrec_ros.core.pose.on_plane import PlanePlacer

LABEL, SIZE = 3, (640, 480)
K = [[520.0, 0, 310.0], [0, 560.0, 250.0], [0, 0, 1]]
PINHOLE = Camera(K, [], SIZE, "camera")
EVEN = Camera([[540.0, 0, 310.0], [0, 540.0, 250.0], [0, 0, 1]], [], SIZE, "camera")
BENT = Camera(K, [-0.28, 0.09, 0.001, -0.002, 0.0], SIZE, "camera")
FLAG = np.array([[-0.02, -0.02], [0.05, -0.02], [0.05, 0.01], [-0.02, 0.03]])  # its centroid is not its origin
FACING = np.diag([1.0, -1.0, -1.0])


def target(T_component_marker=None):
    flag = Marker("flag", FLAG, np.array([0.0, 0.0]), np.array([0.03, 0.02]), None, T_component_marker)
    other = Marker("patch", 0.5 * FLAG, np.zeros(2), np.array([0.01, 0.0]))
    return Target(
        "robot", ObjectModel("robot", (Component("team", (flag,), required=True), Component("side", (other,)))), LABEL
    )


def frame(camera=PINHOLE, labels=None):
    return ImageFrame(LabelField(np.zeros(SIZE[::-1], np.uint8) if labels is None else labels), camera)


def test_what_lacks_its_required_component_is_left_alone():
    """As flat objects of which the rest alone is told."""
    robot, plane = target(), PlaneConfig(image_points=(0, 0, 9, 0, 9, 9, 0, 9), field_points=(0, 1, 1, 1, 1, 0, 0, 0))
    side = Instance("side", "patch", 0.9, 50, 50, 0, 100.0)
    scene = Scene.of(SceneConfig(plane=plane))
    for parts in ((), (side,)):
        lacks = Detection("robot", 0, 0.9, ImagePose(50, 50, 0, 100), parts)
        for placer in (SizePlacer([robot], RecognizerConfig()), PlanePlacer([robot], RecognizerConfig())):
            assert placer.placed([lacks], replace(frame(), scene=scene)) == (lacks,)


def seen(T_camera_marker, camera=PINHOLE, small=1.0, by_axis=True):
    """A marker as the similarity of the image plane that comes nearest to how it is seen.

    :param small: the share of its size that is looked at; the smaller, the less perspective and lens bend it.
    :param by_axis: it has its axis' direction; else that of the similarity.
    """
    flag = target().model.required.markers[0]
    ring = np.column_stack([f(np.linspace(0, 2 * np.pi, 64, endpoint=False)) for f in (np.cos, np.sin)])
    about = flag.centroid + small * 0.03 * ring
    pixels = project(camera, T_camera_marker.apply(np.column_stack([about, np.zeros(len(about))])))
    centre = project(camera, T_camera_marker.apply([[*flag.centroid, 0.0]]))[0]
    x, y = pixels.T
    area = abs(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y)) / 2
    scale = float(np.sqrt(area / (32 * np.sin(np.pi / 32)))) / (small * 0.03)
    turn = np.angle(np.sum(((pixels - centre) @ (1, 1j)) * (ring @ (1, 1j))))  # least squares; y of the marker is up
    ends = flag.centroid + small * (np.stack([flag.tail, flag.head]) - flag.centroid)
    tail, head = project(camera, T_camera_marker.apply(np.column_stack([ends, np.zeros(2)])))
    theta = float(np.arctan2(*(head - tail)[::-1]) if by_axis else turn + flag.axis_angle)
    shown = Instance("team", "flag", 0.9, *map(float, centre), theta, scale)
    return Detection("robot", 0, 0.9, ImagePose(shown.x, shown.y, theta, scale), (shown,))


def placed(detection, camera=PINHOLE, of=None, labels=None, **config):
    (found,) = SizePlacer([of or target()], RecognizerConfig(**config)).placed([detection], frame(camera, labels))
    return found


@pytest.mark.parametrize("camera", [PINHOLE, BENT], ids=["pinhole", "bent"])
@pytest.mark.parametrize("turn", [-2.5, 0.0, 0.4, 3.1])
@pytest.mark.parametrize("place", [(0.0, 0.0, 1.0), (0.4, -0.3, 1.2), (-0.5, 0.35, 2.0)])
def test_what_faces_the_camera_is_where_it_is(camera, turn, place):
    """Through any lens, anywhere in the image."""
    truth = Pose(rotation_from_rotvec([0, 0, turn]) @ FACING, place)
    found = placed(seen(truth, camera, small=1e-3), camera)
    np.testing.assert_allclose(found.pose.position, truth.position, rtol=2e-3, atol=1e-4)
    # fx is not fy, and a bent lens skews: the axis' direction is right all the same
    np.testing.assert_allclose(found.pose.rotation, truth.rotation, atol=1e-3)
    assert found.pose_from == "size" and found.frame_id == ""


def test_twice_the_size_is_half_as_far():
    truth = Pose(FACING, (0.1, 0.2, 1.0))
    near, far = (placed(seen(Pose(FACING, truth.position * k))).pose.position for k in (1, 2))
    np.testing.assert_allclose(far, 2 * near, rtol=1e-3)


def test_the_objects_frame_is_the_files_where_it_tells_one():
    T_object_marker = Pose.from_xyz_rpy((0.1, -0.2, 0.05), (0.3, 0.2, -1.0))
    T_camera_marker = Pose(rotation_from_rotvec([0, 0, 0.7]) @ FACING, (0.2, 0.1, 1.5))
    found = placed(seen(T_camera_marker, small=1e-3), of=target(T_object_marker))
    expected = T_camera_marker @ T_object_marker.inverse()
    np.testing.assert_allclose(found.pose.position, expected.position, atol=2e-3)
    np.testing.assert_allclose(found.pose.rotation, expected.rotation, atol=2e-3)


def test_a_pose_that_is_known_stays():
    known = Detection("robot", 0, 0.9, ImagePose(1, 2, 3, 4), (), Pose.identity(), pose_covariance=np.eye(6))
    assert placed(known) is known


@pytest.mark.parametrize("place", [(0.0, 0.0, 1.2), (0.5, 0.3, 1.2)])
@pytest.mark.parametrize("arm", [(0.0, 0.0, 0.0), (0.15, 0.1, -0.05)])
def test_the_covariance_holds_what_tilt_and_edges_make_of_it(place, arm):
    """Tilts from a cone of 35 degrees, edges by half a pixel: errors are as large as is said, in all six directions."""
    rng = np.random.default_rng(1)
    of = target(Pose(np.eye(3), np.array(arm)))
    radius_m = 2 * (m := of.model.required.markers[0]).area / m.perimeter
    errors, squares = [], []
    for _ in range(400):
        tilt, about, turn = np.radians(35) * np.sqrt(rng.uniform()), *rng.uniform(-np.pi, np.pi, 2)
        R = rotation_from_rotvec(tilt * np.array([np.cos(about), np.sin(about), 0]))
        truth = Pose(R @ rotation_from_rotvec([0, 0, turn]) @ FACING, place)
        d = seen(truth, EVEN, small=1e-3, by_axis=False)
        shown = d.components[0]
        scale = shown.scale * (1 + rng.normal(0, 0.5) / (radius_m * shown.scale))
        noisy = Instance("team", "flag", 0.9, *(rng.normal(0, 0.5, 2) + (shown.x, shown.y)), shown.theta, scale)
        found = placed(Detection("robot", 0, 0.9, ImagePose(0, 0, 0, 1), (noisy,)), EVEN, of=of)
        origin = truth @ of.model.required.markers[0].T_component_marker.inverse()
        turned = rotation_vector(origin.rotation @ found.pose.rotation.T)
        error = np.concatenate([origin.position - found.pose.position, turned])
        errors.append(error / np.sqrt(np.diag(found.pose_covariance)))
        squares.append(error @ np.linalg.solve(found.pose_covariance, error))
        assert np.linalg.eigvalsh(found.pose_covariance).min() > 0
    assert np.all(np.sqrt(np.mean(np.square(errors), axis=0)) < 1.3)
    assert np.all(np.sqrt(np.mean(np.square(errors), axis=0))[[0, 1, 3, 4]] > 0.4)
    assert 2.0 < np.mean(squares) < 9.0  # six on average, were all of it Gaussian


def rotation_vector(R):
    angle = np.arccos(np.clip((np.trace(R) - 1) / 2, -1, 1))
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    return axis * (0.5 if angle < 1e-9 else angle / (2 * np.sin(angle)))


def test_small_markers_are_less_sure_and_tilt_grows_with_the_slant_that_is_allowed():
    near, far = (placed(seen(Pose(FACING, (0.0, 0.0, z)))) for z in (0.5, 3.0))
    share = [np.sqrt(d.pose_covariance[2, 2]) / d.pose.position[2] for d in (near, far)]
    assert share[0] < 0.08 and share[1] > 1.5 * share[0]
    slanted = placed(seen(Pose(FACING, (0.0, 0.0, 0.5))), max_slant_deg=60.0)
    assert slanted.pose_covariance[3, 3] == pytest.approx(np.radians(30) ** 2)
    assert near.pose_covariance[3, 3] == pytest.approx(np.radians(17.5) ** 2)


def test_a_segmenters_seam_is_added_to_the_outline():
    """A square of the class on a ground of another one, with a gap of two pixels around it."""
    labels = np.full(SIZE[::-1], 5, np.uint8)
    labels[198:242, 298:342] = 0
    labels[200:240, 300:340] = LABEL
    truth = seen(Pose(FACING, (0.0, 0.0, 1.0)))
    with_seam, without = (placed(truth, labels=image).pose.position[2] for image in (labels, None))
    flag = target().model.required.markers[0]
    radius_px = 2 * flag.area / flag.perimeter * truth.components[0].scale
    assert without / with_seam == pytest.approx(1 + 1 / radius_px, rel=1e-6)
