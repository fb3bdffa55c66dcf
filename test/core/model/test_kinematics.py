"""Frames of components against composed poses, and the laws that joints obey."""

import numpy as np
import pytest
from solids import chain, random_poses, sign, truck

from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.model.kinematics import Kinematics
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel


def composed(model, base, q):
    """Component name -> its pose in the camera, one joint after another."""
    values = dict(zip([c.name for c in model.joint_components], q, strict=True))
    frames = {}
    for c in model.components:
        if c.joint is None:
            frames[c.name] = base
            continue
        frame = frames[c.joint.parent] @ c.joint.T_parent_joint
        if c.joint.kind == "revolute":
            frame = frame @ Pose(rotation_from_rotvec(c.joint.axis * values[c.name]), np.zeros(3))
        elif c.joint.kind == "prismatic":
            frame = frame @ Pose(np.eye(3), c.joint.axis * values[c.name])
        frames[c.name] = frame
    return frames


@pytest.mark.parametrize("model", [chain(), truck(), sign()], ids=lambda m: m.name)
def test_frames_are_composed_poses(model):
    poses = random_poses(np.random.default_rng(1), model, 6)
    frames = Kinematics(model).forward(poses.R, poses.t, poses.q)
    for h in range(len(poses)):
        truth = composed(model, Pose(poses.R[h], poses.t[h]), poses.q[h])
        for c, component in enumerate(model.components):
            np.testing.assert_allclose(frames.R[h, c], truth[component.name].rotation, atol=1e-12)
            np.testing.assert_allclose(frames.t[h, c], truth[component.name].position, atol=1e-12)


def test_joints_are_counted_in_the_models_order_without_the_fixed_ones():
    kin = Kinematics(chain())
    assert kin.n_joints == 3
    assert kin.joint_of == [-1, 0, 1, -1, 2]
    assert kin.parent == [-1, 0, 1, 2, 3]
    assert kin.revolute.tolist() == [True, False, True]
    assert kin.lower.tolist() == [-1.0, 0.0, -2.0] and kin.upper.tolist() == [0.5, 0.1, 2.0]


@pytest.mark.parametrize("model", [chain(), truck(), sign()], ids=lambda m: m.name)
def test_a_joint_moves_what_hangs_on_it_and_nothing_else(model):
    kin = Kinematics(model)
    rest = random_poses(np.random.default_rng(2), model, 1)
    before = kin.forward(rest.R, rest.t, rest.q)
    assert kin.moves.shape == (len(model.components), kin.n_joints)
    for j in range(kin.n_joints):
        q = rest.q.copy()
        q[0, j] += 0.05
        after = kin.forward(rest.R, rest.t, q)
        moved = [
            not (np.allclose(before.R[0, c], after.R[0, c]) and np.allclose(before.t[0, c], after.t[0, c]))
            for c in range(len(model.components))
        ]
        assert moved == kin.moves[:, j].tolist()


def test_axes_and_origins_give_the_velocity_of_every_point():
    model = chain()
    kin = Kinematics(model)
    poses = random_poses(np.random.default_rng(3), model, 4)
    frames = kin.forward(poses.R, poses.t, poses.q)
    np.testing.assert_allclose(np.linalg.norm(frames.axis, axis=-1), 1.0)
    point, step = np.array([0.03, -0.02, 0.05]), 1e-6
    for j in range(kin.n_joints):
        ends = []
        for sign_of_step in (1, -1):
            q = poses.q.copy()
            q[:, j] += sign_of_step * step
            moved = kin.forward(poses.R, poses.t, q)
            ends.append(moved.R @ point + moved.t)  # (H, C, 3)
        numeric = (ends[0] - ends[1]) / (2 * step)
        arm = frames.R @ point + frames.t - frames.origin[:, j, None]
        axis = np.broadcast_to(frames.axis[:, j, None], arm.shape)
        velocity = np.cross(axis, arm) if kin.revolute[j] else axis
        np.testing.assert_allclose(numeric, velocity * kin.moves[:, j, None], atol=1e-8)


def test_the_whole_object_moves_as_one():
    model = chain()
    kin = Kinematics(model)
    poses = random_poses(np.random.default_rng(4), model, 3)
    at_origin = kin.forward(np.tile(np.eye(3), (3, 1, 1)), np.zeros((3, 3)), poses.q)
    placed = kin.forward(poses.R, poses.t, poses.q)
    np.testing.assert_allclose(placed.R, poses.R[:, None] @ at_origin.R, atol=1e-12)
    np.testing.assert_allclose(
        placed.origin, np.einsum("hij,hkj->hki", poses.R, at_origin.origin) + poses.t[:, None], atol=1e-12
    )


def test_no_hypotheses_give_no_frames_and_no_joint_needs_none():
    kin = Kinematics(chain())
    frames = kin.forward(np.zeros((0, 3, 3)), np.zeros((0, 3)), np.zeros((0, 3)))
    assert frames.R.shape == (0, 5, 3, 3) and frames.axis.shape == (0, 3, 3)
    frames = Kinematics(sign()).forward(np.eye(3)[None], np.ones((1, 3)), np.zeros((1, 0)))
    assert frames.axis.shape == (1, 0, 3)
    np.testing.assert_array_equal(frames.t, [[[1, 1, 1]]])


def test_components_without_a_joint_share_the_objects_frame():
    parts = tuple(Component(n, sign().components[0].markers, required=n == "a") for n in ("a", "b"))
    frames = Kinematics(ObjectModel("pair", parts)).forward(np.eye(3)[None], np.ones((1, 3)), np.zeros((1, 0)))
    np.testing.assert_array_equal(frames.t[0, 0], frames.t[0, 1])


def test_grids_run_from_limit_to_limit_in_steps_no_longer_than_asked():
    kin = Kinematics(chain())
    rows = kin.grids(0.1)
    assert len(rows) == kin.n_joints
    for j, row in enumerate(rows):
        grid = row[~np.isnan(row)]
        np.testing.assert_array_equal(grid, kin.grid(j, 0.1))
        assert grid[0] == kin.lower[j] and grid[-1] == kin.upper[j] and len(grid) >= 3
        assert np.diff(grid).max() <= 0.1 * kin.unit[j] + 1e-12
    assert Kinematics(sign()).grids(0.1).shape == (0, 0)


def test_a_joint_that_turns_more_than_once_is_looked_at_once_around():
    """As drives with two turns: half of all values would be others' places again."""
    square = np.array([[0, 0], [0.1, 0], [0.1, 0.1], [0, 0.1]])
    marker = Marker("m", square, np.zeros(2), np.array([0.1, 0]), None, Pose.identity())
    drive = Joint("a", Pose.identity(), np.array([0, 0, 1.0]), -2 * np.pi, 2 * np.pi)
    parts = (Component("a", (marker,), required=True), Component("b", (marker,), joint=drive))
    kin = Kinematics(ObjectModel("arm", parts))
    assert kin.endless.tolist() == [True] and np.ptp(kin.grid(0, 0.2)) == pytest.approx(2 * np.pi)
    turned = kin.bound(np.array([[-6.0], [-0.5], [3.0], [6.0]]))[:, 0]
    np.testing.assert_allclose(turned, [2 * np.pi - 6, -0.5, 3.0, 6 - 2 * np.pi])  # the turn in the middle is told
