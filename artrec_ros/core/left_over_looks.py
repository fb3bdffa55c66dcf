"""Second looks at objects that leave blobs unexplained which may be their own: for poses that explain these, too.

A search goes by what components show where it lays them. What leads it astray may still be an object, one that lies on
most of its markers: then nobody looks for the others. Where they may be is known once all objects are found. What comes
of it is a candidate beside what was found: the pixels are shared out anew, and the one with more votes stands.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice

import numpy as np

from .image.blobs import Blob, centres
from .image.image_frame import ImageFrame
from .pose.climber import Climb
from .pose.finder import WholeObjectFinder
from .pose.surface_model import Poses
from .pose.through_middles import Middles, ThroughMiddles
from .verdict.acceptance import Verdict
from .verdict.left_over import LeftOvers


class LeftOverLooks:
    """Those of some targets' objects. :param climb: on the votes, of what was found."""

    def __init__(self, finders: Sequence[WholeObjectFinder], climb: Climb) -> None:
        self._climb, self._most = climb, min((f.config.middles.looks for f in finders), default=0)
        self._of = {
            finder: (LeftOvers(finder), ThroughMiddles(finder.surface, finder.config, facing=finder.facing))
            for finder in finders
        }

    def candidates(
        self, frame: ImageFrame, accepted: Sequence[Verdict], blobs: Sequence[Blob]
    ) -> dict[WholeObjectFinder, Poses]:
        """Poses that explain more than accepted ones do. :param blobs: of the frame."""
        out = dict[WholeObjectFinder, Poses]()
        for finder, verdict, middles in islice(self._looks(frame, accepted, blobs), self._most):
            if frame.deadline.expired:
                break
            found = self._climbed(finder, self._of[finder][1], verdict, frame, middles)
            if len(found):
                out[finder] = Poses.concatenate([out[finder], found]) if finder in out else found
        return out

    def _looks(
        self, frame: ImageFrame, accepted: Sequence[Verdict], blobs: Sequence[Blob]
    ) -> Iterator[tuple[WholeObjectFinder, Verdict, Middles]]:
        """What is to be explained of each object, by the finder that has it."""
        for finder, (left_overs, _) in self._of.items():
            for verdict in accepted:
                if verdict.claim.finder.target is finder.target:
                    for middles in self._middles(finder, left_overs, verdict, frame, blobs, accepted):
                        yield finder, verdict, middles

    def _climbed(
        self, finder: WholeObjectFinder, through: ThroughMiddles, verdict: Verdict, frame: ImageFrame, middles: Middles
    ) -> Poses:
        """Poses through some middles that have more votes than the one that was found."""
        poses = finder.climber.within_limits(frame.camera, through.of(frame.camera, verdict.claim.poses, middles))
        found = finder.polished(frame, finder.fit_all(frame, poses), self._climb)
        return found.poses[np.flatnonzero(found.votes > verdict.claim.votes)]

    def _middles(
        self,
        finder: WholeObjectFinder,
        left_overs: LeftOvers,
        verdict: Verdict,
        frame: ImageFrame,
        blobs: Sequence[Blob],
        accepted: Sequence[Verdict],
    ) -> Iterator[Middles]:
        """What is seen of an object, together with all that it leaves, and with each alone of several; of one that is
        sure in spite of these nothing."""
        seen, poses = [c for c, yes in enumerate(verdict.confirmed) if yes], verdict.claim.poses
        frames = finder.surface.kinematics.forward(poses.R, poses.t, poses.q)
        (left,) = left_overs.of([seen], frames, frame, blobs, accepted)
        if not left.blobs or left.share(finder.config) > finder.config.search.sure:
            return
        shown = [verdict.shown[c] for c in seen]
        at, scale = left_overs.places(frames, shown, frame.camera)
        lost = list(left.blobs)
        for some in [lost] + [[c] for c in lost] * (len(lost) > 1):
            more = [finder.surface.markers_of[c][0] for c in some]
            area = np.array([finder.surface.area[p] for p in more])
            own = np.sqrt(np.array([left.blobs[c].area_px for c in some]) / area)
            yield Middles(
                np.array([*shown, *more], np.int64),
                np.concatenate([at, centres([left.blobs[c] for c in some])]),
                np.concatenate([scale, own]),
            )
