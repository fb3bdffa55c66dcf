"""Second looks where an object is found that may be another target's: who is found first takes its pixels, and those
that look like it are not looked for in them any more."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from .base.config import SearchConfig
from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .pose.finder import WholeObjectFinder
from .pose.poses import Poses
from .spatial_looks import SpatialLooks
from .verdict.claims import left_by
from .verdict.judge import Judge
from .verdict.verdicts import Verdict


class LikeTargetLooks:
    """Those for some targets, in space."""

    def __init__(self, finders: Sequence[WholeObjectFinder], judge: Judge, config: SearchConfig) -> None:
        self._classes = {finder: Counter(map(frozenset, finder.surface.labels)) for finder in finders}
        self._looks, self._config = SpatialLooks(judge, config), config

    def candidates(
        self, frame: ImageFrame, accepted: Sequence[Verdict], blobs: Sequence[Blob]
    ) -> dict[WholeObjectFinder, Poses]:
        """Of each target what it would be that is found, in what no other object explains.

        :param blobs: of the frame.
        """
        out = dict[WholeObjectFinder, Poses]()
        for verdict in accepted:
            for finder in self._like(verdict):
                found = None if frame.deadline.expired else self._look(frame, finder, verdict, accepted, blobs)
                if found is not None and len(found):
                    out[finder] = Poses.concatenate([out[finder], found]) if finder in out else found
        return out

    def _like(self, verdict: Verdict) -> list[WholeObjectFinder]:
        """Other targets that have all classes that an object shows: what lacks some explains too little of it."""
        labels = verdict.finder.surface.labels
        shown = Counter(frozenset(own) for own, yes in zip(labels, verdict.confirmed, strict=True) if yes)
        return [f for f, classes in self._classes.items() if f is not verdict.finder and shown <= classes]

    def _look(
        self,
        frame: ImageFrame,
        finder: WholeObjectFinder,
        verdict: Verdict,
        accepted: Sequence[Verdict],
        blobs: Sequence[Blob],
    ) -> Poses | None:
        taken = left_by(frame, [verdict.claim]).field
        mine = [b for b in blobs if b.label in finder.root_labels]
        own = [b for b in mine if taken.owned_share(b.contour) > self._config.explained]
        if not own:
            return None
        rest = left_by(frame, [v.claim for v in accepted if v is not verdict])
        # which of them its required component made is not known
        plain = [found for b in own if (found := self._looks.plain(rest, finder, b)) is not None and len(found)]
        if plain:
            return Poses.concatenate(plain)
        return self._looks.full(rest, finder, max(own, key=lambda b: b.area_px))
