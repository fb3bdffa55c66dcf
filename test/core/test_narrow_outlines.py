"""Flat objects whose files have them narrower than they are, on a plane that is known: of the plane's scale."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS, settings
from squares import TEAM, Placing, patch, rendered

from artrec_ros.core.base.config import ImageConfig, PlaneConfig, SceneConfig
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.scene import Scene
from artrec_ros.core.geometry.transforms import Pose, wrap_angle
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.recognizer import Recognizer

SIZE, SCALE = (320, 240), 700.0
FACED = Camera.facing(SIZE)
CORNERS = np.array([(0, 0), (SIZE[0] - 1, 0), np.array(SIZE) - 1, (0, SIZE[1] - 1)], float)
NARROW = np.array([1.0, 0.8])
NOSE = np.array([(-0.08, -0.03), (0.02, -0.03), (0.05, -0.012), (0.08, -0.006)])
BUG = np.concatenate([NOSE, NOSE[::-1] * (1, -1)])


def plane(tolerance, scale=SCALE):
    """Straight below the camera."""
    return PlaneConfig(tuple(CORNERS.ravel()), tuple((CORNERS * (1, -1) / scale).ravel()), scale_tolerance=tolerance)


class Bug(Placing):
    def patches(self):
        return [(self.at(BUG), TEAM)]


def bug_of(outline, above=0.0):
    shell = patch("shell", outline, Pose(np.eye(3), np.array([0.0, 0.0, above])))
    return ObjectModel("bug", (Component("shell", (shell,), required=True),))


def found(image, tolerance, above=0.0):
    target = Target("bug", bug_of(BUG * NARROW, above), TEAM)
    config = settings(scene=SceneConfig(plane=plane(tolerance)))
    return Recognizer([target], config, Segmenter(ImageConfig()), calibrated=False).recognize(image).detections


@pytest.mark.parametrize("above", [0.0, 0.1])
@pytest.mark.parametrize("turn", [0.4, 2.0, -2.3])
def test_a_size_that_the_plane_refuses_is_fitted_at_one_that_it_has(turn, above):
    placing = Bug(150.0, 110.0, turn, SCALE)
    (free,) = found(rendered(placing, size=SIZE), 1.0)
    assert free.image.scale > 1.1 * SCALE  # the long sides fit, and the nose lies on bare ground
    (told,) = found(rendered(placing, size=SIZE), 0.03, above)
    assert told.image.scale < 1.0301 * SCALE
    (middle,) = placing.at(bug_of(BUG).required.markers[0].centroid[None])
    assert np.hypot(told.image.x - middle[0], told.image.y - middle[1]) < 4
    assert wrap_angle(told.image.theta + turn) == pytest.approx(0.0, abs=0.1)  # it leans on one side


def test_limits_hold_where_the_markers_are():
    """Not at the object's place, which may lie behind them."""
    finder = WholeObjectFinder(Target("bug", bug_of(BUG, 0.1), TEAM), settings(max_scale=700.0), facing=True)
    frame = ImageFrame(LabelField(np.zeros(SIZE[::-1], np.uint8))).faced()
    pose = Bug(150.0, 110.0, 0.3, 900.0).pose(frame.camera)
    kept = finder.climber.within_limits(frame, pose)
    assert frame.camera.focal_px / finder.required.anchors(kept)[0, 2] == pytest.approx(700.0)
    near, far = finder.climber.depths(frame, kept)
    assert kept.t[0, 2] == pytest.approx(near) and far == np.inf


def test_a_plane_is_a_term_of_the_fit():
    finder = WholeObjectFinder(Target("bug", bug_of(BUG * NARROW), TEAM), DEFAULTS, facing=True)
    at = Bug(150.0, 110.0, 0.4, SCALE)
    frame, pose = ImageFrame(LabelField(rendered(at, size=SIZE))).faced(), at.pose(FACED)
    off = [1.0]
    for scene in (Scene(), *(Scene.of(SceneConfig(plane=plane(tolerance))).faced(FACED) for tolerance in (1.0, 0.1))):
        fitted = finder.rest.settled(replace(frame, scene=replace(scene, plane=None)), pose, np.ones((1, 1), bool))
        off.append(abs(np.log(fitted.t[0, 2] / pose.t[0, 2])))
    assert off[1] > off[2] > off[3]


def test_of_two_poses_that_show_the_same_the_one_at_the_planes_scale_is_likelier():
    scene = Scene.of(SceneConfig(plane=plane(0.1))).faced(FACED)
    at, larger = (Bug(150.0, 110.0, 0.3, times * SCALE).pose(FACED) for times in (1.0, 1.1))
    both = Poses.concatenate([at, larger])
    against = scene.odds_against(both.R, both.t)
    assert against[0] < 0.01 and against[1] == pytest.approx(1.5, rel=0.15)  # by sqrt 3 deviations
