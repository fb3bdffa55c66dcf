"""Which way an object takes, what is flat, and the camera that all that is flat faces."""

import dataclasses
from itertools import product

import numpy as np
import pytest
from settings import settings
from solids import RED, sign, slide, truck
from squares import ARM, BACK, TEAM, gate, hinge, patch, robot

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.ways import FACING, PAPER, PLANE, SPACE, of_way, way_of


def without_places(model):
    parts = tuple(
        dataclasses.replace(c, markers=tuple(dataclasses.replace(m, T_component_marker=None) for m in c.markers))
        for c in model.components
    )
    return dataclasses.replace(model, components=parts)


def pair(T=None, joint=None):
    """A plate, and a bar at a place or on a joint."""
    base = Component("base", (patch("back", BACK),), required=True)
    return ObjectModel("pair", (base, Component("bar", (patch("arm", ARM, T),), label=7, joint=joint)))


Z, X = (0.0, 0.0, 1.0), (1.0, 0.0, 0.0)
FLAT = {
    "robot": robot(),
    "hinge": gate(),
    "one marker": sign(),
    "higher": pair(Pose(np.eye(3), np.array([0.1, 0, 0.05]))),
    "turned": pair(Pose.from_xyz_rpy((0.1, 0, 0), (0, 0, 1.0))),
    "hardly tilted": pair(Pose.from_xyz_rpy((0.1, 0, 0), (0.03, 0, 0))),
    "backwards axis": pair(joint=hinge("base", (0.1, 0, 0), (0, 0, -1.0))),
    "slides across": pair(joint=hinge("base", (0.1, 0, 0), X, "prismatic", (0.0, 0.1))),
    "fixed": pair(joint=hinge("base", (0.1, 0, 0), X, "fixed", (0.0, 0.0))),
}
NOT_FLAT = {
    "truck": truck(),
    "no places": without_places(robot()),
    "tilted": pair(Pose.from_xyz_rpy((0.1, 0, 0), (0.1, 0, 0))),
    "other side": pair(Pose.from_xyz_rpy((0.1, 0, 0), (np.pi, 0, 0))),
    "hinge in the plane": pair(joint=hinge("base", (0.1, 0, 0), X)),
    "slides out": pair(joint=hinge("base", (0.1, 0, 0), Z, "prismatic", (0.0, 0.1))),
}


def test_flat_is_what_nothing_turns_out_of_one_plane():
    assert {name: model.is_flat for name, model in FLAT.items()} == dict.fromkeys(FLAT, True)
    assert {name: model.is_flat for name, model in NOT_FLAT.items()} == dict.fromkeys(NOT_FLAT, False)
    assert slide().is_flat  # along its plate


@pytest.mark.parametrize("rotvec", [(0.4, -1.0, 2.0), (np.pi, 0, 0), (0, np.pi / 2, 0)])
def test_flatness_is_the_same_in_any_frame_of_the_object(rotvec):
    T = Pose(rotation_from_rotvec(rotvec), np.array([0.3, -0.2, 0.1]))
    for model, flat in [(m, True) for m in FLAT.values()] + [(m, False) for m in NOT_FLAT.values() if m.is_spatial]:
        parts = tuple(
            dataclasses.replace(c, joint=dataclasses.replace(c.joint, T_parent_joint=T @ c.joint.T_parent_joint))
            if c.joint is not None and model.component(c.joint.parent).joint is None
            else c
            if c.joint is not None
            else dataclasses.replace(
                c, markers=tuple(dataclasses.replace(m, T_component_marker=T @ m.T_component_marker) for m in c.markers)
            )
            for c in model.components
        )
        assert dataclasses.replace(model, components=parts).is_flat == flat, model.name


def target(model):
    return Target(model.name, model, TEAM)


@pytest.mark.parametrize(("whole", "calibrated"), list(product([True, False], repeat=2)))
def test_ways(whole, calibrated):
    config, paper = settings(whole_object=whole), settings(whole_object=whole, profile="paper")
    cases = {"flat": (robot(), FACING), "solid": (truck(), PLANE), "without places": (without_places(robot()), PLANE)}
    for name, (model, bare) in cases.items():
        way = way_of(target(model), config, calibrated=calibrated)
        if not whole or name == "without places":
            assert way == PLANE
        else:
            assert way == (SPACE if calibrated else bare)
        assert way_of(target(model), paper, calibrated=calibrated) == PAPER


def test_each_target_takes_one_way():
    targets = [Target(f"t{n}", m, RED) for n, m in enumerate((robot(), truck(), sign(), without_places(sign())))]
    for calibrated in (True, False):
        taken = {w: of_way(w, targets, settings(), calibrated=calibrated) for w in (PAPER, PLANE, FACING, SPACE)}
        assert sorted(t.name for some in taken.values() for t in some) == ["t0", "t1", "t2", "t3"]
    assert [t.name for t in of_way(FACING, targets, settings(), calibrated=False)] == ["t0", "t2"]


@pytest.mark.parametrize("size", [(640, 480), (60, 200), (1, 1)])
def test_what_faces_the_camera_is_a_similarity_of_the_image(size):
    """A figure before it, turned about the optical axis, anywhere in view: the scale is that of f / depth."""
    camera, rng = Camera.facing(size), np.random.default_rng(1)
    assert camera.size == size and not camera.bent
    figure = rng.uniform(-0.2, 0.2, (20, 2))
    for _ in range(5):
        k, theta = rng.uniform(50, 900), rng.uniform(-np.pi, np.pi)
        at = rng.uniform(0, size)
        c, s, depth = np.cos(theta), np.sin(theta), camera.focal_px / k
        R = np.array([[c, -s], [s, c]])
        xy = (at - camera.matrix[:2, 2]) * depth / camera.focal_px
        X = np.column_stack([figure @ R.T + xy, np.full(len(figure), depth)])
        np.testing.assert_allclose(project(camera, X), at + k * figure @ R.T, atol=1e-6)


def test_all_lines_of_sight_are_nearly_one():
    camera = Camera.facing((640, 480))
    corner = np.array([*camera.matrix[:2, 2], camera.focal_px])
    assert np.degrees(np.arctan2(np.hypot(*corner[:2]), corner[2])) < 10.1
