"""Blobs that nothing explains."""

import cv2
import numpy as np
import pytest
from settings import DEFAULTS

from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.codes import OWNED
from artrec_ros.core.image.label_field import LabelField

RED = 3


def image_of(radius):
    image = np.zeros((60, 80), np.uint8)
    cv2.circle(image, (40, 30), radius, RED, cv2.FILLED)
    return image


@pytest.mark.parametrize("bleeds", [0, 1, 2])
def test_what_somebody_owns_is_told_by_the_blobs_pixels(bleeds):
    """Blur carries a colour beyond the edge of the marker that owns it: of the contour nothing may be owned."""
    image = image_of(8 + bleeds)
    (blob,) = find_blobs(image, [RED], DEFAULTS)
    owned = image.copy()
    owned[image_of(8) == RED] = OWNED
    assert LabelField(owned).owned_inside(blob.pixels) > 0.6
    assert LabelField(image).owned_inside(blob.pixels) == 0.0


def test_a_blob_at_the_border_is_measured_within_the_image():
    image = np.zeros((40, 50), np.uint8)
    image[:9, 40:] = RED
    (blob,) = find_blobs(image, [RED], DEFAULTS)
    half = image.copy()
    half[:9, 45:] = OWNED
    assert LabelField(half).owned_inside(blob.pixels) == pytest.approx(0.5)
