import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.model.objects import Box
from artrec_ros.simulation.surfaces import box_faces, component_poses, object_surfaces


@pytest.mark.parametrize("q", [-0.5, 0.0, 0.3, 1.0])
def test_a_joint_about_y_swings_the_arm_forward_for_negative_angles(model, q):
    T = component_poses(model, {"arm": q})["arm"]
    np.testing.assert_allclose(T.rotation @ (0, 0, -1), (-np.sin(q), 0, -np.cos(q)), atol=1e-12)
    np.testing.assert_allclose(T.position, (0, -0.06, 0))


def test_a_joint_that_is_not_named_is_at_zero(model):
    np.testing.assert_allclose(component_poses(model, {})["arm"].rotation, np.eye(3))


def test_box_faces_enclose_the_box():
    place = Pose(rotation_from_rotvec([0.3, -0.2, 0.9]), np.array([1.0, 2.0, 3.0]))
    faces = box_faces(Box(place, np.array([0.1, 0.2, 0.4])), 5)
    assert len(faces) == 6
    for face in faces:
        edges = np.roll(face.corners, -1, axis=0) - face.corners
        outward = np.cross(edges[0], edges[1])
        np.testing.assert_allclose(outward / np.linalg.norm(outward), face.normal, atol=1e-12)
        assert face.normal @ (face.corners.mean(axis=0) - place.position) > 0
    # divergence theorem: a third of the sum of (point . normal) area is the volume
    volume = 0.0
    for face in faces:
        sides = np.linalg.norm(face.corners[1] - face.corners[0]), np.linalg.norm(face.corners[2] - face.corners[1])
        volume += face.corners[0] @ face.normal * sides[0] * sides[1] / 3
    assert volume == pytest.approx(0.1 * 0.2 * 0.4)


def test_surfaces_bear_the_labels_of_object_component_and_body(model):
    labels = {s.owner: s.label for s in object_surfaces(model, 3, {})}
    assert labels == {("base", "front"): 3, ("arm", "side"): 7, None: 5}


def test_facing_is_the_cosine_to_the_camera(model):
    front = next(s for s in object_surfaces(model, 3, {}) if s.owner == ("base", "front"))
    turn = 0.4
    R = np.column_stack([[np.sin(turn), 0, -np.cos(turn)], [np.cos(turn), 0, np.sin(turn)], [0, -1, 0]])
    assert np.linalg.det(R) == pytest.approx(1)
    far = Pose(R, np.array([0, 0, 1000.0]))
    assert front.moved(far).facing == pytest.approx(np.cos(turn), abs=1e-4)
