"""Poses in which an object looks much like itself."""

import numpy as np
import pytest
from grids import PITCH, TOWARDS, at, centres, covered, grid
from settings import DEFAULTS
from solids import (
    BACKGROUND,
    CAB,
    FRONT,
    LEFT_SIDE,
    RED,
    RIGHT_SIDE,
    camera_of,
    marker,
    rectangle,
    render,
    truck,
    turn_between,
)

from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.lookalikes import Lookalikes, turns_alike
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.io.objects.solids import ball_solid

CAMERA = camera_of()


def surface_of(model):
    return SpatialModel(model, RED, DEFAULTS.votes)


def test_a_grids_lookalikes_are_all_its_poses_that_share_a_third_of_its_places_and_not_all():
    model = grid()
    one, lookalikes = at(0.1, -0.05, 1.2, 0.3, 0.4), Lookalikes(surface_of(model))
    poses = lookalikes.of(one)
    assert len(poses) == len(lookalikes) > 20
    shared = [covered(centres(model, poses, h), centres(model, one)) for h in range(len(poses))]
    assert min(shared) >= 4 and max(shared) == 9
    assert shared == sorted(shared, reverse=True)
    np.testing.assert_allclose(poses.R @ poses.R.transpose(0, 2, 1), np.tile(np.eye(3), (len(poses), 1, 1)), atol=1e-9)
    np.testing.assert_allclose(poses.R[..., 2], np.tile(one.R[0, :, 2], (len(poses), 1)), atol=1e-9)  # in its plane
    quarter = [turn_between(R, one.R[0]) for R, n in zip(poses.R, shared, strict=True) if n == 9]
    assert any(abs(a - np.pi / 2) < 1e-6 for a in quarter) and any(a < 1e-6 for a in quarter)


def test_discs_are_turned_so_that_others_meet():
    angles = 2 * np.pi * np.arange(32) / 32
    disc = 0.025 * np.column_stack([np.cos(angles), np.sin(angles)])
    model = grid(outline=disc, radius=0.025)
    one = at(turn=0.2)
    poses = Lookalikes(surface_of(model)).of(one)
    shared = [covered(np.round(centres(model, poses, h), 9), centres(model, one)) for h in range(len(poses))]
    assert len(poses) > 20 and any(abs(turn_between(R, one.R[0]) - np.pi / 2) < 0.06 for R in poses.R)
    assert max(shared) < 12


@pytest.mark.parametrize("model", [truck(), grid(1, 1, (0, 0), rectangle(0.05, 0.03))], ids=["truck", "one of all"])
def test_what_is_unlike_all_else_has_none(model):
    assert len(Lookalikes(surface_of(model))) == 0


def test_a_jointed_objects_required_component_is_put_on_each_that_it_is_like():
    """A chain of three equal links: joints as they are."""
    bar = rectangle(0.08, 0.02, (0.05, 0))
    joint = [Joint(p, at_end(), np.array([0.0, 0.0, 1.0]), -1.0, 1.0) for p in ("a", "b")]
    links = [
        Component(n, (marker("m", bar, np.eye(3), (0, 0, 0)),), required=n == "a", joint=j)
        for n, j in zip("abc", [None, *joint], strict=True)
    ]
    surface = surface_of(ObjectModel("chain", tuple(links)))
    one = Poses(TOWARDS[None], np.array([[0.0, 0.0, 1.0]]), np.array([[0.4, -0.3]]))
    poses = Lookalikes(surface).of(one)
    assert len(poses) == 5  # on each other link, both ways round, and the other way round where it is
    np.testing.assert_array_equal(poses.q, np.tile(one.q, (5, 1)))
    frames = surface.kinematics.forward(one.R, one.t, one.q)
    on_b = np.linalg.norm(poses.R - frames.R[0, 1], axis=(1, 2)) + np.linalg.norm(poses.t - frames.t[0, 1], axis=1)
    assert on_b.min() < 1e-6


@pytest.mark.parametrize(
    ("outline", "turns"),
    [(rectangle(0.05, 0.03), [np.pi]), (rectangle(0.05, 0.05), [np.pi / 2, np.pi, np.pi / 2]), (CAB, [])],
    ids=["a bar", "a square", "a cab"],
)
def test_a_marker_is_turned_onto_itself_in_each_turn_that_its_outline_does_not_tell(outline, turns):
    """Whatever is beside it: that tells which one it is, where the search has all of them."""
    tab = Component("tab", (marker("m", rectangle(0.01, 0.02), np.eye(3), (0.08, 0, 0)),))
    plate = Component("s", (marker("m", outline, np.eye(3), (0.01, 0, 0)),), required=True)
    model = ObjectModel("tabbed", (plate, tab))
    one = at(0.1, -0.05, 1.2, 0.3, 0.4)
    for lookalikes in (Lookalikes(surface_of(model), in_place=True), Lookalikes(surface_of(model))):
        poses = lookalikes.of(one)
        assert [turn_between(R, one.R[0]) for R in poses.R] == pytest.approx(turns, abs=1e-6)
        middle = model.required.markers[0].centre
        np.testing.assert_allclose(poses.R @ middle + poses.t, np.tile(one.R[0] @ middle + one.t[0], (len(turns), 1)))


def test_what_resembles_itself_in_one_turn_alone_is_not_turned_onto_itself():
    """A T, as on a robot's chest, is like itself in a turn by 240 degrees, to 8 %, and not in one by 120."""
    T = 0.005 * np.array([(-8, 6), (-8, 1), (-3, 1), (-3, -7), (3, -7), (3, 1), (8, 1), (8, 6)])
    model = ObjectModel("chest", (Component("s", (marker("m", T, np.eye(3), (0, 0, 0)),), required=True),))
    assert len(turns_alike(*model.required.markers * 2)) == 2 and not len(Lookalikes(surface_of(model), in_place=True))


@pytest.mark.parametrize("corners", [12, 32])
def test_what_is_round_is_turned_onto_itself_in_no_turn_be_it_a_disc_or_drawn(corners):
    angles = 2 * np.pi * np.arange(corners) / corners
    outline = 0.03 * np.column_stack([np.cos(angles), np.sin(angles)])
    plate = Component("s", (marker("m", outline, np.eye(3), (0, 0, 0)),), required=True)
    tab = Component("tab", (marker("m", rectangle(0.01, 0.02), np.eye(3), (0.08, 0, 0)),))
    surface = surface_of(ObjectModel("tabbed", (plate, tab)))
    assert not len(Lookalikes(surface, in_place=True)) and not len(Lookalikes(surface))


def test_like_markers_on_either_side_turn_an_object_about_one_axis_once():
    sides, bar = ((RIGHT_SIDE, (0, -0.05, 0)), (LEFT_SIDE, (0, 0.05, 0)), (FRONT, (0.05, 0, 0))), rectangle(0.06, 0.03)
    markers = tuple(marker(f"m{n}", bar, R, at) for n, (R, at) in enumerate(sides))
    surface = surface_of(ObjectModel("box", (Component("box", markers, required=True),)))
    assert len(Lookalikes(surface, in_place=True)) == 2


def at_end():
    return Pose.from_xyz_rpy((0.1, 0, 0))


@pytest.mark.parametrize("shift, turn", [((1, 0), 0.0), ((0, 1), 0.0), ((2, 0), np.pi / 2)], ids=str)
def test_from_a_pose_that_covers_most_of_a_grid_the_finder_comes_to_the_one_that_covers_all(shift, turn):
    """Moved by a pitch, or turned by a quarter: nine of twelve squares lie on squares, and no small step is better."""
    model, true = grid(), at(-0.08, 0.1, 1.1, 0.2, 0.5)
    labels = render(CAMERA, [(model, true, RED)])
    frame = ImageFrame(LabelField(labels), CAMERA)
    R = true.R @ rotation_from_rotvec([0.0, 0.0, turn])
    wrong = Poses(R, true.t + true.R[0] @ (*(PITCH * np.array(shift)), 0.0), true.q)
    assert 8 <= covered(centres(model, wrong), centres(model, true)) <= 9
    finder = WholeObjectFinder(Target("grid", model, RED), DEFAULTS)
    found = finder._with_lookalikes(frame, finder.fit_all(frame, wrong).best(1, DEFAULTS.search))
    there = centres(model, found.poses)
    assert np.linalg.norm(there[:, None] - centres(model, true), axis=2).min(axis=1).max() < 0.01


@pytest.mark.parametrize("jointed", [False, True])
def test_from_a_marker_that_lies_on_itself_the_finder_comes_to_the_turn_that_all_else_tells(jointed):
    hung = Joint("s", Pose.from_xyz_rpy((0.04, 0, 0)), np.array([0.0, 0.0, 1.0]), -0.5, 0.5) if jointed else None
    square = marker("m", rectangle(0.05, 0.05), np.eye(3), (0, 0, 0))
    tab = marker("m", rectangle(0.03, 0.02), np.eye(3), (0.03 if jointed else 0.07, 0, 0))
    parts = Component("s", (square,), required=True), Component("tab", (tab,), joint=hung)
    model, true = ObjectModel("tabbed", parts), at(0.05, 0.02, 0.6, 0.3, 0.4)
    true = Poses(true.R, true.t, np.full((1, int(jointed)), 0.2))
    frame = ImageFrame(LabelField(render(CAMERA, [(model, true, RED)])), CAMERA)
    finder = WholeObjectFinder(Target("tabbed", model, RED), DEFAULTS)
    wrong = Poses(true.R @ rotation_from_rotvec([0.0, 0.0, np.pi / 2]), true.t, true.q)
    found = finder._with_lookalikes(frame, finder.fit_all(frame, wrong).best(1, DEFAULTS.search))
    assert turn_between(found.poses.R[0], true.R[0]) < 0.1


def test_components_that_lookalikes_lead_to_need_no_guesses_of_their_own():
    model, true = grid(), at(-0.08, 0.1, 1.1, 0.2, 0.5)
    finder = WholeObjectFinder(Target("grid", model, RED), DEFAULTS)
    assert finder.is_alike_throughout and len(finder._seeds._guessers) == 1
    labels = render(CAMERA, [(model, true, RED)], BACKGROUND)
    frame = ImageFrame(LabelField(labels), CAMERA)
    off = []
    for blob in find_blobs(labels, {RED}, DEFAULTS):
        there = centres(model, finder.plain_guesses(frame, blob).poses)
        off.append(np.linalg.norm(there[:, None] - centres(model, true), axis=2).min(axis=1).max())
    assert len(off) == 12 and np.median(off) < 0.02  # one blob suffices
    assert not WholeObjectFinder(Target("truck", truck(), RED), DEFAULTS).is_alike_throughout


def test_a_ball_is_turned_in_place_by_nothing_that_could_be_told():
    model = ObjectModel("ball", (Component("ball", ball_solid(0.05, Pose.identity())[0], required=True),))
    assert not len(Lookalikes(SpatialModel(model, RED, DEFAULTS.votes), in_place=True))


@pytest.mark.parametrize("columns, rows, turn", [(5, 6, np.pi / 2), (5, 6, -np.pi / 2), (4, 7, np.pi)])
def test_a_board_of_discs_is_turned_by_just_as_much_as_lays_it_on_itself(columns, rows, turn):
    """To a tenth of a radian a quarter was 1.6: the right pose of a real board, a degree off, lost to a wrong one."""
    angles = 2 * np.pi * np.arange(24) / 24
    circle = 0.02 * np.column_stack([np.cos(angles), np.sin(angles)])
    surface = surface_of(grid(columns, rows, (2, 3), circle, 0.02))
    one = at(0.1, -0.05, 1.2, 0.3, 0.4)
    found = Lookalikes(surface).of(one)
    wanted = one.R[0] @ rotation_from_rotvec([0.0, 0.0, turn])
    assert min(turn_between(R, wanted) for R in found.R) < 1e-6
