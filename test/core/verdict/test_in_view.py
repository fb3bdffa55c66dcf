"""Solids of one colour as they are told: all of their sides in view together."""

import cv2
import numpy as np
import pytest
from solids import BLUE, RED, camera_of, marker, rectangle, render

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Box, Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.io.objects.solids import ball_solid, box_solid

CAMERA = camera_of((640, 480), 600.0)
FROM_ABOVE = np.array([[0, 1, 0], [0.6, 0, -0.8], [-0.8, 0, -0.6]], float)


def crate():
    """A box with a small plate of another class on its top, which tells which way it lies."""
    box = Box(Pose.identity(), np.array([0.16, 0.10, 0.05]))
    plate = marker("plate", rectangle(0.05, 0.05), np.eye(3), (-0.04, 0.0, 0.0251))
    parts = Component("box", box_solid(box)[0], required=True, bodies=(box,)), Component("plate", (plate,), label=BLUE)
    return ObjectModel("crate", parts)


@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.7), (0.3, 0.2, -0.5)])
def test_a_box_is_told_by_all_of_it_that_shows(turn):
    pose = Poses((FROM_ABOVE @ rotation_from_rotvec(turn))[None], np.array([[0.02, -0.03, 1.0]]), np.zeros((1, 0)))
    labels = render(CAMERA, [(crate(), pose, RED)])
    config = RecognizerConfig(time_budget_ms=60000.0)
    recognizer = Recognizer([Target("crate", crate(), RED)], config, Segmenter(ImageConfig()))
    (one,) = recognizer.recognize(labels, CAMERA).detections
    shown = next(c for c in one.components if c.component == "box")
    rows, columns = np.nonzero((labels == RED) | (labels == BLUE))  # the plate lies on it: seen from the camera, too
    assert cv2.contourArea(np.float32(shown.contour)) == pytest.approx(len(rows), rel=0.06)
    outline = np.float32(shown.contour)
    inside = [cv2.pointPolygonTest(outline, xy, True) for xy in np.column_stack([columns, rows]).astype(float).tolist()]
    assert min(inside) > -2
    assert (one.image.x, one.image.y) == (shown.x, shown.y)


def test_a_ball_is_told_by_its_centre():
    (box,), at = crate().components[:1], Pose.from_xyz_rpy((0.02, 0.01, 0.055))
    sides, bodies = ball_solid(0.03, at)
    model = ObjectModel("crate", (box, Component("knob", sides, label=BLUE, bodies=bodies)))
    pose = Poses(
        (FROM_ABOVE @ rotation_from_rotvec((0, 0, 0.7)))[None], np.array([[0.02, -0.03, 1.0]]), np.zeros((1, 0))
    )
    labels = render(CAMERA, [(model, pose, RED)])
    recognizer = Recognizer(
        [Target("crate", model, RED)], RecognizerConfig(time_budget_ms=60000.0), Segmenter(ImageConfig())
    )
    (one,) = recognizer.recognize(labels, CAMERA).detections
    knob = next(c for c in one.components if c.component == "knob")
    assert one.pose is not None
    centre = one.pose.apply(at.position)
    np.testing.assert_allclose((knob.x, knob.y), project(CAMERA, centre[None])[0], atol=1e-6)
    assert knob.scale == pytest.approx(CAMERA.focal_px / centre[2])
