"""Whether values are light, told by where marked outlines lie."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from artrec_ros.core.learning.gamma import gamma_of

FINE = 8


def pictures(gamma: float, blur_px: float = 1.2, off_px: float = 0.0, side_px: float = 14.0, ground: float = 40.0):
    """Bright squares on a dark ground, as a lens of this blur shows them, and their outlines."""
    rng = np.random.default_rng(0)
    fine, outlines = np.full((160 * FINE, 200 * FINE, 3), ground, np.float32), []
    for centre in np.stack(np.meshgrid(np.arange(25, 180, 37), np.arange(25, 140, 37)), -1).reshape(-1, 2):
        at, turn = centre + rng.uniform(0, 1, 2), rng.uniform(0, 90)
        corners = cv2.boxPoints(((0, 0), (side_px, side_px), turn))
        cv2.fillPoly(fine, [np.rint((corners + at + 0.5) * FINE - 0.5).astype(int)], (60, 170, 220))
        outlines.append(corners * (side_px + 2 * off_px) / side_px + at)
    light = cv2.resize((fine / 255) ** gamma, (200, 160), interpolation=cv2.INTER_AREA)
    values = 255 * cv2.GaussianBlur(light, (0, 0), blur_px) ** (1 / gamma)
    return [(np.clip(np.rint(values + rng.normal(0, 2, values.shape)), 0, 255).astype(np.uint8), outlines)]


@pytest.mark.parametrize("gamma", [1.0, 2.2])
@pytest.mark.parametrize("blur_px", [0.8, 1.2, 2.0])
@pytest.mark.parametrize("clockwise", [True, False])
def test_a_cameras_gamma_is_told(gamma: float, blur_px: float, clockwise: bool) -> None:
    images = [(image, [o[:: 1 if clockwise else -1] for o in outlines]) for image, outlines in pictures(gamma, blur_px)]
    assert gamma_of(images) == gamma


def test_what_is_marked_a_little_too_small_or_too_large_is_no_gamma() -> None:
    assert gamma_of(pictures(1.0, off_px=-0.1)) == gamma_of(pictures(1.0, off_px=0.3)) == 1.0


def test_without_bright_markers_nothing_is_told() -> None:
    assert gamma_of([]) == gamma_of(pictures(2.2, ground=230.0)) == 1.0
    (image, outlines), *_ = pictures(2.2)
    assert gamma_of([(image, [o * 0.01 for o in outlines])]) == 1.0
