"""What is hardly meant in a camera's calibration."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...core.geometry.camera import Camera

_OFF_MIDDLE, _TIMES_NEARER = 0.08, 4.0  # share of the image's sides that its axis is off its middle, where cx and cy
_FAR_OFF_MIDDLE = 0.4  # exchanged are so much nearer; and in any case
_SQUARE = 1.1  # of focal lengths, as far as pixels are square


def odd_calibration(camera: Camera) -> Iterator[str]:
    """A line for each number that is hardly meant, though some lens may have it."""
    (fx, _, cx), (_, fy, cy) = camera.matrix[:2].tolist()
    middle = (np.array(camera.size) - 1) / 2
    off, exchanged = (np.abs(np.array(c) - middle) / camera.size for c in ((cx, cy), (cy, cx)))
    at = f"the optical axis meets a {camera.size[0]}x{camera.size[1]} image at {cx:.0f}, {cy:.0f}"
    if (off > _FAR_OFF_MIDDLE).any():
        yield f"{at}, far off its middle: are these cx and cy, and of this image?"
    elif off.max() > _OFF_MIDDLE and off.max() > _TIMES_NEARER * exchanged.max():
        yield f"{at}; are cx and cy, or width and height, exchanged?"
    if max(fx, fy) > _SQUARE * min(fx, fy):
        yield f"focal lengths of {fx:.0f} and {fy:.0f} px: pixels are square but in squeezed films"
