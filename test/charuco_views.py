"""Views of a ChArUco board through a camera that is known, for docs/camera.md."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np

MATRIX = np.array([[620.0, 0.0, 323.4], [0.0, 618.0, 236.1], [0.0, 0.0, 1.0]])
DISTORTION = np.array([-0.21, 0.07, 0.0008, -0.0006, 0.0])
_SIZE, _SAMPLES, _BOARD = (640, 480), 2, np.array([0.28, 0.20])


def write(folder: Path, count: int, seed: int = 0) -> None:
    """Renders `count` views with blur and noise as PNG files in `folder`."""
    folder.mkdir()
    rng = np.random.default_rng(seed)
    board = cv2.aruco.CharucoBoard((7, 5), 0.04, 0.03, cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_5X5_100))
    printed = board.generateImage((560, 400))
    rays = _rays()
    for n in range(count):
        R = cv2.Rodrigues(rng.normal(0, 0.35, 3))[0]
        t = np.array([*rng.uniform(-0.08, 0.08, 2), rng.uniform(0.3, 0.5)]) - R @ np.append(_BOARD / 2, 0)
        depth = (R[:, 2] @ t) / (rays @ R[:, 2])  # of the board's plane along each line of sight
        at = ((rays * depth[:, None] - t) @ R)[:, :2] * (560 / _BOARD[0]) - 0.5
        x, y = at.T.reshape(2, _SIZE[1] * _SAMPLES, _SIZE[0] * _SAMPLES).astype(np.float32)
        fine = cv2.remap(printed, x, y, cv2.INTER_LINEAR, borderValue=150)
        image = cv2.GaussianBlur(cv2.resize(fine, _SIZE, interpolation=cv2.INTER_AREA), (0, 0), 0.7)
        noisy = np.clip(image + rng.normal(0, 3, image.shape), 0, 255).astype(np.uint8)
        cv2.imwrite(str(folder / f"{n:02d}.png"), noisy)


def _rays() -> np.ndarray:
    """(n, 3) where each sample's line of sight crosses the plane z = 1."""
    u, v = (((np.arange(side * _SAMPLES) + 0.5) / _SAMPLES) - 0.5 for side in _SIZE)
    pixels = np.stack(np.meshgrid(u, v), axis=-1).reshape(-1, 1, 2)
    plane = cv2.undistortPoints(pixels, MATRIX, DISTORTION).reshape(-1, 2)
    return np.column_stack([plane, np.ones(len(plane))])
