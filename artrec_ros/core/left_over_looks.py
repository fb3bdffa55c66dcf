"""Second looks at objects that leave blobs unexplained which may be their own, for poses that explain these, too; and
at those that lack a part, which may lie on like ones.

A search goes by what components show where it lays them. What leads it astray may still be an object, one that lies on
most of its markers: then nobody looks for the others. Where they may be is known once all objects are found. What comes
of it is a candidate beside what was found: the pixels are shared out anew, and the one with more votes stands.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from itertools import zip_longest
from typing import NamedTuple

import numpy as np

from .geometry.camera import Camera
from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .like_side_looks import by_other_sides
from .memory.recall import Recall
from .pose.ball_blobs import BallBlobs
from .pose.finder import WholeObjectFinder
from .pose.poses import Poses
from .pose.through_middles import Middles
from .verdict.left_over import LeftOver, LeftOvers
from .verdict.verdicts import Verdict


class _Look(NamedTuple):
    """At an object once more. :ivar begun: poses that explain what it leaves, about."""

    finder: WholeObjectFinder
    verdict: Verdict
    begun: Callable[[], Poses]

    @classmethod
    def through(cls, middles: Middles, verdict: Verdict, camera: Camera) -> _Look:
        finder, poses = verdict.claim.finder, verdict.claim.poses
        return cls(finder, verdict, lambda: finder.through_middles.of(camera, poses, middles))


class LeftOverLooks:
    """Those of some targets' objects."""

    def __init__(self, finders: Sequence[WholeObjectFinder]) -> None:
        self._most = min((f.config.middles.looks for f in finders), default=0)
        self._of = {finder: LeftOvers(finder) for finder in finders}
        self._balls = {finder: BallBlobs(finder.surface) for finder in finders if finder.surface.sides.balls}

    def candidates(
        self,
        frame: ImageFrame,
        accepted: Sequence[Verdict],
        blobs: Sequence[Blob],
        recall: Recall | None = None,
        known: Sequence[Verdict] = (),
    ) -> dict[WholeObjectFinder, Poses]:
        """Poses that explain more than accepted ones do.

        :param blobs: of the frame. :param recall: what earlier frames say of it: what is sure, and not due, is not
            looked at again. :param known: candidates that were looked at.
        """
        out, recall = dict[WholeObjectFinder, Poses](), recall or Recall()
        done = {v.claim.poses.key for v in known}
        new = [v for v in accepted if v.claim.poses.key not in done]
        own = {finder: [v for v in new if v.claim.finder.target is finder.target] for finder in self._of}
        each = [self._looks(finder, mine, frame, accepted, blobs, recall) for finder, mine in own.items()]
        in_turn = [look for looks in zip_longest(*each) for look in looks if look is not None]
        in_turn.sort(key=self._is_of_a_sure_one)  # there is time for so many
        on_likes = [look for finder, mine in own.items() for look in self._on_likes(finder, mine, frame, recall)]
        for look in [*in_turn[: self._most], *on_likes[: self._most]]:
            if frame.deadline.expired:
                break
            finder, again = look.finder, look.finder.looked_again(frame, look.begun())
            found = again.poses[np.flatnonzero(again.votes > look.verdict.claim.votes)]
            if len(found):
                out[finder] = Poses.concatenate([out[finder], found]) if finder in out else found
        return out

    def _looks(
        self,
        finder: WholeObjectFinder,
        own: Sequence[Verdict],
        frame: ImageFrame,
        accepted: Sequence[Verdict],
        blobs: Sequence[Blob],
        recall: Recall,
    ) -> Iterator[_Look]:
        """What is to be explained of each object of a target that is not sure in spite of it, or of which what is left
        is sure, and where balls lie that are told otherwise. Of what faces the camera all is: a pose that is sure may
        have a limb that is not, and no other depth makes another object of what is left."""
        left_overs, every = self._of[finder], set(range(len(finder.target.model.components)))
        asked = [v for v in own if not recall.rests(finder, v.claim.poses)]
        for_all = {v for v in own if finder.facing or left_overs.is_in_doubt(_seen(v))}
        mine = [v for v in own if v in for_all or (v in asked and left_overs.may_be_sure(every - {*_seen(v)}))]
        for verdict, left in self._left(finder, mine, frame, accepted, blobs):
            if verdict in for_all or left_overs.is_sure(left, blobs):
                if len(finder.like_sides):
                    sides = partial(by_other_sides, finder, left_overs, verdict, frame, accepted, blobs)
                    yield _Look(finder, verdict, sides)
                for middles in self._middles(finder, verdict, left, frame.camera):
                    yield _Look.through(middles, verdict, frame.camera)
        for verdict in asked if finder in self._balls else ():
            shown = [verdict.shown[c] for c in _seen(verdict)]
            otherwise = self._balls[finder].under(frame.camera, verdict.claim.poses, shown, blobs)
            if otherwise is not None:
                yield _Look.through(otherwise, verdict, frame.camera)

    def _on_likes(
        self, finder: WholeObjectFinder, own: Sequence[Verdict], frame: ImageFrame, recall: Recall
    ) -> Iterator[_Look]:
        """Whether what lacks something lies where it has a like part."""
        for v in own if finder.on_likes.any else ():
            if not all(v.confirmed) and not recall.rests(finder, v.claim.poses):
                yield _Look(finder, v, partial(finder.on_likes.begun, frame, v.claim.poses))

    def _is_of_a_sure_one(self, look: _Look) -> bool:
        """Whether the pose of an object that faces the camera is sure: those in doubt come first."""
        return look.finder.facing and not self._of[look.finder].is_in_doubt(_seen(look.verdict))

    def _left(
        self,
        finder: WholeObjectFinder,
        mine: Sequence[Verdict],
        frame: ImageFrame,
        accepted: Sequence[Verdict],
        blobs: Sequence[Blob],
    ) -> list[tuple[Verdict, LeftOver]]:
        """What some objects leave, of those that leave something."""
        if not mine or frame.deadline.expired:
            return []
        poses = Poses.concatenate([v.claim.poses for v in mine])
        frames = finder.surface.kinematics.seen(poses.R, poses.t, poses.q)
        left = self._of[finder].of([_seen(v) for v in mine], frames, frame, blobs, accepted)
        return [(verdict, one) for verdict, one in zip(mine, left, strict=True) if one.blobs]

    def _middles(
        self, finder: WholeObjectFinder, verdict: Verdict, left: LeftOver, camera: Camera
    ) -> Iterator[Middles]:
        """What is seen of an object, together with all that it leaves, and with each alone of several."""
        shown = [verdict.shown[c] for c in _seen(verdict)]
        for some in left.choices:
            yield self._of[finder].middles(verdict.claim.poses, shown, left, camera, some)


def _seen(verdict: Verdict) -> list[int]:
    """Components that its labels confirm."""
    return [c for c, yes in enumerate(verdict.confirmed) if yes]
