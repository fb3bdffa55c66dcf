"""How far a class goes on beyond marked outlines."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.config import ClassConfig, ImageConfig
from artrec_ros.core.learning.outline_reach import rings_px

RED = (180, 40, 40)


@pytest.mark.parametrize("zoom", [1, 4])
def test_a_ring_is_told_as_a_share_of_its_marker(zoom: int) -> None:
    """The same marker near and far: what is painted reaches an eighth of its width farther than what is drawn."""
    image = np.zeros((80 * zoom, 100 * zoom, 3), np.uint8)
    low, high, ring = np.array([30, 30]) * zoom, np.array([70, 54]) * zoom, 4 * zoom
    x, y = low - ring
    image[y : high[1] + ring, x : high[0] + ring] = RED[::-1]
    numbers = np.zeros(image.shape[:2], np.uint8)
    cv2.rectangle(numbers, low.tolist(), (high - 1).tolist(), 1, cv2.FILLED)
    outline = np.array([low, (high[0], low[1]), high, (low[0], high[1])], float) - 0.5
    config = ImageConfig(kind="colour", classes={"red": ClassConfig(3, RED)})
    assert rings_px(config, [(image, numbers, [("red", outline)])]) == {"red": pytest.approx(ring, abs=0.5)}
