"""Objects that are one flat marker whose middle lies beside it, and large ones of which votes see few points."""

import cv2
import numpy as np
import pytest
from settings import settings
from squares import TEAM, Placing, patch

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.transforms import wrap_angle
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer


def ring(gap=1.2, radius=0.1, wide=0.02):
    """(n, 2) a ring that is open at its right."""
    way = np.linspace(gap / 2, 2 * np.pi - gap / 2, 60)
    around = np.column_stack([np.cos(way), np.sin(way)])
    return np.vstack([(radius + wide / 2) * around, (radius - wide / 2) * around[::-1]])


def wave(wide=0.02):
    """(n, 2) of one and a half crests, the last one flatter."""
    x = np.linspace(-0.12, 0.12, 60)
    y = np.where(x < 0.04, 0.05, 0.035) * np.sin(3 * np.pi * (x + 0.12) / 0.24)
    return np.vstack([np.column_stack([x, y - wide / 2]), np.column_stack([x, y + wide / 2])[::-1]])


def plate():
    """(8, 2) with a notch at one side, and long."""
    notch = [(-0.05, 0.04), (-0.05, 0.03), (-0.062, 0.03), (-0.062, 0.04)]
    return np.array([(-0.1, -0.04), (0.1, -0.04), (0.1, 0.04), *notch, (-0.1, 0.04)])


def drawn(outline, placing, size):
    image = np.zeros((size, size), np.uint8)
    at = np.rint(16 * placing.at(outline)).astype(np.int32)
    return cv2.fillPoly(image, [at], TEAM, shift=4)


def detections_of(outline, image):
    target = Target("lone", ObjectModel("lone", (Component("lone", (patch("lone", outline),), required=True),)), TEAM)
    recognizer = Recognizer([target], settings(), Segmenter(ImageConfig()), calibrated=False)
    return recognizer.recognize(image).detections


def found(outline, placing, size):
    (detection,) = detections_of(outline, drawn(outline, placing, size))
    return detection


@pytest.mark.parametrize("turn", [0.2, 1.3, -2.4])
@pytest.mark.parametrize("outline", [ring(), ring(0.9), wave()], ids=["ring", "closer", "wave"])
def test_what_has_its_middle_beside_it_is_found_and_turned_right(outline, turn):
    placing = Placing(100.0, 100.0, turn, 700.0)
    detection = found(outline, placing, 200)
    assert detection.score > 0.9
    assert abs(wrap_angle(detection.image.theta + turn)) < np.radians(1)
    assert detection.image.scale == pytest.approx(700.0, rel=0.01)


@pytest.mark.parametrize("turn", [0.0, 1.57])
def test_a_large_outline_is_as_large_as_its_pixels_say(turn):
    """Few points of it are looked up: one that is somewhat larger has more votes."""
    detection = found(plate(), Placing(350.0, 350.0, turn, 3000.0), 700)
    assert abs(wrap_angle(detection.image.theta + turn)) < np.radians(0.5)
    assert detection.image.scale == pytest.approx(3000.0, rel=0.01)


def squeezed(outline, way, slant):
    """An outline that is turned out of the image plane about an axis at an angle `way` in it."""
    across = np.array([-np.sin(way), np.cos(way)])
    return outline - np.outer(outline @ across, across) * (1 - np.cos(slant))


def exactly(outline, placing, size, zoom=8):
    """A picture of pixels more than half of which the outline covers; the library paints its border, too."""
    at = np.rint(16 * (zoom * (placing.at(outline) + 0.5) - 0.5)).astype(np.int32)
    large = cv2.fillPoly(np.zeros((zoom * size, zoom * size), np.uint8), [at], 255, shift=4)
    return np.where(cv2.resize(large, (size, size), interpolation=cv2.INTER_AREA) > 127, TEAM, 0).astype(np.uint8)


@pytest.mark.parametrize("way", [0.3, 1.2, 2.6])
@pytest.mark.parametrize("turn", [0.4, -2.0])
def test_what_is_open_and_thin_is_found_at_a_slant(turn, way):
    """Squeezed by more than it is wide, no similarity lies on all of it."""
    hook, placing = ring(wide=0.01), Placing(130.0, 130.0, turn, 1000.0)
    (detection,) = detections_of(hook, exactly(squeezed(hook, way, np.radians(20)), placing, 260))
    assert detection.score > 0.6
    # the gap of one that is squeezed lies a little elsewhere
    assert abs(wrap_angle(detection.image.theta + turn)) < np.radians(8)
    assert detection.image.scale == pytest.approx(1000.0, rel=0.04)


def test_what_faces_the_camera_is_told_so():
    """Slanted a little it would be as near to its labels, and larger."""
    outline, placing = ring(wide=0.01), Placing(130.0, 130.0, 0.4, 1000.0)
    (detection,) = detections_of(outline, exactly(outline, placing, 260))
    assert detection.score > 0.95
    assert detection.image.scale == pytest.approx(1000.0, rel=0.003)
