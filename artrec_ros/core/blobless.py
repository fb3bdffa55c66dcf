"""Why an image leaves no blob in which an object could be looked for, or none of its required component."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import cv2
import numpy as np
from numpy.typing import NDArray

from .geometry.scene import Scene
from .image.blobs import Blob
from .image.segmentation import rectangles
from .model.frame_result import Rejection
from .model.target import Target

NO_PIXEL = "no pixel of the image"
_SPECK = 0.5  # of the least that is looked at: beside blobs of others, what has less is noise


def blobless(
    labels: NDArray[np.uint8], targets: Sequence[Target], min_blob_px: float, blank: tuple[int, ...], scene: Scene
) -> Iterator[Rejection]:
    """The reason for each object of which there would be something to see. To be asked where no blob was found.

    :param labels: (H, W) class number per pixel. :param blank: ignored rectangles x,y,width,height,...
    """
    left_out = _left_out(labels.shape, blank, scene)
    for target in targets:
        if left_out:
            yield Rejection(target.name, left_out)
        else:
            yield from _small_or_outside(target.name, np.isin(labels, list(target.labels)), min_blob_px, scene)


def rootless(
    labels: NDArray[np.uint8],
    targets: Sequence[Target],
    min_blob_px: float,
    scene: Scene,
    others: Sequence[Blob] = (),
) -> Iterator[Rejection]:
    """The same of objects of whose required component no blob was found, where others were: what of it is as good as
    large enough, else those of its other components.

    :param others: blobs that may be other components', with which nothing is begun.
    """
    for target in targets:
        mask = np.isin(labels, list(target.root_labels))
        least_px = _SPECK * min_blob_px
        small = [
            *_small_or_outside(target.name, mask, min_blob_px, scene, "its required component's classes", least_px)
        ]
        yield from small or _headless(target, labels, [b for b in others if b.label in target.labels])


def _headless(target: Target, labels: NDArray[np.uint8], blobs: Sequence[Blob]) -> Iterator[Rejection]:
    """Of an object whose other components' classes show."""
    if not blobs:
        return
    areas_px = _areas_px(labels, blobs)
    x, y = blobs[int(np.argmax(areas_px))].middle.tolist()
    reason = (
        f"its required component {target.model.required.name} does not show; {len(blobs)} blobs of its others' classes "
        f"do, the largest of {max(areas_px)} pixels: nothing is begun with them (see recognizer.required)"
    )
    yield Rejection(target.name, reason, 0.0, x, y)


def _areas_px(labels: NDArray[np.uint8], blobs: Sequence[Blob]) -> list[int]:
    """How many pixels of its class each of some blobs has, what its contour encloses beside them not counted."""
    out = []
    for blob in blobs:
        (left, top), (right, bottom) = blob.box.tolist()
        own = (labels[top : bottom + 1, left : right + 1] == blob.label).view(np.uint8)
        _, part, stats, _ = cv2.connectedComponentsWithStats(own, connectivity=8)
        x, y = (blob.pixels[0] - blob.box[0]).tolist()
        out.append(int(stats[part[y, x], cv2.CC_STAT_AREA]))
    return out


def _left_out(shape: tuple[int, ...], blank: tuple[int, ...], scene: Scene) -> str:
    """Which parameter leaves nothing at all of an image of this shape (H, W); empty: none."""
    left = np.ones(shape, np.uint8)
    for rectangle in rectangles(blank):
        left[rectangle] = 0
    if not left.any():
        return f"image.blank leaves {NO_PIXEL}"
    rows, columns = np.nonzero(left)
    return "" if scene.inside(np.column_stack([columns, rows])).any() else f"scene.region leaves {NO_PIXEL}"


def _small_or_outside(
    name: str,
    mask: NDArray[np.bool_],
    min_blob_px: float,
    scene: Scene,
    classes: str = "its classes",
    least_px: float = 0.0,
) -> Iterator[Rejection]:
    """:param least_px: where all is smaller than this nothing is told."""
    count, _, stats, middles = cv2.connectedComponentsWithStats(mask.view(np.uint8), connectivity=8)
    areas, middles = stats[1:, cv2.CC_STAT_AREA], middles[1:]
    if count == 1 or areas.max() < least_px:  # the background alone, or noise beside it
        return
    inside = scene.inside(middles)
    reason = f"all {len(areas)} blobs of {classes} lie outside scene.region"
    if inside.any():
        areas, middles = areas[inside], middles[inside]
        if areas.max() >= min_blob_px:  # it was not looked at for want of time
            return
        reason = (
            f"{len(areas)} blobs of {classes}, the largest of {areas.max()} pixels, fewer than "
            f"recognizer.min_blob_px {min_blob_px:g}"
        )
    x, y = middles[areas.argmax()].tolist()
    yield Rejection(name, reason, 0.0, x, y)
