"""The whole method for one image: labels, blobs, alignment, grouping."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import NDArray

from .base.config import RecognizerConfig
from .base.deadline import Deadline
from .base.deferred import Deferred
from .base.errors import ConfigError
from .base.patience import Patience
from .base.stopwatch import Stopwatch
from .blobless import blobless, rootless
from .constraints.constraint_set import ConstraintSet
from .facing_stage import FacingStage
from .flat_stage import FlatStage
from .geometry.camera import Camera
from .geometry.scene import Scene
from .image.blobs import Blob, centres
from .image.codes import LABELS
from .image.first_look import FirstLook, first_look
from .image.image_frame import ImageFrame
from .image.labeller import Labeller
from .memory.memory import Memory
from .memory.recall import Recall
from .model.found import Detection
from .model.frame_result import FrameResult, Rejection, StageResult
from .model.target import Target
from .pose.by_size import SizePlacer
from .pose.on_plane import PlanePlacer
from .spatial_stage import SpatialStage
from .verdict.classify import Classifier
from .verdict.identity import one_of_each
from .warm_up import Told, get_ready, parts_needed
from .ways import FACING, PAPER, PLANE, SPACE, of_way, remembers, way_of


def check_targets(targets: Sequence[Target]) -> None:
    """:raises ConfigError: two targets of one name, or constraints that are not the target's model's."""
    names = [t.name for t in targets]
    if len(set(names)) != len(names):
        raise ConfigError(f"objects: {', '.join(names)}: each needs a name of its own")
    for target in targets:
        if isinstance(target.constraints, ConstraintSet):
            target.constraints.check_model(target.model)


class Recognizer:
    """Finds objects in images. Models are made ready once; what one image tells of the next is
    the caller's to hand on."""

    def __init__(
        self,
        targets: Sequence[Target],
        config: RecognizerConfig,
        segmenter: Labeller,
        *,
        calibrated: bool = True,
        told: Told = lambda share: None,
    ) -> None:
        """Where no earlier start did, it compiles the code that images need: up to a minute.

        :param calibrated: whether images come with a calibration, as far as is known; others are recognised, too.
        :param told: called with the share of the code that is compiled.
        :raises ConfigError: two targets of one name, or constraints that are not the target's model's.
        """
        self._targets = tuple(targets)
        self._config = config
        self._segmenter = segmenter
        check_targets(self._targets)
        self.get_ready(calibrated, told)
        self._flat = {c: FlatStage(self._in_plane(calibrated=c), config, segmenter.blank) for c in (True, False)}
        of = partial(of_way, targets=self._targets, config=config)
        self._spatial = SpatialStage(of(SPACE, calibrated=True), config, segmenter.meaning)
        self._facing = FacingStage(of(FACING, calibrated=False), config, segmenter.meaning)
        self._faces = {c: bool(of(FACING, calibrated=c)) for c in (True, False)}
        self._remembers = {c: remembers(self._targets, config, [c]) for c in (True, False)}
        self._scene = Scene.of(config.scene)
        self._scene_camera: Camera | None = None
        self._by_size, self._on_plane = SizePlacer(self._targets, config), PlanePlacer(self._targets, config)
        self._classifier = Classifier(self._targets if config.profile == "default" else (), config)
        self._models = {t.name: t.model for t in self._targets}
        self._number = {t.name: n for n, t in enumerate(self._targets)}
        self._wanted = {label for target in self._targets for label in target.labels}
        self._on_bodies = {label for target in self._targets for label in target.on_bodies}

    def _in_plane(self, *, calibrated: bool) -> tuple[Target, ...]:
        """Targets whose markers are found one by one."""
        ways = [way_of(t, self._config, calibrated=calibrated) for t in self._targets]
        return tuple(t for t, way in zip(self._targets, ways, strict=True) if way in (PLANE, PAPER))

    def get_ready(self, calibrated: bool, told: Told = lambda share: None) -> None:
        """Have the compiled code for images with or without calibration, before one comes that would wait for it."""
        get_ready(parts_needed(self._targets, self._config, calibrated=calibrated), told)

    def recognize(self, image: NDArray, camera: Camera | None = None) -> FrameResult:
        """All objects in one image, judged by itself.

        :param image: as the segmenter reads it.
        :param camera: calibration; without it no metric poses.
        :raises ImageError: the image does not fit the segmenter's configuration.
        """
        return self._recognize(self.look(image), camera, None)

    def look(self, image: NDArray) -> FirstLook:
        """What `follow` begins with, which asks for no calibration and for no other image.

        :raises ImageError: the image does not fit the segmenter's configuration.
        """
        return first_look(image, self._segmenter, self._config, self._wanted, self._on_bodies)

    def follow(
        self,
        image: NDArray | FirstLook,
        camera: Camera | None,
        stamp_ns: int,
        memory: Memory | None,
        patience: Patience | None = None,
    ) -> tuple[FrameResult, Memory | None]:
        """All objects in the next image of a camera, and what is handed on with the image after that.

        The same images with the same stamps give the same results, whoever holds the memory meanwhile, as long as
        there is patience.

        :param image: as of `recognize`, or what this recogniser's `look` says of it.
        :param memory: that the image before left; None: there was none. :param patience: None: as much as it takes.
        :raises ImageError: as `recognize`; the memory stays.
        """
        look = image if isinstance(image, FirstLook) else self.look(image)
        if not self._remembers[camera is not None]:
            return self._recognize(look, camera, None), None
        height, width = look.image.shape[:2]
        if memory is not None and not memory.holds(stamp_ns, (width, height), camera):
            memory = None
        recall = Recall(memory, stamp_ns, self._config.refresh_s, self._config.recall, patience)
        result = self._recognize(look, camera, recall)
        return result, recall.left(result.size, camera)

    def _recognize(self, look: FirstLook, camera: Camera | None, recall: Recall | None) -> FrameResult:
        self.get_ready(camera is not None)  # it is, but where calibration comes or goes: no clock runs meanwhile
        watch = Stopwatch(look.ms)
        deadline = Deadline(self._config.time_budget_ms / 1e3 - look.took_s)
        deadline.hit = look.cut_short
        labels, segmenter = look.field.labels, self._segmenter
        colours = look.image if segmenter.meaning is not LABELS else None
        frame = ImageFrame(look.field, camera, deadline, colours, self._scene_of(camera), segmenter.gamma)
        calibrated = camera is not None
        flat = self._flat[calibrated]
        with watch.stage("blobs"):
            blobs = _within(frame.scene, look.blobs)
        with watch.stage("alignment"):
            matches = flat.align(frame.hurried(self._config.time.alignment_share), blobs)
        with watch.stage("grouping"):
            detections, rejected, out_of_nodes = flat.group(frame, matches)
            looked_at = () if deadline.hit else blobs
            rejected = _joined(rejected, flat.unmatched(looked_at, matches, detections, rejected))
        with watch.stage("pose"):
            whole: list[StageResult] = []
            whole += [self._facing.recognize(frame, blobs, recall)] if self._faces[calibrated] else []
            whole += [self._spatial.recognize(frame, blobs, recall)] if calibrated else []
            for found in whole:
                mine = sorted(found.detections, key=lambda d: self._number[d.object])
                detections, rejected = (*mine, *detections), _joined(found.rejected, rejected)
            detections, surplus = one_of_each(detections, self._models)
            detections, rejected = self._placed(detections, frame), _joined(surplus, rejected)
        left = self._blobless(labels, blobs, {d.object for d in detections}, frame.scene)
        rejected = _in_image(_joined(left, rejected), frame.size)
        detections = self._classifier.classified(detections)
        doubtful = Deferred(lambda: self._placed(tuple(d for found in whole for d in found.doubtful), frame))
        limits = {"recognizer.time_budget_ms": deadline.hit, "expert.grouping.search_nodes": out_of_nodes}
        ended_by = tuple(name for name, hit in limits.items() if hit)
        waiting = recall.waiting if recall else 0
        return FrameResult(
            frame.size,
            detections,
            rejected,
            watch.stop(),
            ended_by,
            labels,
            waiting,
            not blobs,
            doubtful if self._config.in_doubt else (),
        )

    def _blobless(
        self, labels: NDArray[np.uint8], blobs: Sequence[Blob], told: set[str], scene: Scene
    ) -> Sequence[Rejection]:
        """Why nothing was looked at, or not what an object begins with. :param told: objects that are."""
        least_px, blank = self._config.min_blob_px, self._segmenter.blank
        if not blobs:
            return Deferred(lambda: blobless(labels, self._targets, least_px, blank, scene))
        found = {blob.label for blob in blobs}
        lacking = [t for t in self._targets if t.name not in told and found.isdisjoint(t.root_labels)]
        # where others are told their components are in view, too
        others = blobs if self._config.required == "strict" and not told else ()
        return Deferred(lambda: rootless(labels, lacking, least_px, scene, others)) if lacking else ()

    def _placed(self, detections: tuple[Detection, ...], frame: ImageFrame) -> tuple[Detection, ...]:
        """Those that were found flat with poses: on the plane, where that is known, else by their size."""
        detections = self._on_plane.placed(detections, frame)
        if frame.calibration is None or self._config.profile == "paper":
            return detections
        return self._by_size.placed(detections, frame)

    def _scene_of(self, camera: Camera | None) -> Scene:
        """What is known of the scene in this camera's images: worked out anew only where that is another one."""
        bent = camera if camera is not None and camera.bent else None  # others have nothing to undo
        known = self._scene_camera
        if bent is not known and (bent is None or known is None or not bent.sees_as(known)):
            self._scene, self._scene_camera = Scene.of(self._config.scene, bent), bent
        return self._scene


def _within(scene: Scene, blobs: tuple[Blob, ...]) -> tuple[Blob, ...]:
    """Those with their middles in the region."""
    if scene.region is None:
        return blobs
    return tuple(b for b, inside in zip(blobs, scene.inside(centres(blobs)), strict=True) if inside)


def _in_image(rejected: Sequence[Rejection], size: tuple[int, int]) -> Sequence[Rejection]:
    """The same with places in the image: of what lies beyond it, the nearest."""
    most = np.subtract(size, 1).tolist()

    def moved(r: Rejection) -> Rejection:
        return replace(r, x=min(max(r.x, 0.0), most[0]), y=min(max(r.y, 0.0), most[1]))

    return Deferred(lambda: tuple(map(moved, rejected)))


def _joined(first: Sequence[Rejection], second: Sequence[Rejection]) -> Sequence[Rejection]:
    return Deferred(lambda: (*first, *second))
