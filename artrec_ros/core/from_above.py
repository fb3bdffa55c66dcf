"""Frames as a camera straight above the scene's plane would see them, and what is found there brought back."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from .base.config import RecognizerConfig
from .base.deferred import Deferred
from .geometry.camera import Camera
from .geometry.range_limits import scale_limits
from .geometry.scene import Scene
from .geometry.top_view import TopView
from .geometry.transforms import Array
from .image.blobs import Blob, centres, find_blobs
from .image.codes import OUTSIDE
from .image.image_frame import ImageFrame
from .image.label_field import LabelField
from .model.found import Detection, ImagePose, Instance, Missing, OtherPlace
from .model.frame_result import Rejection, StageResult
from .verdict.reach import Reach

_HALVINGS = 9  # of the way to what is behind the camera: farther than a hundred images off nobody looks


class FromAbove:
    """Keeps the view of the last scene: it takes longer to make than to look through."""

    def __init__(self, config: RecognizerConfig, labels: Iterable[int]) -> None:
        """:param labels: classes whose blobs are looked for."""
        self._config, self._labels = config, set(labels)
        self._last: tuple[Scene, tuple[int, int], TopView | None] | None = None

    def view(self, frame: ImageFrame) -> TopView | None:
        """Of the plane on which objects lie; None where there is none, or the camera itself looks straight at it."""
        if self._last is None or self._last[0] is not frame.scene or self._last[1] != frame.size:
            limits = scale_limits(self._config, frame.calibration)
            view = TopView.of(frame.scene, frame.size, limits, self._config.facing)
            self._last = frame.scene, frame.size, view
        return self._last[2]

    def seen(self, frame: ImageFrame, view: TopView) -> tuple[ImageFrame, tuple[Blob, ...]]:
        """The frame as it is from above, and the blobs in it."""
        codes, of = view.codes(frame.field.blanked(OUTSIDE), OUTSIDE), frame.field
        field = LabelField(codes, self._config.seams, of.meaning, on_bodies=of.on_bodies)
        image = None if frame.image is None else view.colours(frame.image)
        camera = Camera.facing(view.size)
        above = replace(frame, field=field, calibration=camera, image=image, scene=view.scene)
        blobs = find_blobs(field.labels, self._labels, self._config, deadline=frame.deadline)
        inside = view.scene.inside(centres(blobs)) if blobs else np.zeros(0, bool)
        return above, tuple(b for b, yes in zip(blobs, inside, strict=True) if yes)


def back_in_image(found: StageResult, view: TopView) -> StageResult:
    """What was found in a view, as the image shows it."""
    return StageResult(
        in_image(found.detections, view),
        Deferred(lambda: (_rejection_in_image(r, view) for r in found.rejected)),
        Deferred(lambda: in_image(found.doubtful, view)),
    )


def in_image(detections: Sequence[Detection], view: TopView) -> tuple[Detection, ...]:
    """Detections with all that they tell in pixels where it is in the image."""
    if not detections:
        return ()
    placed = np.array([(p.x, p.y, p.theta, p.scale) for d in detections for p in _placed(d)])
    placed[:, :2] = _before_camera(placed[:, :2], view)
    at, theta, larger = view.turned(placed[:, :2], placed[:, 2])
    contours = [part.contour for d in detections for part in d.components]
    ends = np.cumsum([len(c) for c in contours])
    outlines = iter(np.split(view.in_image(np.concatenate([np.zeros((0, 2)), *contours])), ends[:-1]))
    rows = iter(np.column_stack([at, theta, larger * placed[:, 3]]).tolist())
    return tuple(
        replace(
            d,
            image=ImagePose(*next(rows)),
            other_place=None if d.other_place is None else _elsewhere(d.other_place, next(rows), view),
            components=tuple(_instance(part, next(rows), next(outlines)) for part in d.components),
            missing=tuple(_missing(part, view) for part in d.missing),
        )
        for d in detections
    )


def _placed(detection: Detection) -> Iterator[ImagePose | Instance]:
    yield detection.image
    if detection.other_place is not None:
        yield detection.other_place.image
    yield from detection.components


def _elsewhere(place: OtherPlace, there: Sequence[float], view: TopView) -> OtherPlace:
    told = None if place.told is None else in_image((place.told,), view)[0]
    return replace(place, image=ImagePose(*there), told=told)


def _instance(part: Instance, there: Sequence[float], contour: Array) -> Instance:
    x, y, theta, scale = there
    return replace(part, x=x, y=y, theta=theta, scale=scale, contour=contour)


def _missing(part: Missing, view: TopView) -> Missing:
    x, y = view.in_image(_before_camera(np.array([[part.x, part.y]]), view))[0].tolist()
    return replace(part, x=x, y=y)


def _before_camera(pixels: Array, view: TopView) -> Array:
    """(n, 2) pixels of a view; what lies behind the camera is nowhere in the image, and moved towards the view's middle
    until it is just before it."""
    lost = ~np.isfinite(view.in_image(pixels)).all(axis=1)
    if not lost.any():
        return pixels
    middle = (np.array(view.size) - 1) / 2
    out, way = pixels.copy(), pixels[lost] - middle
    shown, hidden = np.zeros((len(way), 1)), np.ones((len(way), 1))  # shares of the way
    for _ in range(_HALVINGS):
        share = (shown + hidden) / 2
        before = np.isfinite(view.in_image(middle + share * way)).all(axis=1, keepdims=True)
        shown, hidden = np.where(before, share, shown), np.where(before, hidden, share)
    out[lost] = middle + shown * way
    return out


def within(
    detections: Sequence[Detection], reach: Reach, camera: Camera | None
) -> tuple[tuple[Detection, ...], tuple[Rejection, ...]]:
    """Those that are in reach by their scale in the image, and the others, which are none.

    :param camera: that took the image, by which a scale tells a range; None: it does not.
    """
    focal_px = math.nan if camera is None else camera.focal_px
    reasons = [reach.reason(focal_px / d.image.scale, d.image.scale) for d in detections]
    both = list(zip(detections, reasons, strict=True))
    others = tuple(Rejection(d.object, why, d.score, d.image.x, d.image.y) for d, why in both if why is not None)
    return tuple(d for d, why in both if why is None), others


def _rejection_in_image(rejection: Rejection, view: TopView) -> Rejection:
    x, y = view.in_image(_before_camera(np.array([[rejection.x, rejection.y]]), view))[0].tolist()
    return replace(rejection, x=x, y=y)
