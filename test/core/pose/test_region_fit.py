"""Figures fitted to raw colours."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from settings import DEFAULTS, settings
from squares import ARM, BACK, SIZE, TEAM, Placing, gate, hinge, patch, rendered, robot

from artrec_ros.core.image.codes import OUTSIDE
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.region_kernels import Regions, bend

AT = Placing(72.3, 58.4, 0.7, 330.0, "gv")
RGB = {0: (60, 60, 62), TEAM: (230, 200, 30), 4: (40, 160, 60), 5: (210, 40, 60), 6: (120, 60, 170)}
FINDER = WholeObjectFinder(Target("robot", robot(), TEAM), DEFAULTS, facing=True)


def frame_of(labels, light=1.0, blur=0.8):
    palette = np.zeros((256, 3))
    for label, colour in RGB.items():
        palette[label] = colour
    image = cv2.GaussianBlur(palette[labels] * light, (0, 0), blur)
    return ImageFrame(LabelField(labels), image=np.clip(np.rint(image), 0, 255).astype(np.uint8)).faced()


def fitted_in(frame, poses, finder=FINDER, used=True):
    markers = len(finder.surface.markers)
    return finder.rest.regions.fitted(frame, poses, np.broadcast_to(used, (len(poses), markers)))


def poses_of(frame, *placings):
    return Poses.concatenate([p.pose(frame.camera) for p in placings])


def shifted(**changes):
    values = {"x": AT.x, "y": AT.y, "turn": AT.turn, "scale": AT.scale}
    return Placing(**{name: value + changes.get(name, 0.0) for name, value in values.items()}, name=AT.name)


@pytest.mark.parametrize("light", [0.3, 1.0])
def test_regions_are_most_even_where_the_object_is_in_any_light(light):
    frame = frame_of(rendered(AT), light)
    off = [shifted(x=3.0), shifted(y=-3.0), shifted(turn=0.4), shifted(turn=np.pi / 2), shifted(scale=80.0)]
    even = FINDER.rest.regions.evenness(frame, poses_of(frame, AT, *off))
    assert even[0] > 0.85 and (even <= 1).all()
    assert (even[1:] < even[0] - 0.05).all()


def test_what_the_border_cuts_has_no_evenness():
    frame = frame_of(rendered(AT))
    cut, far = shifted(x=3.0 - AT.x), shifted(x=10.0 * SIZE[0])
    assert FINDER.rest.regions.evenness(frame, poses_of(frame, cut, far)).tolist() == [0.0, 0.0]


def test_each_of_several_is_fitted_as_if_it_were_alone():
    frame = frame_of(rendered(AT))
    poses = poses_of(frame, shifted(x=0.9, turn=0.06), shifted(y=-0.8, scale=15.0))
    fitted = fitted_in(frame, poses)
    truth = AT.pose(frame.camera)
    for i in range(2):
        alone = fitted_in(frame, poses[i : i + 1])
        np.testing.assert_allclose(alone.t[0], fitted.t[i])
        np.testing.assert_allclose(alone.R[0], fitted.R[i])
        off = (fitted.t[i, :2] / fitted.t[i, 2] - truth.t[0, :2] / truth.t[0, 2]) * frame.camera.focal_px
        assert np.hypot(*off) < 0.4
        assert np.arccos((np.trace(fitted.R[i].T @ truth.R[0]) - 1) / 2) < np.radians(1)
        assert fitted.t[i, 2] == pytest.approx(truth.t[0, 2], rel=0.02)
    assert len(fitted_in(frame, poses[:0])) == 0


def test_an_image_that_may_not_be_written_to_gives_the_same():
    frame = frame_of(rendered(AT))
    poses, before = poses_of(frame, shifted(x=0.9)), frame.image.copy()
    expected = fitted_in(frame, poses)
    frame.image.flags.writeable = False
    np.testing.assert_array_equal(fitted_in(frame, poses).t, expected.t)
    np.testing.assert_array_equal(frame.image, before)


@pytest.mark.parametrize(("limits", "scale"), [({"max_scale": 310.0}, 310.0), ({"min_scale": 350.0}, 350.0)])
def test_limits_of_the_scale_are_kept(limits, scale):
    """The picture shows one just beyond them."""
    finder = WholeObjectFinder(Target("robot", robot(), TEAM), settings(**limits), facing=True)
    frame = frame_of(rendered(AT))
    begin = poses_of(frame, shifted(scale=1.1 * (scale - AT.scale)))
    kept, free = (frame.camera.focal_px / fitted_in(frame, begin, f).t[0, 2] for f in (finder, FINDER))
    assert abs(free - AT.scale) < abs(scale - AT.scale) - 2, "it goes where the picture shows it"
    assert kept == pytest.approx(scale, rel=1e-3)


BENT = Placing(72.3, 58.4, 0.7, 330.0, arm=0.4)
RGB[7] = (220, 120, 30)


def gate_finder(model=None):
    return WholeObjectFinder(Target("gate", model or gate(), TEAM), DEFAULTS, facing=True)


@pytest.mark.parametrize("off", [-0.08, 0.08])
def test_joints_are_fitted_with_the_rest(off):
    """A scale that blur has made too large opens joints, too."""
    finder, frame = gate_finder(), frame_of(rendered(BENT))
    begin = replace(BENT, scale=345.0, arm=BENT.arm + off).pose(frame.camera)
    fitted = fitted_in(frame, begin, finder)
    assert abs(fitted.q[0, 0] - BENT.arm) < 0.6 * abs(off)
    assert frame.camera.focal_px / fitted.t[0, 2] == pytest.approx(BENT.scale, rel=0.015)


def test_a_joint_that_moves_nothing_that_is_seen_stays_and_none_leaves_its_limits():
    finder, frame = gate_finder(), frame_of(rendered(BENT))
    begin = replace(BENT, arm=0.3).pose(frame.camera)
    carried = finder.surface.component[finder.surface.markers] == 3
    assert fitted_in(frame, begin, finder, used=~carried).q[0, 0] == 0.3
    plain = gate().components
    stopped = replace(
        plain[3], joint=hinge("team", plain[3].joint.T_parent_joint.position, (0, 0, 1), limits=(0, 0.34))
    )
    fitted = fitted_in(frame, begin, gate_finder(ObjectModel("gate", (*plain[:3], stopped))))
    assert fitted.q[0, 0] == pytest.approx(0.34, abs=0.005) and fitted.q[0, 0] <= 0.34


def linked():
    """An arm that slides along the robot's x, and on it one that swings."""
    plain = robot(alternatives=False)
    first = Component("arm", (patch("arm", ARM),), label=7, joint=hinge("team", (0.03, 0, 0), (1, 0, 0), "prismatic"))
    second = Component("hand", (patch("hand", ARM),), label=5, joint=hinge("arm", (0.1, 0.0, 0.0), (0, 0, 1)))
    return ObjectModel("linked", (*plain.components, first, second))


@pytest.mark.parametrize("turn", [0.0, 2.5])
def test_points_move_with_every_joint_that_carries_them(turn):
    """As the figure of the bent model has them: of both joints at once, whichever comes first."""
    finder = gate_finder(linked())
    frame = frame_of(rendered(AT))
    there = replace(BENT, turn=turn).pose(frame.camera)
    figures = [
        finder.rest.regions._figures(frame, Poses(there.R, there.t, np.array([q]))) for q in ((0.01, 0.2), (0.03, 0.5))
    ]
    one, other = (figure.regions for figure in figures)
    moved = np.array([0.02, 0.3])[finder.rest.regions._order]
    x, y = np.empty((2, one.x.shape[1]))
    figure = Regions(one.x[0], one.y[0], one.region, one.n_regions, one.moved, one.turns[0], one.at[0])
    bend(figure, one.x[0], one.y[0], moved, x, y)
    np.testing.assert_allclose(x, other.x[0], atol=1e-6)
    np.testing.assert_allclose(y, other.y[0], atol=1e-6)
    assert np.abs(other.x[0] - one.x[0]).max() > 5


def test_however_many_and_however_jointed_they_are_the_same_code_fits_them():
    """Another order in memory would be compiled for in the middle of a frame."""
    frame, begin = frame_of(rendered(BENT)), BENT.pose
    for finder, q in ((FINDER, []), (gate_finder(), [0.3]), (gate_finder(linked()), [0.01, 0.2])):
        there = begin(frame.camera)
        for n in (1, 2):
            poses = Poses(*(np.repeat(v, n, axis=0) for v in (there.R, there.t, np.array([q], float).reshape(1, -1))))
            regions = finder.rest.regions._figures(frame, poses).regions
            assert all(np.asarray(part).flags.c_contiguous for part in regions)


def test_what_a_view_from_above_does_not_show_has_no_colours():
    """Beyond the image's border it is black: an object that this cuts stays, and has no evenness."""
    frame = frame_of(rendered(AT))
    codes, image, border = frame.field.codes.copy(), frame.image.copy(), int(AT.x) + 4
    codes[:, border:], image[:, border:] = OUTSIDE, 0
    poses = poses_of(frame, shifted(x=0.9, turn=0.06))
    cut = ImageFrame(LabelField(codes), image=image).faced()
    np.testing.assert_array_equal(fitted_in(cut, poses).t, poses.t)
    assert FINDER.rest.regions.evenness(cut, poses).tolist() == [0.0]
    assert (fitted_in(frame, poses).t != poses.t).any()


def test_colours_of_what_covers_a_part_pull_nothing():
    """Where a marker lacks more of its class than a rim, an object rests on contours alone."""
    frame = frame_of(rendered(AT))
    codes, image = frame.field.codes.copy(), frame.image.copy()
    around = np.rint(AT.at([BACK.mean(axis=0)])[0]).astype(int)
    for of, value in ((codes, 0), (image, (150, 40, 40))):
        of[around[1] : around[1] + 9, around[0] - 5 : around[0] + 9] = value
    covered = ImageFrame(LabelField(codes), image=image).faced()
    poses = AT.pose(frame.camera)
    for shown, moves in ((frame, True), (covered, False)):
        used = FINDER.voter.supported(FINDER.voter.judge(shown, poses, occlusion=True))
        told, rest = FINDER.rest.at_rest(shown, poses, used), FINDER.rest.settled(shown, poses, used)
        assert (told.t != rest.t).any() == moves
