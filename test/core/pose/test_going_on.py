"""Long markers whose labels are thinner than they are: both ends are found, be hypotheses short of them or beyond."""

from dataclasses import dataclass, replace

import numpy as np
import pytest
from settings import DEFAULTS, settings
from solids import rectangle
from squares import TEAM, Placing, hinge, patch, rendered, robot

from artrec_ros.core.base.config import ImageConfig, PlaneConfig
from artrec_ros.core.geometry.field_plane import FieldPlane
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.scene import Scene
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.contour_steps import ContourSteps
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.going_on import GoingOn
from artrec_ros.core.pose.pose_fit import far_ends
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.recognizer import Recognizer

SIZE, SCALE = (420, 300), 400.0
UPPER, LOWER = (rectangle(0.36, 0.03, (x, 0.0)) for x in (0.2, -0.25))  # 144 x 12 px


def pendulum(lower=True):
    limb = Component("lower", (patch("lower", LOWER),), label=7, joint=hinge("upper", (0, 0, 0), (0, 0, 1)))
    upper = Component("upper", (patch("upper", UPPER),), required=True)
    return ObjectModel("pendulum", (upper, limb) if lower else (upper,))


@dataclass(frozen=True)
class Thin(Placing):
    """One of which the outermost pixels are lost."""

    lost_px: float = 2.0

    def patches(self):
        off = self.lost_px / self.scale
        out = [(self.at(_inside(UPPER, off)), TEAM)]
        if self.arm is not None:
            c, s = np.cos(self.arm), np.sin(self.arm)
            out.append((self.at(_inside(LOWER, off) @ np.array([[c, s], [-s, c]])), 7))
        return out


def _inside(outline, off):
    middle = outline.mean(axis=0)
    return outline - np.sign(outline - middle) * off


AT = Thin(215.0, 150.0, 0.3, SCALE, arm=0.25)
FRAME = ImageFrame(LabelField(rendered(AT, size=SIZE))).faced()


def finder_of(model):
    return WholeObjectFinder(Target("pendulum", model, TEAM), DEFAULTS, facing=True)


def off_px(finder, frame, poses, placing=AT):
    """The farther end of the upper bar from where it is."""
    ends = np.array([(x, 0.0) for x in (0.02, 0.38)])
    seen = project(frame.camera, np.pad(ends, ((0, 0), (0, 1))) @ poses.R[0].T + poses.t[0])
    return float(np.linalg.norm(seen - placing.at(ends), axis=1).max())


def resized(poses, times):
    """The same so much larger, about the optical axis' foot."""
    return Poses(poses.R, poses.t / times, poses.q)


@pytest.mark.parametrize("lower", [True, False])
@pytest.mark.parametrize("times", [0.85, 0.9, 0.95, 1.0])
def test_what_begins_short_rests_on_both_ends(lower, times):
    placing = AT if lower else replace(AT, arm=None)
    frame = ImageFrame(LabelField(rendered(placing, size=SIZE))).faced()
    finder, pose = finder_of(pendulum(lower)), resized(placing.pose(frame.camera), times)
    used = np.ones((1, len(finder.surface.markers)), bool)
    assert off_px(finder, frame, finder.rest.settled(frame, pose, used), placing) < 3


def test_votes_are_asked_of_what_goes_on_and_of_nothing_else():
    finder, right = finder_of(pendulum()), AT.pose(FRAME.camera)
    both = finder.ranked(FRAME, Poses.concatenate([right, resized(right, 0.85)]))
    found = finder.gone_on(FRAME, both)
    assert len(found) == 4 and found.votes[2:].max() > both.votes[1]
    assert len(finder.gone_on(FRAME, both[:1])) == 1


def a_bar_begun_short(length):
    """A frame, and a pose in it that is a tenth smaller than the file's bar would be."""

    class Longer(Thin):
        def patches(self):
            return [(self.at(rectangle(length, 0.03, (0.2, 0.0))), TEAM)]

    placing = Longer(215.0, 150.0, 0.3, SCALE)
    frame = ImageFrame(LabelField(rendered(placing, size=SIZE))).faced()
    return frame, resized(placing.pose(frame.camera), 0.9)


@pytest.mark.parametrize(("length", "looked"), [(0.4, 1), (0.9, 0)])
def test_what_goes_on_for_long_is_something_else(length, looked):
    frame, short = a_bar_begun_short(length)
    assert len(finder_of(pendulum(lower=False)).rest.gone_on(frame, short)) == looked


@pytest.mark.parametrize(("length", "looked"), [(0.4, 1), (0.9, 0)])
def test_markers_are_as_long_as_they_look_wherever_their_object_has_its_origin(length, looked):
    frame, short = a_bar_begun_short(length)
    away = np.array([0.0, 0.0, 0.95 * short.t[0, 2]])  # the origin is near the camera, its marker is not
    bar = patch("upper", UPPER, Pose(np.eye(3), short.R[0].T @ away))
    surface = SpatialModel(ObjectModel("bar", (Component("upper", (bar,), required=True),)), TEAM, DEFAULTS.votes)
    at = Poses(short.R, short.t - away, short.q)
    going_on = GoingOn(surface, DEFAULTS.fit, facing=False)
    assert len(going_on.rows(frame, at, np.ones((1, 1), bool))) == looked


def test_fits_that_lose_an_end_begin_again_from_where_it_was():
    finder, begun = finder_of(pendulum()), AT.pose(FRAME.camera)
    going_on, used = GoingOn(finder.surface, DEFAULTS.fit, facing=True), np.ones((1, 2), bool)
    rows, again = going_on.fitted_anew(FRAME, begun, resized(begun, 1.1), used)
    assert rows.tolist() == [0]
    np.testing.assert_array_equal(again.t, begun.t)
    assert not len(going_on.fitted_anew(FRAME, begun, begun, used)[0])
    beyond = resized(begun, 1.1)  # it lost nothing that it had: what is covered ends there, too
    assert not len(going_on.fitted_anew(FRAME, beyond, beyond, used)[0])


def test_nobody_looks_where_no_marker_is_long():
    surface = SpatialModel(robot(alternatives=False), TEAM, DEFAULTS.votes)
    assert not far_ends(surface, DEFAULTS.fit).any()
    assert not GoingOn(surface, DEFAULTS.fit, facing=True).may_be
    long = far_ends(SpatialModel(pendulum(), TEAM, DEFAULTS.votes), DEFAULTS.fit)
    assert long.any(axis=1).all() and long.sum() < long.size / 4  # ends, not sides


def test_steps_of_what_faces_the_camera_turn_it_about_its_axis_alone():
    finder, pose = finder_of(pendulum()), resized(AT.pose(FRAME.camera), 0.95)
    used = np.ones((1, 2), bool)
    for facing in (True, False):
        going_on = GoingOn(finder.surface, DEFAULTS.fit, facing=facing)
        steps = ContourSteps(finder.surface, DEFAULTS.fit, facing=facing)
        fit, residual, weight, _ = going_on._edges(FRAME, pose, used)
        moved, _ = steps.step(steps.begun(FRAME, used), pose, fit, residual, weight)
        assert (np.abs(moved.R[0, 2, :2]).max() < 1e-9) == facing


@pytest.mark.parametrize("turn", [0.3, -1.2, 2.0])
def test_thin_bars_are_told_as_long_as_they_are(turn):
    """Their area is that of bars a fifth smaller."""
    placing = Thin(215.0, 150.0, turn, SCALE, arm=0.25)
    config = settings(min_scale=250.0, max_scale=600.0)
    target = Target("pendulum", pendulum(), TEAM)
    image = rendered(placing, size=SIZE)
    (found,) = Recognizer([target], config, Segmenter(ImageConfig()), calibrated=False).recognize(image).detections
    assert found.image.scale == pytest.approx(SCALE, rel=0.02) and found.score > 0.9


@pytest.mark.parametrize("times", [0.85, 1.0, 1.2])
def test_no_rest_leaves_the_scale_that_the_scene_has(times):
    finder = finder_of(pendulum())
    corners = np.array([(0, 0), (419, 0), (419, 299), (0, 299)], float)
    config = PlaneConfig(tuple(corners.ravel()), tuple((corners * (1, -1) / SCALE).ravel()), scale_tolerance=0.1)
    frame = replace(FRAME, scene=Scene(plane=FieldPlane.of(config, None)))
    poses = resized(AT.pose(frame.camera), times)
    kept, _ = finder.at_scale.fitted(frame, poses, np.zeros((1, 2), bool))  # no contour moves it
    before, after = (finder.required.anchors(p) for p in (poses, kept))
    scale = frame.camera.focal_px / after[0, 2]
    assert scale == pytest.approx(SCALE * np.clip(times, 1 / 1.1, 1.1), rel=1e-3)
    np.testing.assert_allclose(project(frame.camera, before), project(frame.camera, after))


def test_beyond_a_planes_horizon_a_rest_stays():
    """Nothing has a scale there."""
    seen, lie = (100, 250, 320, 250, 250, 120, 170, 120), (-0.3, 0.0, 0.3, 0.0, 0.3, 2.0, -0.3, 2.0)
    frame = replace(FRAME, scene=Scene(plane=FieldPlane.of(PlaneConfig(seen, lie), None)))
    pose = replace(AT, y=20.0).pose(frame.camera)
    kept, beyond = finder_of(pendulum()).at_scale.fitted(frame, pose)
    assert not len(beyond)
    np.testing.assert_array_equal(kept.t, pose.t)


@pytest.mark.parametrize("x", [110.0, 140.0])
def test_what_a_short_hypothesis_leaves_of_a_bar_is_no_second_one(x):
    """It comes to rest on the same bar, turned by half."""
    image = rendered(Thin(x, 150.0, 0.3, SCALE), size=SIZE)
    target, config = Target("bar", pendulum(lower=False), TEAM), settings(min_scale=250.0, max_scale=600.0)
    (found,) = Recognizer([target], config, Segmenter(ImageConfig()), calibrated=False).recognize(image).detections
    assert found.image.scale == pytest.approx(SCALE, rel=0.03)
