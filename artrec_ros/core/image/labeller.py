"""What the recogniser asks of that which reads its images."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from .codes import Codes


class Labeller(Protocol):
    """What turns an image into class labels: `segmentation.Segmenter`."""

    @property
    def blank(self) -> tuple[int, ...]:
        """Ignored rectangles x,y,width,height,..."""

    @property
    def meaning(self) -> Codes:
        """Of the codes that it reads."""

    @property
    def gamma(self) -> float:
        """Values of images grow with light to the power of its reciprocal."""

    def codes(self, image: NDArray) -> NDArray[np.uint8]:
        """(H, W) what pixels show."""
