"""Figures fitted to raw colours."""

import cv2
import numpy as np
import pytest
from settings import DEFAULTS, settings
from squares import SIZE, TEAM, Placing, rendered, robot

from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.surface_model import Poses

AT = Placing(72.3, 58.4, 0.7, 330.0, "gv")
RGB = {0: (60, 60, 62), TEAM: (230, 200, 30), 4: (40, 160, 60), 5: (210, 40, 60), 6: (120, 60, 170)}
FINDER = WholeObjectFinder(Target("robot", robot(), TEAM), DEFAULTS, facing=True)


def frame_of(labels, light=1.0, blur=0.8):
    palette = np.zeros((256, 3))
    for label, colour in RGB.items():
        palette[label] = colour
    image = cv2.GaussianBlur(palette[labels] * light, (0, 0), blur)
    return ImageFrame(LabelField(labels), image=np.clip(np.rint(image), 0, 255).astype(np.uint8)).faced()


def poses_of(frame, *placings):
    return Poses.concatenate([p.pose(frame.camera) for p in placings])


def shifted(**changes):
    values = {"x": AT.x, "y": AT.y, "turn": AT.turn, "scale": AT.scale}
    return Placing(**{name: value + changes.get(name, 0.0) for name, value in values.items()}, name=AT.name)


@pytest.mark.parametrize("light", [0.3, 1.0])
def test_regions_are_most_even_where_the_object_is_in_any_light(light):
    frame = frame_of(rendered(AT), light)
    off = [shifted(x=3.0), shifted(y=-3.0), shifted(turn=0.4), shifted(turn=np.pi / 2), shifted(scale=80.0)]
    even = FINDER.regions.evenness(frame, poses_of(frame, AT, *off))
    assert even[0] > 0.85 and (even <= 1).all()
    assert (even[1:] < even[0] - 0.05).all()


def test_what_the_border_cuts_has_no_evenness():
    frame = frame_of(rendered(AT))
    cut, far = shifted(x=3.0 - AT.x), shifted(x=10.0 * SIZE[0])
    assert FINDER.regions.evenness(frame, poses_of(frame, cut, far)).tolist() == [0.0, 0.0]


def test_each_of_several_is_fitted_as_if_it_were_alone():
    frame = frame_of(rendered(AT))
    poses = poses_of(frame, shifted(x=0.9, turn=0.06), shifted(y=-0.8, scale=15.0))
    fitted = FINDER.regions.fitted(frame, poses)
    truth = AT.pose(frame.camera)
    for i in range(2):
        alone = FINDER.regions.fitted(frame, poses[i : i + 1])
        np.testing.assert_allclose(alone.t[0], fitted.t[i])
        np.testing.assert_allclose(alone.R[0], fitted.R[i])
        off = (fitted.t[i, :2] / fitted.t[i, 2] - truth.t[0, :2] / truth.t[0, 2]) * frame.camera.focal_px
        assert np.hypot(*off) < 0.4
        assert np.arccos((np.trace(fitted.R[i].T @ truth.R[0]) - 1) / 2) < np.radians(1)
        assert fitted.t[i, 2] == pytest.approx(truth.t[0, 2], rel=0.02)
    assert len(FINDER.regions.fitted(frame, poses[:0])) == 0


def test_an_image_that_may_not_be_written_to_gives_the_same():
    frame = frame_of(rendered(AT))
    poses, before = poses_of(frame, shifted(x=0.9)), frame.image.copy()
    expected = FINDER.regions.fitted(frame, poses)
    frame.image.flags.writeable = False
    np.testing.assert_array_equal(FINDER.regions.fitted(frame, poses).t, expected.t)
    np.testing.assert_array_equal(frame.image, before)


@pytest.mark.parametrize(("limits", "scale"), [({"max_scale": 310.0}, 310.0), ({"min_scale": 350.0}, 350.0)])
def test_limits_of_the_scale_are_kept(limits, scale):
    """The picture shows one just beyond them."""
    finder = WholeObjectFinder(Target("robot", robot(), TEAM), settings(**limits), facing=True)
    frame = frame_of(rendered(AT))
    begin = poses_of(frame, shifted(scale=1.1 * (scale - AT.scale)))
    kept, free = (frame.camera.focal_px / f.regions.fitted(frame, begin).t[0, 2] for f in (finder, FINDER))
    assert abs(free - AT.scale) < abs(scale - AT.scale) - 2, "it goes where the picture shows it"
    assert kept == pytest.approx(scale, rel=1e-3)
