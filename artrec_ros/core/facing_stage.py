"""Recognition of whole objects that face the camera, in images of any camera: figures of the image plane, and of the
plane on which they lie where that is known."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from functools import partial

from .base.config import RecognizerConfig
from .base.deferred import Deferred
from .facing_search import FacingSearch
from .from_above import FromAbove, back_in_image, within
from .geometry.range_limits import ScaleLimits, scale_limits
from .image.blobs import Blob
from .image.codes import LABELS, Codes
from .image.image_frame import ImageFrame
from .left_over_looks import LeftOverLooks
from .memory.recall import Recall
from .model.found import Detection
from .model.frame_result import StageResult
from .model.target import Target
from .pose.finder import WholeObjectFinder
from .pose.on_plane import PlanePlacer
from .pose.poses import Poses
from .turned_down import turned_down
from .verdict.claims import left_by
from .verdict.descriptions import Describer
from .verdict.doubts import doubtful
from .verdict.judge import Judge
from .verdict.like_targets import LikeTargets
from .verdict.looks import Looks
from .verdict.offers import Found, Offers
from .verdict.ownership import Shared, share_out
from .verdict.verdicts import Verdict

_ROUNDS = 3  # what is another reading may leave blobs in its turn
# blobs of the required component's class, and those of others' in which an object is looked for, too
_Task = tuple[FacingSearch, Sequence[Blob], Sequence[Blob]]


class FacingStage:
    """Finds flat targets, whose place, turn and scale in the image are told, and the pose on the scene's plane."""

    def __init__(self, targets: Sequence[Target], config: RecognizerConfig, codes: Codes = LABELS) -> None:
        self._config = config
        self._searches = [FacingSearch(WholeObjectFinder(t, config, codes, facing=True), config) for t in targets]
        self.describers = [Describer(s.finder) for s in self._searches]
        self._judge = Judge.of(config)
        self._search_judge = self._judge.seeking
        self._left_over = LeftOverLooks([s.finder for s in self._searches])
        self._like = LikeTargets([s.finder for s in self._searches])
        self._readings = {d.finder: d.readings for d in self.describers if d.readings is not None}
        self._placer = PlanePlacer(targets, config)
        self._from_above = FromAbove(
            config, {label for s in self._searches for labels in s.finder.surface.labels for label in labels}
        )

    def recognize(self, frame: ImageFrame, blobs: Sequence[Blob], recall: Recall | None = None) -> StageResult:
        """Detections by target and score, and what was turned down, with reasons.

        :param recall: what earlier frames say of this one, and where it is noted what this one says.
        """
        if not self._searches:
            return StageResult()
        view = self._from_above.view(frame)
        if view is None:
            found = self._recognize(frame.faced(), blobs, scale_limits(self._config, frame.calibration), recall)
        else:
            seen = self._from_above.seen(frame, view)
            found = back_in_image(self._recognize(*seen, scale_limits(self._config, None), recall), view)
        reach = self._judge.reach
        told, beyond = within(found.detections, reach, frame.calibration)
        rejected = Deferred(lambda: (*beyond, *found.rejected)) if beyond else found.rejected
        return StageResult(told, rejected, Deferred(lambda: within(found.doubtful, reach, frame.calibration)[0]))

    def _recognize(
        self, faced: ImageFrame, blobs: Sequence[Blob], limits: ScaleLimits, recall: Recall | None
    ) -> StageResult:
        """As `recognize`, in a frame whose camera objects face."""
        found, shared = self.candidates(faced, blobs, limits, recall)
        likes = (recall or Recall()).likes
        if faced.deadline.hit:  # not all were looked for
            likes.leave_out(self._like.pairs(shared.accepted))
        known = {} if recall is None else {s.finder: recall.expected(s.finder) for s in self._searches}
        offers = Offers(self.describers, self._judge, faced, blobs, self._like, likes, known)
        told = offers.told(found, shared, partial(self._again, faced))
        if recall is not None:
            for search, mine in zip(self._searches, told.go_on, strict=True):
                unsure = [told.may_be_another(v) for v in mine]
                recall.accept(search.finder, mine, faced.camera, told.rivals, unsure)
        detections = [self._faced(detection, faced) for mine in told.detections for detection in mine]
        finders = [s.finder for s in self._searches]
        looked_at = [] if faced.deadline.hit else blobs
        in_doubt = partial(doubtful, self.describers, self._judge, faced, blobs, told)
        return StageResult(
            tuple(detections),
            Deferred(lambda: (*told.doubtful, *turned_down(faced, self._judge, told, finders, looked_at))),
            Deferred(lambda: (self._faced(d, faced) for d in in_doubt())),
        )

    def _faced(self, detection: Detection, faced: ImageFrame) -> Detection:
        """A detection on the scene's plane, and as it would be told in its other place."""
        told = self._placer.faced(detection, faced)
        other = told.other_place
        if other is None or other.told is None:
            return told
        return replace(told, other_place=replace(other, told=self._placer.faced(other.told, faced)))

    def verdicts(self, faced: ImageFrame, blobs: Sequence[Blob], limits: ScaleLimits) -> Shared:
        """What becomes of candidates: see `candidates`."""
        return self.candidates(faced, blobs, limits)[1]

    def candidates(
        self, faced: ImageFrame, blobs: Sequence[Blob], limits: ScaleLimits, recall: Recall | None = None
    ) -> tuple[list[tuple[WholeObjectFinder, Poses]], Shared]:
        """All candidates, and what `share_out` makes of them.

        :param faced: the frame to objects that face the camera. :param limits: of the scale.
        :param recall: what earlier frames say of this one.
        """
        found, shared = self._candidates(faced, blobs, limits, recall)
        if not faced.deadline.expired:
            found, shared = self._best_read(found, shared, faced, blobs)
        if any(self._judge.lacks_components(v) for v in shared.accepted):  # second looks found no more of them
            again, in_time = self._shared_out(found, faced, Looks(), self._judge)
            shared = again if in_time else shared
        return found, shared

    def _candidates(
        self, faced: ImageFrame, blobs: Sequence[Blob], limits: ScaleLimits, recall: Recall | None
    ) -> tuple[list[tuple[WholeObjectFinder, Poses]], Shared]:
        found = self._found(faced, [(s, blobs, ()) for s in self._searches], limits, recall=recall)
        looks = Looks()
        shared, in_time = self._shared_out(found, faced, looks)
        known = list[Verdict]()
        if in_time:
            known += shared.accepted
            found, shared = self._looked_at(found, shared, (), faced, blobs, looks)
            known += shared.accepted
        more = self._of_the_rest(faced, blobs, limits, shared.accepted)
        if not any(len(poses) for _, poses in more):
            return found, shared
        together, in_time = self._shared_out(found + more, faced, looks)
        if not in_time:  # some of these are not judged again
            return found, shared
        return self._looked_at(found + more, together, known, faced, blobs, looks)

    def _best_read(
        self,
        found: list[tuple[WholeObjectFinder, Poses]],
        shared: Shared,
        faced: ImageFrame,
        blobs: Sequence[Blob],
    ) -> tuple[list[tuple[WholeObjectFinder, Poses]], Shared]:
        """Candidates without worse readings of what objects lie on, and what becomes of those that are left."""
        for _ in range(_ROUNDS):
            kept, changed = list[tuple[WholeObjectFinder, Poses]](), False
            for finder in dict.fromkeys(f for f, _ in found):
                every = Poses.concatenate([poses for f, poses in found if f is finder])
                better = self._readings[finder].better(every, shared.accepted, faced, blobs)
                kept.append((finder, every if better is None else better))
                changed |= better is not None
            if not changed:
                break
            again, in_time = self._shared_out(kept, faced, Looks())
            if not in_time:
                break
            found, shared = self._looked_at(kept, again, (), faced, blobs, Looks())
        return found, shared

    def _looked_at(
        self,
        found: list[tuple[WholeObjectFinder, Poses]],
        shared: Shared,
        known: Sequence[Verdict],
        faced: ImageFrame,
        blobs: Sequence[Blob],
        looks: Looks,
    ) -> tuple[list[tuple[WholeObjectFinder, Poses]], Shared]:
        """Candidates, and what becomes of them, after second looks at accepted ones. :param known: that were looked at
        before."""
        hurried = faced.hurried(self._config.facing.search_share)
        through = self._left_over.candidates(hurried, shared.accepted, blobs, known=known)
        if not through:
            return found, shared
        again, in_time = self._shared_out([*found, *through.items()], faced, looks)
        return ([*found, *through.items()], again) if in_time else (found, shared)

    def _of_the_rest(
        self, frame: ImageFrame, blobs: Sequence[Blob], limits: ScaleLimits, accepted: Sequence[Verdict]
    ) -> list[tuple[WholeObjectFinder, Poses]]:
        """Candidates of what no accepted object explains: in large blobs, among them much smaller ones than before, in
        the blobs of other components, and in what is left of those that touch others."""
        if frame.deadline.hit:  # there was not even time for the first look
            return []
        claims = [v.claim for v in accepted]
        told = {s: [c.poses for c in claims if c.finder is s.finder] for s in self._searches}
        there = {s: Poses.concatenate(poses) for s, poses in told.items() if poses}
        unseen = self._config.required == "visible"
        large = [(s, mine) for s in self._searches if (mine := s.large(blobs, limits)) or unseen]
        roomy = [(s, mine) for s, poses in there.items() if (mine := s.roomy(frame, blobs, poses))]
        if not large and not roomy:
            return []
        # what lacks a part may be another one, which has it: its pixels stay
        complete = [v.claim for v in accepted if self._judge.is_complete(v)]
        whole = left_by(frame, complete) if large else frame
        free = [(s, own) for s, mine in large if (own := s.unexplained(whole, mine)) or unseen]
        looks: list[_Task] = [(s, s.several(own, limits), s.limbs(whole, blobs)) for s, own in free]
        left = [task for task in looks if task[1] or task[2]]
        rest = frame if not roomy else whole if large and len(complete) == len(claims) else left_by(frame, claims)
        cut: list[_Task] = [(s, pieces, ()) for s, mine in roomy if (pieces := s.pieces(rest, mine, there[s]))]
        again = (whole, left, self._config.facing.sizes), (rest, cut, 1)
        return [c for image, tasks, sizes in again if tasks for c in self._found(image, tasks, limits, sizes)]

    def _found(
        self,
        frame: ImageFrame,
        tasks: Sequence[_Task],
        limits: ScaleLimits,
        sizes: int = 1,
        recall: Recall | None = None,
    ) -> list[tuple[WholeObjectFinder, Poses]]:
        """Candidates of each search in its blobs, all in a share of the time that is left."""
        hurried, n = frame.hurried(self._config.facing.search_share), len(tasks)
        return [
            (s.finder, s.run(hurried.hurried(1 / (n - i)), blobs, limits, sizes, limbs, recall))
            for i, (s, blobs, limbs) in enumerate(tasks)
        ]

    def _again(self, faced: ImageFrame, found: Found) -> Shared | None:
        """`share_out` of what is left of candidates; None: not all could be judged."""
        shared, in_time = self._shared_out(found, faced, Looks(), self._judge)
        return shared if in_time else None

    def _shared_out(
        self, found: Found, frame: ImageFrame, looks: Looks, judge: Judge | None = None
    ) -> tuple[Shared, bool]:
        """`share_out` of them, and whether a share of the time that is left was enough to judge them all.

        :param judge: None: the one of the search.
        """
        hurried = frame.hurried(self._config.facing.judge_share)
        return share_out(found, hurried, judge or self._search_judge, looks), not hurried.deadline.hit
