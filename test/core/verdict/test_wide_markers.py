"""What is asked of an outline grows with its marker: files, calibrations and fits are off by shares of a size."""

import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, camera_of, marker, rectangle, render

from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.verdict.acceptance import verdicts_of
from artrec_ros.core.verdict.claims import claims_of

CAMERA = camera_of((640, 480), 600.0)
FACING = np.diag([1.0, -1.0, -1.0])


def fits(shape, off_px):
    """How well an outline of a shape (pixels) fits, and the probability, under a pose that is off by some pixels."""
    plate = marker("plate", rectangle(*(np.array(shape) / 600)), np.eye(3), (0, 0, 0))
    model = ObjectModel("sign", (Component("sign", (plate,), required=True),))
    at = Poses(FACING[None], np.array([[0.01, 0.0, 1.0]]), np.zeros((1, 0)))
    frame = ImageFrame(LabelField(render(CAMERA, [(model, at, RED)])), CAMERA)
    moved = Poses(at.R, at.t + np.array([off_px, off_px, 0.0]) / 600, at.q)
    (verdict,) = verdicts_of(claims_of(WholeObjectFinder(Target("sign", model, RED), DEFAULTS), moved, frame))
    return verdict.evidence.edge, verdict.probability


def test_a_pixel_is_nothing_to_a_wide_marker():
    assert fits((240, 240), 2.0)[0] > 0.5 > 0 > fits((40, 40), 2.0)[0]
    assert fits((240, 240), 2.0)[1] > 0.8 > 0.1 > fits((40, 40), 2.0)[1]


def test_what_is_off_by_more_does_not_fit():
    assert fits((240, 240), 5.0)[0] < 0 and fits((240, 240), 5.0)[1] < 0.1


@pytest.mark.parametrize("off_px", [1.0, 2.0])
def test_a_long_strip_is_looked_at_as_a_narrow_one(off_px):
    """Its width counts: twice its length makes no difference."""
    assert fits((400, 20), off_px)[1] == pytest.approx(fits((200, 20), off_px)[1], abs=0.05)
