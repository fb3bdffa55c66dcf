"""Recognition of whole objects that face the camera, in images of any camera: figures of the image plane, and of the
plane on which they lie where that is known."""

from __future__ import annotations

from collections.abc import Sequence

from .base.config import RecognizerConfig
from .base.deferred import Deferred
from .facing_search import FacingSearch
from .geometry.range_limits import scale_limits
from .image.blobs import Blob
from .image.codes import LABELS, Codes
from .image.image_frame import ImageFrame
from .model.found import Detection, Rejection
from .model.target import Target
from .pose.finder import WholeObjectFinder
from .pose.on_plane import PlanePlacer
from .verdict.descriptions import Describer, rejection_of
from .verdict.judge import Judge
from .verdict.ownership import share_out


class FacingStage:
    """Finds flat targets, whose place, turn and scale in the image are told, and the pose on the scene's plane."""

    def __init__(self, targets: Sequence[Target], config: RecognizerConfig, codes: Codes = LABELS) -> None:
        self._config = config
        self._searches = [FacingSearch(WholeObjectFinder(t, config, codes, facing=True), config) for t in targets]
        self._describers = [Describer(s.finder) for s in self._searches]
        self._judge = Judge.of(config)
        self._placer = PlanePlacer(targets, config)

    def recognize(self, frame: ImageFrame, blobs: Sequence[Blob]) -> tuple[tuple[Detection, ...], Sequence[Rejection]]:
        """Detections by target and score, and what was turned down, with reasons: worked out when looked at."""
        if not self._searches:
            return (), ()
        limits, faced = scale_limits(self._config, frame.calibration), frame.faced()
        share, n = self._config.facing.search_share, len(self._searches)
        hurried = faced.hurried(share)
        found = [(s.finder, s.run(hurried.hurried(1 / (n - i)), blobs, limits)) for i, s in enumerate(self._searches)]
        accepted, others = share_out(found, faced.hurried(self._config.facing.judge_share), self._judge)
        detections = [
            self._placer.faced(detection, faced)
            for describer in self._describers
            for detection in describer.describe([v for v in accepted if v.claim.finder is describer.finder], faced)
        ]
        return tuple(detections), Deferred(lambda: tuple(rejection_of(v, faced, self._judge) for v in others))
