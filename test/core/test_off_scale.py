"""What faces the camera beside the scales that are looked for: outlines drawn too narrow, things of another size that
look alike, and planes that are wrong."""

from __future__ import annotations

import fields
import numpy as np
import pytest
from settings import settings
from squares import TEAM, Placing, patch, rendered

from artrec_ros.core.base.config import ImageConfig, PlaneConfig, SceneConfig
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
CORNERS = np.array([(0, 0), (SIZE[0] - 1, 0), np.array(SIZE) - 1, (0, SIZE[1] - 1)], float)
NOSE = np.array([(-0.08, -0.026), (0.02, -0.026), (0.05, -0.018), (0.08, -0.006)])
BUG = np.concatenate([NOSE, NOSE[::-1] * (1, -1)])
NARROW = np.array([1.0, 0.9])
SIDE, PX_PER_M = 0.04, 450.0


class Bug(Placing):
    def patches(self):
        return [(self.at(BUG), TEAM)]


def bug(outline=BUG):
    shell = patch("shell", outline, Pose(np.eye(3), np.zeros(3)))
    return Target("bug", ObjectModel("bug", (Component("shell", (shell,), required=True),)), TEAM)


def below(tolerance):
    """Straight below the camera."""
    field = CORNERS * (1, -1) / SCALE
    return SceneConfig(plane=PlaneConfig(tuple(CORNERS.ravel()), tuple(field.ravel()), scale_tolerance=tolerance))


def found(target, image, **known):
    return Recognizer([target], settings(**known), Segmenter(ImageConfig()), calibrated=False).recognize(image)


@pytest.mark.parametrize("turn", [0.4, 2.0, -2.3])
def test_what_is_drawn_too_narrow_is_told_at_a_size_that_the_plane_has(turn):
    placing = Bug(150.0, 110.0, turn, SCALE)
    image, target = rendered(placing, size=SIZE), bug(BUG * NARROW)
    (free,) = found(target, image, scene=below(1.0)).detections
    assert free.image.scale > 1.04 * SCALE  # the sides fit, and the nose lies on bare ground
    (told,) = found(target, image, scene=below(0.05)).detections
    assert told.image.scale < 1.051 * SCALE and told.score > 0.7
    assert abs(wrap_angle(told.image.theta + turn)) < 0.1  # it leans on one side


def test_what_a_fit_holds_at_the_end_of_the_planes_tolerance_is_within_it():
    """Whatever its rounding."""
    scene = Scene.of(below(0.1))
    ends = scene.scale_limits(np.full((1, 2), 50.0))[0]
    scales = np.outer(ends, (1 - 1e-12, 1 + 1e-12)).ravel()
    assert scene.reasons(np.full((4, 2), 50.0), scales) == [None] * 4


def squares(times, scene_scale=1.0, limits=False):
    """Of robots that are so many times as large as the file says: how many of six are told, and what is said of the
    others. :param scene_scale: how many times as large as they are things are by the plane."""
    camera = fields.camera(PX_PER_M)
    places = np.array([(x, y) for x in (0.15, 0.5, 0.85) for y in (0.15, 0.5)])
    turned = np.column_stack([places, np.linspace(-3, 3, len(places))])
    plane = fields.plane(camera, 0.0, scale_tolerance=0.1)
    wrong = PlaneConfig(plane.image_points, tuple(np.divide(plane.field_points, scene_scale)), scale_tolerance=0.1)
    known = (
        {"min_scale": PX_PER_M / 1.1, "max_scale": PX_PER_M * 1.1} if limits else {"scene": SceneConfig(plane=wrong)}
    )
    return found(
        Target("robot", fields.robot(SIDE), fields.TEAM), fields.render(camera, 0.0, times * SIDE, turned), **known
    )


@pytest.mark.parametrize("times", [0.7, 0.8, 1.25, 1.4])
@pytest.mark.parametrize("limits", [False, True])
def test_things_of_another_size_are_not_told(times, limits):
    result = squares(times, limits=limits)
    assert not result.detections and result.rejected


def test_why_things_of_another_size_are_not_told_is_said():
    reasons = [r.reason for r in squares(0.7, limits=True).rejected]
    assert sum("its edges are those of an object of 3" in r and "may have 409 at least" in r for r in reasons) >= 4


@pytest.mark.parametrize("times", [0.91, 1.0, 1.1])
@pytest.mark.parametrize("limits", [False, True])
def test_what_is_at_the_limits_is_told_as_surely_as_amid_them(times, limits):
    told = squares(times, limits=limits).detections
    assert len(told) == 6 and min(d.score for d in told) > 0.99


@pytest.mark.parametrize("times", [0.72, 1.4])
def test_a_plane_that_is_wrong_is_told(times):
    result = squares(1.0, scene_scale=times)
    assert not result.detections
    assert sum("but scene.plane has" in r.reason for r in result.rejected) >= 4


def test_the_farther_beyond_a_limit_the_less_likely():
    """From nothing on, and less where edges tell the size less well."""

    def odds(times, size):
        finder = WholeObjectFinder(bug(), settings(max_scale=size), facing=True)
        frame = ImageFrame(LabelField(rendered(Bug(150.0, 110.0, 0.4, times * size), size=SIZE))).faced()
        return finder.at_scale.off_scale(frame, Bug(150.0, 110.0, 0.4, size).pose(frame.camera))

    none, *more = (odds(times, SCALE) for times in (0.98, 1.01, 1.02, 1.04))
    assert none.odds[0] == 0 and np.isnan(none.scale[0])
    assert 0 < more[0].odds[0] < more[1].odds[0] < more[2].odds[0]
    assert more[-1].scale[0] == pytest.approx(1.04 * SCALE, rel=0.01) and more[-1].limit[0] == pytest.approx(SCALE)
    assert odds(1.04, SCALE / 3).odds[0] < more[2].odds[0]


def test_limits_hold_where_the_required_component_is():
    finder = WholeObjectFinder(bug(), settings(max_scale=SCALE), facing=True)
    frame = ImageFrame(LabelField(rendered(Bug(150.0, 110.0, 0.4, SCALE), size=SIZE))).faced()
    both = Poses.concatenate([Bug(150.0, 110.0, 0.4, times * SCALE).pose(frame.camera) for times in (0.9, 1.3)])
    kept, beyond = finder.at_scale.fitted(frame, both)
    assert beyond.tolist() == [1]
    np.testing.assert_array_equal(kept.t[0], both.t[0])
    assert frame.camera.focal_px / finder.required.anchors(kept)[1, 2] <= SCALE * 1.0001
