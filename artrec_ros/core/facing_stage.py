"""Recognition of whole objects that face the camera, in images of any camera: figures of the image plane, and of the
plane on which they lie where that is known."""

from __future__ import annotations

from collections.abc import Sequence

from .base.config import RecognizerConfig
from .base.deferred import Deferred
from .facing_search import FacingSearch
from .geometry.range_limits import ScaleLimits, scale_limits
from .image.blobs import Blob
from .image.codes import LABELS, Codes
from .image.image_frame import ImageFrame
from .model.found import Detection, Rejection
from .model.target import Target
from .pose.finder import WholeObjectFinder
from .pose.on_plane import PlanePlacer
from .pose.surface_model import Poses
from .verdict.acceptance import Verdict
from .verdict.claims import silhouette
from .verdict.descriptions import NONE_LEFT, Describer, rejection_of
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
        found = self._found(faced, [(s, blobs) for s in self._searches], limits)
        (accepted, others), _ = self._shared_out(found, faced)
        more = self._of_merged(faced, blobs, limits, accepted)
        if any(len(poses) for _, poses in more):
            together, in_time = self._shared_out(found + more, faced)
            accepted, others = together if in_time else (accepted, others)  # else some of these are not judged again
        detections, surplus = list[Detection](), list[Verdict]()
        for describer in self._describers:
            told, none_left = describer.without_surplus(accepted, faced)
            detections += [self._placer.faced(detection, faced) for detection in describer.describe(told, faced)]
            surplus += none_left
        return tuple(detections), Deferred(
            lambda: (
                *(rejection_of(v, faced, self._judge, NONE_LEFT) for v in surplus),
                *(rejection_of(v, faced, self._judge) for v in others),
            )
        )

    def _of_merged(
        self, frame: ImageFrame, blobs: Sequence[Blob], limits: ScaleLimits, accepted: Sequence[Verdict]
    ) -> list[tuple[WholeObjectFinder, Poses]]:
        """Candidates of large blobs that no accepted object explains, among them much smaller ones, and of what those
        that touch others leave."""
        if frame.deadline.hit:  # there was not even time for the first look
            return []
        claims = [v.claim for v in accepted]
        told = {s: [c.poses for c in claims if c.finder is s.finder] for s in self._searches}
        there = {s: Poses.concatenate(poses) for s, poses in told.items() if poses}
        merged = [(s, mine) for s in self._searches if (mine := s.merged(blobs, limits))]
        roomy = [(s, mine) for s, poses in there.items() if (mine := s.roomy(frame, blobs, poses))]
        if not merged and not roomy:
            return []
        rest = frame.without([h for c in claims for h in silhouette(c.finder.surface, frame.camera, c.poses)])
        left = [(s, free) for s, mine in merged if (free := s.unexplained(rest, mine))]
        cut = [(s, pieces) for s, mine in roomy if (pieces := s.pieces(rest, mine, there[s]))]
        again = (left, self._config.facing.sizes), (cut, 1)
        return [c for tasks, sizes in again if tasks for c in self._found(rest, tasks, limits, sizes)]

    def _found(
        self,
        frame: ImageFrame,
        tasks: Sequence[tuple[FacingSearch, Sequence[Blob]]],
        limits: ScaleLimits,
        sizes: int = 1,
    ) -> list[tuple[WholeObjectFinder, Poses]]:
        """Candidates of each search in its blobs, all in a share of the time that is left."""
        hurried, n = frame.hurried(self._config.facing.search_share), len(tasks)
        return [
            (s.finder, s.run(hurried.hurried(1 / (n - i)), blobs, limits, sizes)) for i, (s, blobs) in enumerate(tasks)
        ]

    def _shared_out(
        self, found: Sequence[tuple[WholeObjectFinder, Poses]], frame: ImageFrame
    ) -> tuple[tuple[list[Verdict], Sequence[Verdict]], bool]:
        """`share_out` of them, and whether a share of the time that is left was enough to judge them all."""
        hurried = frame.hurried(self._config.facing.judge_share)
        return share_out(found, hurried, self._judge), not hurried.deadline.hit
