"""How blurred edges are, measured near what is marked."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from artrec_ros.core.learning.lens_blur import lens_blur

FINE = 8  # samples along a pixel's side
IGNORED = 255


def squares(blur_px: float, side_px: int = 14, noise: float = 2.0, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Red squares, turned anyhow, on a grey floor (160, 200), as a lens of this blur shows them; and where they are."""
    rng = np.random.default_rng(seed)
    fine = np.full((160 * FINE, 200 * FINE, 3), 90, np.float32)
    marked = np.zeros((160, 200), np.uint8)
    for centre in np.stack(np.meshgrid(np.arange(25, 180, 37), np.arange(25, 140, 37)), -1).reshape(-1, 2):
        box = cv2.boxPoints(((0, 0), (side_px, side_px), rng.uniform(0, 90))) + centre + rng.uniform(0, 1, 2)
        cv2.fillPoly(fine, [np.rint((box + 0.5) * FINE).astype(int)], (40, 45, 190))
        cv2.fillPoly(marked, [np.rint(box).astype(int)], 1)
    image = cv2.resize(fine, (200, 160), interpolation=cv2.INTER_AREA)
    image = cv2.GaussianBlur(image, (0, 0), blur_px) if blur_px else image
    return np.clip(np.rint(image + rng.normal(0, noise, image.shape)), 0, 255).astype(np.uint8), marked


@pytest.mark.parametrize("blur_px", [0.7, 0.8, 1.0, 1.5, 2.0])
@pytest.mark.parametrize("side_px", [12, 24])
def test_blur_is_told_and_not_what_pixels_and_gradients_add(blur_px: float, side_px: int) -> None:
    """Patches' edges run into each other, and look a little sharper."""
    told = lens_blur([squares(blur_px, side_px), squares(blur_px, side_px, seed=1)], IGNORED)
    assert 0.8 * blur_px < told < 1.03 * blur_px


@pytest.mark.parametrize("blur_px", [3.0, 6.0])
def test_much_blur_is_told_as_no_more_than_can_be_undone(blur_px: float) -> None:
    assert 1.8 < lens_blur([squares(blur_px, 34, noise=0.5)], IGNORED) <= 4.0


def test_sharp_images_are_told_to_be_sharp() -> None:
    assert lens_blur([squares(0.0), squares(0.4, seed=1)], IGNORED) == 0


def test_edges_far_from_what_is_marked_do_not_count() -> None:
    """Things in front of the floor, out of focus."""
    image, marked = squares(0.0)
    far = squares(3.0, seed=4)[0]
    wide = np.concatenate([image, far, far], axis=1)
    here = np.pad(marked, ((0, 0), (0, 400)))
    assert lens_blur([(wide, here)], IGNORED) == 0
    assert lens_blur([(wide, np.where(here == 0, IGNORED, here))], IGNORED) == 0


def test_without_edges_nothing_is_told() -> None:
    plain = np.full((60, 60, 3), 90, np.uint8)
    marked = np.zeros((60, 60), np.uint8)
    assert lens_blur([], IGNORED) == lens_blur([(plain, marked)], IGNORED) == 0
    marked[20:30, 20:30] = 1
    assert lens_blur([(plain, marked)], IGNORED) == 0
