import dataclasses
import itertools

import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.extent import joints_at
from artrec_ros.simulation.motion import MotionConfig, moving_scenes
from artrec_ros.simulation.scene import depth_range, require_places, sample_scene

from .conftest import square


def scenes(target, camera, count=40, **config):
    rng = np.random.default_rng(5)
    return [sample_scene([target], camera, SceneConfig(**config), rng) for _ in range(count)]


def test_objects_are_wholly_in_view(target, camera):
    for scene in scenes(target, camera):
        (placed,) = scene.objects
        corners = np.concatenate([s.corners for s in placed.surfaces()])
        pixels = project(camera, corners)
        assert (corners[:, 2] > 0).all()
        assert (pixels > -2).all() and (pixels < np.array(camera.size) + 1).all()


def test_joints_stay_within_their_limits_and_use_them(target, camera):
    angles = [s.objects[0].joints["arm"] for s in scenes(target, camera, 200)]
    assert -0.5 <= min(angles) < -0.3 and 0.8 < max(angles) <= 1.0


def test_a_joint_range_of_zero_keeps_joints_in_the_middle(target, camera):
    assert all(s.objects[0].joints["arm"] == pytest.approx(0.25) for s in scenes(target, camera, 5, joint_range=0.0))


@pytest.mark.parametrize("share", [0.0, 1.0])
def test_objects_turn_their_front_to_the_camera_as_often_as_asked(target, camera, share):
    """The front faces the camera by chance in a third of all headings."""
    seen = 0
    for scene in scenes(target, camera, facing=share):
        (front,) = (s for s in scene.objects[0].surfaces() if s.owner == ("base", "front"))
        seen += front.facing > 0.5
    assert seen == 40 if share else 4 < seen < 26


def test_objects_keep_apart_and_number_as_asked(target, camera):
    found = scenes(target, camera, objects=(2, 3), size=(0.1, 0.2))
    assert {len(s.objects) for s in found} == {2, 3}
    for scene in found:
        places = np.array([p.T_camera_object.position for p in scene.objects])
        gaps = np.linalg.norm(places[:, None] - places, axis=2)[np.triu_indices(len(places), 1)]
        assert gaps.min() > 0.15


def test_apparent_size_is_as_asked(target, camera):
    near, far = depth_range(0.1, camera, SceneConfig(size=(0.2, 0.5)))
    assert camera.matrix[0, 0] * 0.2 / near == pytest.approx(0.5 * camera.size[0])
    assert camera.matrix[0, 0] * 0.2 / far == pytest.approx(0.2 * camera.size[0])


def moved_origin(model, by):
    """The same object with its frame's origin elsewhere."""
    base, arm = model.components
    shift = Pose(np.eye(3), -np.asarray(by, float))
    marker = base.markers[0]
    body = base.bodies[0]
    base = dataclasses.replace(
        base,
        markers=(dataclasses.replace(marker, T_component_marker=shift @ marker.T_component_marker),),
        bodies=(dataclasses.replace(body, T_component_box=shift @ body.T_component_box),),
    )
    joint = dataclasses.replace(arm.joint, T_parent_joint=shift @ arm.joint.T_parent_joint)
    return ObjectModel("moved", (base, dataclasses.replace(arm, joint=joint)))


def test_where_the_origin_lies_on_an_object_makes_no_difference_to_its_apparent_size(target, camera):
    elsewhere = dataclasses.replace(target, model=moved_origin(target.model, [0.4, -0.1, 0.2]))
    widths = []
    for seen in (target, elsewhere):
        corners = [
            np.concatenate([s.corners for s in scene.objects[0].surfaces()])
            for scene in scenes(seen, camera, 30, size=(0.5, 0.5), tilt_rad=0.0, elevation_deg=(5.0, 15.0))
        ]
        pixels = [project(camera, c) for c in corners]
        assert all((p > -2).all() and (p < np.array(camera.size) + 1).all() for p in pixels)
        widths.append([np.linalg.norm(p[:, None] - p, axis=2).max() / camera.size[0] for p in pixels])
    assert np.median(widths[1]) == pytest.approx(np.median(widths[0]), rel=0.1)
    assert 0.35 < np.median(widths[1]) < 0.6, "the apparent diameter that was asked for, seen from some side"


@pytest.mark.parametrize(
    ("kind", "limits", "span"),
    [
        ("revolute", (2.24, 4.04), (2.24, 4.04)),
        ("revolute", (-5.0, -3.5), (-5.0, -3.5)),
        ("prismatic", (4.0, 9.0), (4.0, 9.0)),
        ("revolute", (-np.pi, np.pi), (-np.pi, np.pi)),
        ("revolute", (-20.0, 20.0), (-np.pi, np.pi)),
    ],
)
def test_limits_are_kept_wherever_they_lie(target, camera, kind, limits, span):
    """A joint that turns round and round is seen all round once, at the angles that are recognised."""
    base, arm = target.model.components
    joint = dataclasses.replace(arm.joint, kind=kind, lower=limits[0], upper=limits[1])
    model = ObjectModel("pump", (base, dataclasses.replace(arm, joint=joint)))
    assert [joints_at(model, end)["arm"] for end in (-1.0, 1.0)] == pytest.approx(span)
    still = sample_scene([Target("pump", model, 3)], camera, SceneConfig(), np.random.default_rng(0))
    moving = itertools.islice(moving_scenes(still, MotionConfig(swing_hz=1.0), np.random.default_rng(1)), 30)
    seen = [placed.joints["arm"] for scene in moving for placed in scene.objects]
    assert span[0] - 1e-9 <= min(seen) and max(seen) <= span[1] + 1e-9 and np.ptp(seen) > 0.9 * (span[1] - span[0])


def test_upright_objects_are_seen_from_the_side_and_flat_ones_from_above(target, camera):
    flat = ObjectModel("flat", (Component("base", (square(0.1, "top", Pose.identity()),), required=True),))
    for seen, low, high in ((target, -0.05, 0.5), (Target("flat", flat, 2), 0.85, 1.01)):
        for scene in scenes(seen, camera, 10, tilt_rad=0.0):
            assert low < -scene.objects[0].T_camera_object.rotation[2, 2] < high  # sine of the camera's elevation


def test_things_stand_on_the_floor(target, camera):
    for scene in scenes(target, camera, 10, tilt_rad=0.0, joint_range=0.0):
        corners = np.concatenate([s.corners for s in scene.objects[0].surfaces()])
        height = corners @ scene.floor.normal - scene.floor.offset
        assert height.min() == pytest.approx(0, abs=1e-9)


def test_what_is_tilted_does_not_sink_into_the_floor(camera):
    flat = ObjectModel("flat", (Component("base", (square(0.1, "top", Pose.identity()),), required=True),))
    for scene in scenes(Target("flat", flat, 2), camera, 20, tilt_rad=0.1):
        corners = np.concatenate([s.corners for s in scene.objects[0].surfaces()])
        assert (corners @ scene.floor.normal - scene.floor.offset).min() == pytest.approx(0, abs=1e-9)


@pytest.mark.parametrize("tilt_rad", [0.0, 0.04])
def test_no_joint_takes_an_object_through_the_floor(camera, tilt_rad):
    knee = Joint("thigh", Pose(np.eye(3), np.array([0.1, 0.0, 0.0])), (0.0, 1.0, 0.0), -0.5, 1.2)
    hip = Joint("trunk", Pose(np.eye(3), np.array([0.1, 0.0, 0.0])), (0.0, 1.0, 0.0), -0.5, 0.5)
    long = square(0.1, "top", Pose(np.eye(3), np.array([0.05, 0.0, 0.01])))
    trunk = Component("trunk", (square(0.1, "top", Pose.identity()),), required=True)
    leg = ObjectModel("leg", (trunk, Component("thigh", (long,), joint=hip), Component("shin", (long,), joint=knee)))
    lowest = []
    for scene in scenes(Target("leg", leg, 2), camera, 60, tilt_rad=tilt_rad):
        corners = np.concatenate([s.corners for s in scene.objects[0].surfaces()])
        lowest.append((corners @ scene.floor.normal - scene.floor.offset).min())
    assert min(lowest) > -1e-9 and min(lowest) < 0.03 < max(lowest)


def test_no_floor_where_none_is_asked(target, camera):
    assert all(s.floor is None for s in scenes(target, camera, 5, floor_label=0))


def test_distractors_bear_colours_of_the_objects(target, camera):
    labels = {d.label for s in scenes(target, camera, distractors=5) for d in s.distractors}
    assert labels == {3, 5, 7}
    assert not any(s.distractors for s in scenes(target, camera, 5, distractors=0))


def test_a_marker_without_a_place_is_refused():
    model = ObjectModel("loose", (Component("base", (square(0.1),), required=True),))
    with pytest.raises(ConfigError, match="marker 'patch' of component 'base' has no pose"):
        require_places(model)


@pytest.mark.parametrize(
    "bad", [{"objects": (3, 1)}, {"size": (0.0, 0.5)}, {"margin": -1.0}, {"elevation_deg": (3.0,)}]
)
def test_bad_values_are_refused_by_name(bad):
    with pytest.raises(ConfigError, match=f"scene.{next(iter(bad))}"):
        SceneConfig(**bad)


def test_the_sensor_scales_to_ideal():
    assert SensorConfig().scaled(0).is_ideal and not SensorConfig().is_ideal
    assert SensorConfig().scaled(1) == dataclasses.replace(SensorConfig())
    with pytest.raises(ConfigError, match="sensor."):
        SensorConfig().scaled(-1)


def test_joints_go_by_their_own_names_wherever_they_are_told(target, camera, tmp_path):
    base, arm = target.model.components
    arm = dataclasses.replace(arm, joint=dataclasses.replace(arm.joint, name="shoulder"))
    named = Target("pump", ObjectModel("pump", (base, arm)), 3)
    rng = np.random.default_rng(0)
    scene = sample_scene([named], camera, SceneConfig(), rng)
    assert set(scene.objects[0].joints) == {"shoulder"}
    first, later = (next(itertools.islice(moving_scenes(scene, MotionConfig(), rng), n, None)) for n in (0, 20))
    at_rest = sample_scene([target], camera, SceneConfig(), np.random.default_rng(0))
    assert first.objects[0].joints["shoulder"] == pytest.approx(at_rest.objects[0].joints["arm"])
    assert set(later.objects[0].joints) == {"shoulder"} and later.objects[0].joints != first.objects[0].joints
    for a, b in zip(scene.objects[0].surfaces(), at_rest.objects[0].surfaces(), strict=True):
        np.testing.assert_allclose(a.corners, b.corners)
    with pytest.raises(ConfigError, match="two joints have the same name"):
        ObjectModel("pump", (base, arm, dataclasses.replace(arm, name="other")))


def of_two_colours(unique):
    """A square whose other square is red or blue, both face up."""
    place = Pose(np.eye(3), np.array([0.0, 0.0, 0.01]))
    team = Component("team", (square(0.04, place=place),), required=True)
    accent = Component("accent", (square(0.04, place=place),), classes={"red": 3, "blue": 4})
    return Target("robot", ObjectModel("robot", (team, accent), unique=unique), 2)


def test_each_object_shows_the_classes_of_one_identity(camera):
    shown = set()
    for scene in scenes(of_two_colours(unique=False), camera, objects=(3, 3), size=(0.1, 0.15)):
        for placed in scene.objects:
            labels = {s.owner[0]: s.label for s in placed.surfaces() if s.owner is not None}
            assert labels == {"team": 2, "accent": {"red": 3, "blue": 4}[placed.identity]}
            shown.add(placed.identity)
    assert shown == {"red", "blue"}


def test_unique_objects_are_there_once(camera):
    found = scenes(of_two_colours(unique=True), camera, objects=(3, 3), size=(0.1, 0.15))
    counts = [sorted(p.identity for p in scene.objects) for scene in found]
    assert ["blue", "red"] in counts and all(len(set(names)) == len(names) <= 2 for names in counts)


def test_what_belongs_to_nothing_has_any_of_the_classes(camera):
    found = scenes(of_two_colours(unique=True), camera, objects=(1, 1), distractors=5)
    assert {s.label for scene in found for s in scene.distractors} == {2, 3, 4}
