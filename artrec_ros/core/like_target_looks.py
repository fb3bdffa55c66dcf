"""Second looks where an object is found that may be another target's: who is found first takes its pixels, and those
that look like it are not looked for in them any more."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property, partial

from .base.config import SearchConfig
from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .memory.memory import Known
from .memory.recall import Recall
from .pose.finder import WholeObjectFinder
from .pose.poses import Poses
from .spatial_looks import SpatialLooks
from .verdict.claims import left_by
from .verdict.judge import Judge
from .verdict.like_targets import LikeTargets
from .verdict.verdicts import Verdict


class LikeTargetLooks:
    """Those for some targets, in space."""

    def __init__(self, like: LikeTargets, judge: Judge, config: SearchConfig) -> None:
        self._like, self._looks, self._config = like, SpatialLooks(judge, config), config

    def candidates(
        self, frame: ImageFrame, accepted: Sequence[Verdict], blobs: Sequence[Blob], recall: Recall
    ) -> dict[WholeObjectFinder, Poses]:
        """Of each target what it would be that is found, in what no other object explains.

        :param blobs: of the frame. :param recall: what earlier frames say of it: what was there is followed, and other
            looks wait their turn.
        """
        pairs = [(v, finder) for v in accepted for finder in self._like.of(v)]
        if not pairs:
            return {}
        places = {v: _Place(frame, v, accepted, blobs, self._config.explained) for v in accepted}
        known = [self._followed(frame, places[v], f, recall.likes.known((v, f)), recall) for v, f in pairs]
        found, lost = [(f, poses) for (_, f), (poses, _) in zip(pairs, known, strict=True)], [gone for _, gone in known]
        if frame.deadline.expired:
            recall.likes.leave_out(pairs)
        for n in recall.likes.due(pairs, lost):
            if recall.patience.is_over or frame.deadline.expired:
                recall.likes.leave_out([pairs[n]])
                continue
            look = partial(self._look, places[pairs[n][0]], pairs[n][1])
            poses = recall.patience.spent_on(look, recall.config.doubt_share)
            found += [] if poses is None else [(pairs[n][1], poses)]
            # what was cut short is looked at again
            (recall.likes.leave_out if frame.deadline.expired else recall.likes.look)([pairs[n]])
        return _joined(found)

    def _followed(
        self, frame: ImageFrame, place: _Place, finder: WholeObjectFinder, known: Known | None, recall: Recall
    ) -> tuple[Poses, bool]:
        """What is there of what was, and whether that is less. It may leap from one of its turns to another: that it
        explains as much is all that counts."""
        if known is None or frame.deadline.expired:
            return finder.surface.no_poses, False
        _, near = self._looks.near(place.rest, finder, known, recall.clock_s, recall.config)
        return near.poses, not (near.votes[:1] >= recall.config.kept * known.votes).any()

    def _look(self, place: _Place, finder: WholeObjectFinder) -> Poses | None:
        own = [b for b in place.own if b.label in finder.root_labels]
        if not own:
            return None
        # which of them its required component made is not known, and a plain look is content with less
        plain = [found for b in own if (found := self._looks.plain(place.rest, finder, b)) is not None and len(found)]
        found = Poses.concatenate(plain) if plain else finder.surface.no_poses
        if len(found) and finder.voter.votes(place.rest, found, occlusion=True).max() >= place.least_votes:
            return found
        close = self._looks.close(place.rest, finder, max(own, key=lambda b: b.area_px))
        return Poses.concatenate([found, close])


class _Place:
    """Where an object is."""

    def __init__(
        self,
        frame: ImageFrame,
        verdict: Verdict,
        accepted: Sequence[Verdict],
        blobs: Sequence[Blob],
        explained: float,
    ) -> None:
        self._frame, self._verdict, self._accepted = frame, verdict, accepted
        self._blobs, self._explained = blobs, explained

    @property
    def least_votes(self) -> float:
        """That make another target's object in its place a rival."""
        return self._verdict.finder.config.verdict.mirrored_votes * self._verdict.votes

    @cached_property
    def rest(self) -> ImageFrame:
        """The frame without what others explain."""
        return left_by(self._frame, [v.claim for v in self._accepted if v is not self._verdict])

    @cached_property
    def own(self) -> list[Blob]:
        """Blobs that it explains."""
        taken = left_by(self._frame, [self._verdict.claim]).field
        return [b for b in self._blobs if taken.owned_share(b.contour) > self._explained]


def _joined(found: Sequence[tuple[WholeObjectFinder, Poses]]) -> dict[WholeObjectFinder, Poses]:
    """All of each target that has some."""
    out = dict[WholeObjectFinder, Poses]()
    for finder, poses in found:
        out[finder] = Poses.concatenate([out[finder], poses]) if finder in out else poses
    return {finder: poses for finder, poses in out.items() if len(poses)}
