"""Recognition of spatial objects in one frame: candidates of all targets, their pixels shared out, verdicts."""

from __future__ import annotations

from collections.abc import Sequence

from .base.config import RecognizerConfig
from .base.crew import Crew
from .base.deferred import Deferred
from .image.blobs import Blob
from .image.codes import LABELS, Codes
from .image.image_frame import ImageFrame
from .left_over_looks import LeftOverLooks
from .like_target_looks import LikeTargetLooks
from .memory.recall import Recall
from .model.frame_result import StageResult
from .model.target import Target
from .pose.finder import WholeObjectFinder
from .second_looks import SecondLooks
from .spatial_search import SpatialSearch
from .three_point_looks import ThreePointLooks
from .turned_down import turned_down
from .verdict.descriptions import Describer
from .verdict.doubts import doubtful, verdicts_in_doubt
from .verdict.judge import Judge
from .verdict.like_targets import LikeTargets
from .verdict.offers import Offers


class SpatialStage:
    """Finds the targets whose markers have places in space, in frames of a calibrated camera."""

    def __init__(self, targets: Sequence[Target], config: RecognizerConfig, codes: Codes = LABELS) -> None:
        self._config = config
        self._judge, self._crew = Judge.of(config), Crew(config.threads)
        self._finders = [WholeObjectFinder(t, config, codes) for t in targets]
        self._left_over = LeftOverLooks(self._finders)
        self._three_points = ThreePointLooks(self._finders, self._judge)
        self._like = LikeTargets(self._finders)
        self._like_targets = LikeTargetLooks(self._like, self._judge, config.search)
        self._describers = [Describer(f) for f in self._finders]

    def recognize(self, frame: ImageFrame, blobs: Sequence[Blob], recall: Recall | None = None) -> StageResult:
        """Detections by target and score, and what was turned down, with reasons.

        :param recall: what earlier frames say of this one, and where it is noted what this one says.
        """
        if not self._finders:
            return StageResult()
        known = {} if recall is None else {f: recall.expected(f) for f in self._finders}
        if known:
            expected = {f.target.name: (poses.R, poses.t, poses.q) for f, poses in known.items() if len(poses)}
            frame = frame.expecting(expected)
        search = self._config.search
        judge = self._judge.in_one_frame()
        search_of = SpatialSearch(frame.hurried(search.search_share), judge, search, recall, self._crew)
        found = search_of.run(self._finders, blobs)
        looks = SecondLooks(frame, self._judge, search, recall)
        shared = looks.shared(found)
        for candidates in (self._three_points.candidates, self._left_over.candidates):
            if more := candidates(frame.hurried(search.search_share), shared.accepted, blobs, recall):
                shared = looks.beside(list(more.items()))
        past = recall or Recall()
        if more := self._like_targets.candidates(frame.hurried(search.search_share), shared.accepted, blobs, past):
            shared = looks.beside(list(more.items()))
        if frame.deadline.expired:
            past.likes.cut_short()
        offers = Offers(self._describers, self._judge, frame, blobs, self._like, past.likes, known, surplus_alone=True)
        told = offers.told(looks.candidates, shared, looks.again)
        for finder, mine in zip(self._finders, told.go_on, strict=True):
            if recall is not None:
                unsure = [told.may_be_another(v) for v in mine]
                recall.accept(finder, mine, frame.camera, told.rivals, unsure)
                recall.doubt(finder, verdicts_in_doubt(finder, self._judge, told), frame.camera)
        looked_at = [] if frame.deadline.hit or (recall and recall.waiting) else blobs
        return StageResult(
            tuple(d for mine in told.detections for d in mine),
            Deferred(lambda: (*told.doubtful, *turned_down(frame, self._judge, told, self._finders, looked_at))),
            Deferred(lambda: doubtful(self._describers, self._judge, frame, blobs, told)),
        )
