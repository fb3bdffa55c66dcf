"""What of a frame is shown beside results in other programs: its image, its classes, its camera."""

from __future__ import annotations

from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from ...core.geometry.camera import Camera
from ...core.image.segmentation import Segmenter
from ...io.sources.frames import Frame

_JPEG_QUALITY = 90


@dataclass(frozen=True)
class RawFrame:
    """An image as it came, before anything is drawn on it.

    :param labels: (H, W) class numbers, PNG: they compress to a fraction, and come from other processes or machines.
    :param image: the colour image, JPEG; None: the image holds class numbers.
    """

    labels: bytes = field(repr=False)
    image: bytes | None = field(repr=False)
    camera: Camera | None

    @classmethod
    def of(cls, frame: Frame, segmenter: Segmenter) -> RawFrame | None:
        """None where there is no image, or none of the kind that the parameters say."""
        if frame.image is None:
            return None
        image = None if frame.image.ndim == 2 else encoded(".jpg", frame.image, cv2.IMWRITE_JPEG_QUALITY, _JPEG_QUALITY)
        return cls(encoded(".png", segmenter.labels(frame.image), cv2.IMWRITE_PNG_COMPRESSION, 1), image, frame.camera)

    def classes(self) -> NDArray[np.uint8]:
        """(H, W) class numbers."""
        return np.asarray(cv2.imdecode(np.frombuffer(self.labels, np.uint8), cv2.IMREAD_UNCHANGED), np.uint8)


def encoded(suffix: str, image: NDArray[np.uint8] | NDArray[np.uint16], *options: int) -> bytes:
    return bytes(cv2.imencode(suffix, image, options)[1])
