"""What the recogniser is compared with: contours alone, OpenCV's generalized Hough transform, and ArUco tags."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from artrec_ros.core.model.marker import Marker

Work = Callable[[], object]
_TAGS = cv2.aruco.getPredefinedDictionary(cv2.aruco.DICT_4X4_50)
_TEMPLATE_PX = 60  # longer side of the shape that the generalized Hough transform is given


def contours_alone(labels: NDArray[np.uint8], classes: Sequence[int]) -> Work:
    """The floor: external contours of each class in use."""

    def work() -> None:
        for label in classes:
            cv2.findContours((labels == label).view(np.uint8), cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)

    return work


def generalized_hough(labels: NDArray[np.uint8], classes: Sequence[int], marker: Marker) -> Work:
    """Guil's variant: one shape, any turn in steps of 2 degrees, scales from 0.5 to 2, in each class."""
    outline = marker.image_outline - marker.image_outline.min(axis=0)
    polygon = outline * (_TEMPLATE_PX / outline.max()) + 8
    template = np.zeros(np.ceil(polygon.max(axis=0)).astype(int)[::-1] + 8, np.uint8)
    cv2.fillPoly(template, [np.rint(polygon).astype(np.int32)], 255)
    hough = cv2.createGeneralizedHoughGuil()
    hough.setMinDist(10)
    hough.setAngleStep(2)
    hough.setMinScale(0.5)
    hough.setMaxScale(2)
    hough.setScaleStep(0.05)
    hough.setAngleThresh(500)  # OpenCV's defaults find nothing as small as a marker
    hough.setScaleThresh(100)
    hough.setPosThresh(20)
    hough.setTemplate(template)
    masks = [np.where(labels == label, 255, 0).astype(np.uint8) for label in classes]

    def work() -> None:
        for mask in masks:
            hough.detect(mask)

    return work


def with_tags(image: NDArray[np.uint8], count: int, rng: np.random.Generator) -> NDArray[np.uint8]:
    """The picture with `count` ArUco tags on white cards, none on another, each turned by up to 20 degrees."""
    out, columns = image.copy(), int(np.ceil(np.sqrt(count * image.shape[1] / image.shape[0])))
    cell = min(image.shape[1] / columns, image.shape[0] / np.ceil(count / columns))
    side = int(min(0.6 * cell, 0.25 * image.shape[0]))
    for n in range(count):
        tag, wide = cv2.aruco.generateImageMarker(_TAGS, n, side), side // 6
        card = cv2.copyMakeBorder(tag, wide, wide, wide, wide, cv2.BORDER_CONSTANT, value=255)
        centre = (np.array([n % columns, n // columns]) + 0.5) * cell
        turn = cv2.getRotationMatrix2D(((card.shape[1] - 1) / 2,) * 2, rng.uniform(-20, 20), 1.0)
        turn[:, 2] += centre - (card.shape[1] - 1) / 2
        size = (image.shape[1], image.shape[0])
        where = cv2.warpAffine(np.full_like(card, 255), turn, size)
        drawn = cv2.warpAffine(card, turn, size, borderValue=255)
        out = np.where(where[..., None] > 127, drawn[..., None], out)
    return out


def aruco(image: NDArray[np.uint8]) -> tuple[Work, int]:
    """ArUco detection as it comes, and how many tags it finds."""
    detector = cv2.aruco.ArucoDetector(_TAGS)
    grey = cv2.cvtColor(image, cv2.COLOR_BGR2GRAY)
    ids = detector.detectMarkers(grey)[1]
    return (lambda: detector.detectMarkers(grey)), 0 if ids is None else len(ids)
