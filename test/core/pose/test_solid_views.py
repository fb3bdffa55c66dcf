"""Boxes of one colour: sides that meet, seen together as one blob."""

from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS
from solids import BLUE, RED, camera_of, marker, render, turn_between

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.geometry.polygons import signed_area
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.model.surface import sample_polygon
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.headings import round_about
from artrec_ros.core.pose.pose_fit import contour_fit
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.solid_views import solids_of
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict.judge import Judge
from artrec_ros.io.objects.solids import box_solid, cylinder_solid

CAMERA = camera_of((640, 480), 600.0)
SIZE = np.array([0.16, 0.10, 0.05])
FROM_ABOVE = np.array([[0, 1, 0], [0.6, 0, -0.8], [-0.8, 0, -0.6]], float)  # shows a box's front and top


def brick(label=None, cab=None, **more):
    """A box of one colour, with a smaller one on it of another class."""
    box = Box(Pose.identity(), SIZE)
    parts = [Component("brick", box_solid(box)[0], required=True, bodies=(box,), body_label=label)]
    if cab is not None:
        top = Box(Pose.from_xyz_rpy((-0.03, 0, 0.0501)), np.array([0.06, 0.08, 0.05]))
        parts.append(Component("cab", box_solid(top)[0], label=cab, bodies=(top,), **more))
    return ObjectModel("brick", tuple(parts))


def at(turn=(0.0, 0.0, 0.0), t=(0.02, -0.03, 1.0)):
    """One hypothesis of the box from above its front, turned by a rotation vector in its own frame."""
    return Poses((FROM_ABOVE @ rotation_from_rotvec(turn))[None], np.array([t]), np.zeros((1, 0)))


def recognized(model, poses, **options):
    config = RecognizerConfig(time_budget_ms=60000.0, **options)
    labels = render(CAMERA, [(model, p, RED) for p in poses])
    return Recognizer([Target("brick", model, RED)], config, Segmenter(ImageConfig())).recognize(labels, CAMERA)


def test_a_view_shows_as_much_as_its_sides_turn_to_it():
    surface = SpatialModel(brick(), RED, DEFAULTS.votes)
    (solid,) = solids_of(surface, 0, DEFAULTS.guesses)
    sides = SIZE.prod() / SIZE
    shown = np.abs(solid.flips[0, :, 2]) @ sides  # the third row is the line of sight
    areas = np.array([abs(signed_area(v.outline)) for v in solid.views])
    assert len(solid.views) > 0.8 * DEFAULTS.guesses.solid_directions
    np.testing.assert_allclose(areas, shown, rtol=0.04)
    np.testing.assert_allclose(solid.centre, 0.0, atol=1e-9)


def test_what_is_rigid_to_it_lies_before_it_in_its_views():
    plain = SpatialModel(brick(), RED, DEFAULTS.votes)
    topped = SpatialModel(brick(cab=BLUE), RED, DEFAULTS.votes)
    same = SpatialModel(brick(cab=RED), RED, DEFAULTS.votes)
    total = [sum(v.area for v in solids_of(surface, 0, DEFAULTS.guesses)[0].views) for surface in (topped, plain, same)]
    assert total[0] < 0.97 * total[1] < total[1] < 0.97 * total[2]


def test_what_a_joint_moves_lies_nowhere_in_its_views():
    joint = Joint("brick", Pose.from_xyz_rpy((-0.03, 0, 0.0501)), np.array([0.0, 0, 1]), -1.0, 1.0)
    plain, moved = (SpatialModel(model, RED, DEFAULTS.votes) for model in (brick(), brick(cab=BLUE, joint=joint)))
    areas = [[v.area for v in solids_of(surface, 0, DEFAULTS.guesses)[0].views] for surface in (plain, moved)]
    np.testing.assert_array_equal(*areas)


def test_sides_that_do_not_meet_are_none_of_it():
    box, apart = Box(Pose.identity(), SIZE), Box(Pose.identity(), SIZE * 0.8)
    small = [
        marker(m.name, m.outline * 0.8, m.T_component_marker.rotation, full.T_component_marker.position)
        for m, full in zip(box_solid(apart)[0], box_solid(box)[0], strict=True)
    ]
    model = ObjectModel("brick", (Component("brick", tuple(small), required=True, bodies=(box,)),))
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    assert not solids_of(surface, 0, DEFAULTS.guesses) and (surface.meeting < 0).all()


def test_where_two_sides_in_view_meet_is_no_edge():
    """Seen from above the front, the edge between front and top has no say; seen from the front alone all four have."""
    model = brick()
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    names = [surface.patches[p].marker.name for p in surface.markers]
    front, top = names.index("front"), names.index("top")
    for turn, inner in (((0.0, 0.0, 0.0), True), ((0.0, -np.arccos(0.8), 0.0), False)):
        pose = at(turn)
        seen = ImageFrame(LabelField(render(CAMERA, [(model, pose, RED)])), CAMERA)
        use = np.zeros((1, len(names)), bool)
        use[0, front] = True
        fit = contour_fit(surface, seen, pose, use, 3, DEFAULTS.fit)
        meets_top = surface.meeting[front] == top
        assert meets_top.sum() >= 5
        assert (fit.weight[0, 0, meets_top] > 0).any() != inner
        assert (fit.weight[0, 0, surface.meeting[front] == names.index("bottom")] > 0).mean() > 0.8


@pytest.mark.parametrize("label", [None, RED])
def test_a_box_of_one_colour_is_found_as_it_lies(label):
    """Where two and three of its sides are seen; its body's class is its own, or not told."""
    turns = [(0.0, 0.0, 0.7), (0.0, 0.0, 1.2), (0.3, 0.2, -0.5), (0.0, 0.0, 0.0)]
    for turn in turns:
        pose = at(turn)
        (one,) = recognized(brick(label), [pose]).detections
        assert np.linalg.norm(one.pose.position - pose.t[0]) < 0.012
        halves = [pose.R[0] @ rotation_from_rotvec(np.pi * axis) for axis in (np.zeros(3), *np.eye(3))]
        assert min(turn_between(one.pose.rotation, half) for half in halves) < np.radians(3)


def test_which_end_it_is_another_class_tells():
    """The box alone looks the same after half a turn; with the cab on it it does not."""
    for heading in np.linspace(-3, 3, 9):
        pose = at((0.0, 0.0, heading))
        (one,) = recognized(brick(cab=BLUE), [pose]).detections
        assert turn_between(one.pose.rotation, pose.R[0]) < np.radians(3)
        assert {c.component for c in one.components} == {"brick", "cab"}


def test_a_covered_body_of_no_class_is_no_seam():
    (whole,) = brick().components
    open_below = ObjectModel("brick", (replace(whole, markers=whole.markers[:5]),))
    assert not Target("brick", brick(), RED).on_bodies
    assert Target("brick", open_below, RED).on_bodies == {RED}
    placeless = replace(whole, markers=tuple(replace(m, T_component_marker=None) for m in whole.markers))
    assert Target("brick", ObjectModel("brick", (placeless,)), RED).on_bodies == {RED}  # nobody knows what covers it


def test_a_cylinder_of_one_colour_is_found_as_it_lies():
    """The pictures are of a rounder one."""
    round_one = [cylinder_solid(0.04, 0.12, Pose.from_xyz_rpy((0, 0, 0), (0, 0, turn))) for turn in (0.0, 0.1309)]
    markers = [replace(m, name=f"{m.name}_{n}") for n, (markers, _) in enumerate(round_one) for m in markers]
    shown = ObjectModel("can", (Component("can", tuple(markers), required=True),))
    markers, bodies = cylinder_solid(0.04, 0.12, Pose.identity())
    model = ObjectModel("can", (Component("can", markers, required=True, bodies=bodies),))
    for turn in ((0.0, 0.0, 0.4), (0.5, 0.0, 0.2), (0.0, 0.4, 0.0)):
        labels, pose = render(CAMERA, [(shown, at(turn), RED)]), at(turn)
        config = RecognizerConfig(time_budget_ms=60000.0)
        (one,) = (
            Recognizer([Target("can", model, RED)], config, Segmenter(ImageConfig()))
            .recognize(labels, CAMERA)
            .detections
        )
        assert np.linalg.norm(one.pose.position - pose.t[0]) < 0.02
        assert abs(one.pose.rotation[:, 2] @ pose.R[0, :, 2]) > np.cos(np.radians(4))


def test_slivers_of_a_box_are_its_own():
    """A side that is seen at 86 degrees has no say alone; beside the next one it is what that one does not cover."""
    cube = Box(Pose.identity(), np.full(3, 0.1))
    sides = box_solid(cube)[0]
    lean = np.array([[1, 0, 0], [0, -1, 0], [0, 0, -1]], float) @ rotation_from_rotvec((0.16, 0.0, 0.0))
    pose = Poses(lean[None], np.array([[0.0, 0.0, 0.6]]), np.zeros((1, 0)))

    def seen_px(*markers):
        model = ObjectModel("cube", (Component("cube", markers, required=True, bodies=(cube,), body_label=RED),))
        frame = ImageFrame(LabelField(render(CAMERA, [(model, pose, RED)])), CAMERA)
        surface = SpatialModel(model, RED, DEFAULTS.votes)
        scores = surface.score(frame, pose, surface.markers, occlusion=False)
        return {m.name: px for m, px in zip(markers, scores.area_px[0].tolist(), strict=True) if px > 0}

    whole = seen_px(*sides)
    assert len(whole) == 2 and 100 < min(whole.values()) < 0.15 * max(whole.values())
    (sliver,) = (m for m in sides if m.name == min(whole, key=whole.__getitem__))
    assert not seen_px(sliver)


@pytest.mark.parametrize("heading", [0.0, 0.9, 2.0, -2.3, -1.2])
def test_which_way_a_round_foot_lies_what_stands_on_it_tells(heading):
    """In all directions about its axis its outline is the same."""
    markers, bodies = cylinder_solid(0.07, 0.03, Pose.identity())
    arm = Box(Pose.from_xyz_rpy((0, 0, 0.095)), np.array([0.02, 0.03, 0.18]))
    hinge = Joint("foot", Pose.from_xyz_rpy((0.03, 0, 0.015)), np.array([0.0, 1.0, 0.0]), -0.9, 0.9)
    foot = Component("foot", markers, required=True, bodies=bodies)
    lamp = ObjectModel("lamp", (foot, Component("arm", box_solid(arm)[0], label=BLUE, joint=hinge, bodies=(arm,))))
    pose = Poses(
        (FROM_ABOVE @ rotation_from_rotvec((0, 0, heading)))[None], np.array([[0, 0.05, 1.0]]), np.array([[0.5]])
    )
    config = RecognizerConfig(time_budget_ms=60000.0)
    labels = render(CAMERA, [(lamp, pose, RED)])
    (one,) = (
        Recognizer([Target("lamp", lamp, RED)], config, Segmenter(ImageConfig())).recognize(labels, CAMERA).detections
    )
    assert turn_between(one.pose.rotation, pose.R[0]) < np.radians(8)
    assert one.joints["arm"] == pytest.approx(0.5, abs=0.1)


def test_what_is_round_is_turned_about_its_axis():
    """Of an object that has more; of a box there is nothing to turn."""
    at = Pose.from_xyz_rpy((0.1, 0.0, 0.02), (np.pi / 2, 0.0, 0.0))
    markers, bodies = cylinder_solid(0.05, 0.03, at)
    foot = Component("foot", markers, required=True, bodies=bodies)
    box = Box(Pose.from_xyz_rpy((0.1, 0.1, 0.0)), np.array([0.02, 0.03, 0.1]))
    arm = Component("arm", box_solid(box)[0], label=BLUE, bodies=(box,))

    def surface(*components):
        return SpatialModel(ObjectModel("toy", components), RED, DEFAULTS.votes)

    axis, middle = round_about(surface(foot, arm))
    assert abs(axis[1]) == pytest.approx(1) and middle == pytest.approx(at.position, abs=1e-6)
    assert not round_about(surface(foot))
    assert not round_about(surface(replace(arm, required=True), replace(foot, required=False)))


@pytest.mark.parametrize(("radius", "length"), [(0.05, 0.2), (0.01, 0.3), (0.005, 0.3), (0.1, 0.005)])
def test_a_rod_is_one_solid_that_looks_as_large_as_it_is(radius, length):
    """However thin: what its body has inside does not cut it up."""
    markers, bodies = cylinder_solid(radius, length, Pose.identity())
    model = ObjectModel("rod", (Component("rod", markers, required=True, bodies=bodies),))
    (solid,) = solids_of(SpatialModel(model, RED, DEFAULTS.votes), 0, DEFAULTS.guesses)
    sine = np.hypot(*solid.flips[0, :, 2, :2].T)
    shadow = 2 * radius * length * sine + np.pi * radius**2 * np.abs(solid.flips[0, :, 2, 2])
    areas = np.array([v.area for v in solid.views])
    np.testing.assert_allclose(areas, shadow, rtol=0.15)


def test_sides_that_are_never_seen_together_are_no_solid():
    """Two stickers on a sharp wedge meet, and each turns away where the other faces."""
    half = np.radians(7)
    turns = [rotation_from_rotvec([0.0, s * (np.pi / 2 - half), 0.0]) for s in (1, -1)]
    sides = tuple(
        marker(f"side_{n}", [(-0.02, -0.02), (0.02, -0.02), (0.02, 0.02), (-0.02, 0.02)], R, R @ (-0.02 * s, 0, 0))
        for n, (R, s) in enumerate(zip(turns, (-1, 1), strict=True))
    )
    model = ObjectModel("wedge", (Component("wedge", sides, required=True),))
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    recognized(model, [at()])  # it is made ready all the same
    assert all(len(solid.views) for solid in solids_of(surface, 0, DEFAULTS.guesses))


def test_a_side_between_others_in_view_is_parted_by_them():
    """From above a frustum's sides are all in view around its top, which has no outline of its own then."""
    low, high, tall = 0.08, 0.06, 0.05
    slope = np.array([low - high, 0.0, tall]) / np.hypot(low - high, tall)
    side = [(-low, -0.5), (low, -0.5), (high, 0.5), (-high, 0.5)] * np.array([1.0, np.hypot(low - high, tall)])
    parts = [marker("top", [(-high, -high), (high, -high), (high, high), (-high, high)], np.eye(3), (0, 0, tall))]
    for k in range(4):
        up = slope * (-1, 1, 1)
        R = np.stack([(0, 1, 0), up, np.cross((0, 1, 0), up)], axis=1)
        turn = rotation_from_rotvec([0.0, 0.0, k * np.pi / 2])
        parts.append(marker(f"side_{k}", side, turn @ R, turn @ np.array([(low + high) / 2, 0, tall / 2])))
    model = ObjectModel("frustum", (Component("frustum", tuple(parts), required=True),))
    pose = Poses(np.diag([1.0, -1.0, -1.0])[None], np.array([[0.0, 0.0, 1.0]]), np.zeros((1, 0)))
    finder = WholeObjectFinder(Target("frustum", model, RED), RecognizerConfig())
    seen = ImageFrame(LabelField(render(CAMERA, [(model, pose, RED)])), CAMERA)
    (verdict,) = Judge.of(RecognizerConfig()).verdicts(finder, pose, seen)
    assert verdict.evidence.rim > 0.8 and verdict.evidence.parted > 0.9 and verdict.probability > 0.6


def test_slivers_are_sampled_as_soon_as_others():
    """A narrow strip lies slanted in its bounding box; a thin hook fills little of any."""
    turn = rotation_from_rotvec([0.0, 0.0, 0.7])[:2, :2]
    strip = np.array([(-1, -1), (1, -1), (1, 1), (-1, 1)]) * (0.1, 1e-6) @ turn.T
    inside = sample_polygon(strip, 100) @ turn
    assert len(inside) == 100 and np.abs(inside[:, 1]).max() <= 1.0001e-6 and np.ptp(inside[:, 0]) > 0.19
    hook = np.array([(0, 0), (1, 0), (1, 1), (0.995, 1), (0.995, 0.005), (0, 0.005)])
    assert len(sample_polygon(hook, 50)) == 50
    with pytest.raises(ConfigError, match="no inside"):
        sample_polygon(np.array([(0, 0), (1, 0), (2, 0), (1, 0)], float), 10)
