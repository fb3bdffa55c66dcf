"""What is told of frames as seen from above is where the image has it, or beyond its border."""

from dataclasses import replace

import numpy as np

from artrec_ros.core.base.config import PlaneConfig, SceneConfig
from artrec_ros.core.from_above import back_in_image, in_image
from artrec_ros.core.geometry.range_limits import ScaleLimits
from artrec_ros.core.geometry.scene import Scene
from artrec_ros.core.geometry.top_view import TopView
from artrec_ros.core.model.found import Detection, ImagePose, Missing, OtherPlace
from artrec_ros.core.model.frame_result import Rejection, StageResult

SIZE, HEIGHT_M, FOCAL_PX, DOWN = (640, 480), 0.3, 300.0, np.radians(20.0)
MARKS = np.array([[0.5, 0.2], [0.5, -0.2], [2.0, 0.6], [2.0, -0.6]])


def low_view() -> TopView:
    """Of a camera low above the plane at x = y = 0 that looks along x: it sees nothing nearer than x = 0.18 m, and what
    has x < -0.1 m is behind it."""
    ahead, aside = np.array([np.cos(DOWN), 0, -np.sin(DOWN)]), np.array([0, -1.0, 0])
    points = (np.column_stack([MARKS, np.zeros(4)]) - (0, 0, HEIGHT_M)) @ np.array(
        [aside, np.cross(ahead, aside), ahead]
    ).T
    pixels = FOCAL_PX * points[:, :2] / points[:, 2:] + (319.5, 239.5)
    plane = PlaneConfig(image_points=tuple(pixels.ravel()), field_points=tuple(MARKS.ravel()))
    view = TopView.of(Scene.of(SceneConfig(plane=plane)), SIZE, ScaleLimits(0.0, np.inf))
    assert view is not None
    return view


def test_what_is_behind_the_camera_is_told_beyond_the_border() -> None:
    view = low_view()
    plane = view.scene.plane
    assert plane is not None
    before, behind = plane.pixels(np.array([[0.5, 0.0], [-0.2, 0.0]])).tolist()
    assert not np.isfinite(view.in_image(np.array([behind]))).any()
    missing = Missing("near", "not seen", *before), Missing("far", "out of view", *behind)
    (told,) = in_image([Detection("toy", 0, 0.9, ImagePose(*behind, 0.1, 40.0), (), missing=missing)], view)
    near, far = told.missing
    np.testing.assert_allclose((near.x, near.y), view.in_image(np.array([before]))[0])
    (refused,) = back_in_image(StageResult((), (Rejection("toy", "too few", 0.1, *behind),)), view).rejected
    for place in (far, told.image, refused):
        assert np.isfinite((place.x, place.y)).all() and place.y > SIZE[1]
    assert np.isfinite((told.image.theta, told.image.scale)).all()


def test_another_place_is_told_in_the_image() -> None:
    view, before, beside = low_view(), (300.0, 200.0), (340.0, 220.0)
    other = OtherPlace(ImagePose(*beside, 0.4, 40.0), 0.3)
    one = Detection("toy", 0, 0.5, ImagePose(*before, 0.1, 40.0), (), other_place=other)
    told, same = in_image([one, Detection("toy", 1, 0.5, other.image, ())], view)
    assert told.other_place == OtherPlace(same.image, 0.3) and told.image != same.image
    with_all = replace(one, other_place=replace(other, told=replace(one, image=other.image, other_place=None)))
    (told,) = in_image([with_all], view)
    assert told.other_place.told.image == same.image
