"""Recognition of spatial objects in one frame: candidates of all targets, their pixels shared out, verdicts."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .base.config import RecognizerConfig
from .base.deadline import Deadline
from .geometry.camera import Camera
from .geometry.projection import project
from .image.blobs import Blob
from .image.label_field import LabelField
from .model.found import Detection, Rejection
from .model.target import Target
from .pose.finder import WholeObjectFinder
from .spatial_search import SpatialSearch
from .verdict.acceptance import Verdict
from .verdict.descriptions import Describer
from .verdict.ownership import share_out

_SEARCH = 0.9  # of the time that is left may go into the search; the rest is for judging what it found


class SpatialStage:
    """Finds the targets whose markers have places in space, in images of a calibrated camera."""

    def __init__(self, targets: Sequence[Target], config: RecognizerConfig) -> None:
        self._finders = [WholeObjectFinder(t) for t in targets]
        self._describers = [Describer(f) for f in self._finders]
        self._config = config
        for finder in self._finders:
            finder.warm_up()

    def recognize(
        self, labels: np.ndarray, blobs: Sequence[Blob], camera: Camera, deadline: Deadline
    ) -> tuple[tuple[Detection, ...], tuple[Rejection, ...]]:
        """Detections by target and score, and what was turned down, with reasons."""
        field = LabelField(labels)
        least = self._config.min_votes
        search = SpatialSearch(field, camera, deadline.part(_SEARCH), self._trust, least)
        found = search.run(self._finders, blobs)
        accepted, others = share_out(found, field, camera, least, self._trust, deadline)
        detections = [
            detection
            for finder, describer in zip(self._finders, self._describers, strict=True)
            for detection in describer.describe([v for v in accepted if v.claim.finder is finder], field, camera)
        ]
        return tuple(detections), tuple(self._rejection(v, camera) for v in others)

    def _trust(self, verdict: Verdict) -> float:
        return verdict.probability if verdict.is_object(self._config) else 0.0

    def _rejection(self, verdict: Verdict, camera: Camera) -> Rejection:
        x, y = project(camera, verdict.claim.poses.t)[0]
        name, reason = verdict.claim.finder.target.name, verdict.reason(self._config) or "its pixels belong to another"
        return Rejection(name, reason, verdict.probability, float(x), float(y))
