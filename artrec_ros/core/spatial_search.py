"""Search of one image for whole objects of all targets, blob by blob; a sure object takes its pixels."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, partial

from .base.config import SearchConfig
from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .pose.finder import Climb, WholeObjectFinder
from .pose.surface_model import Poses
from .verdict.acceptance import Verdict
from .verdict.claims import silhouette
from .verdict.judge import Judge


class SpatialSearch:
    """What is found so far, and the frame without the pixels of sure objects."""

    def __init__(self, frame: ImageFrame, judge: Judge, config: SearchConfig) -> None:
        self._frame, self._judge, self._config = frame, judge, config
        climbs = zip(config.climb_hypotheses, config.climb_rounds, config.climb_first_steps, strict=True)
        self._climbs = [Climb(*climb) for climb in climbs]
        self._plain_climb = self._climbs[-1]._replace(rounds=config.plain_climb_rounds)
        self._found: dict[WholeObjectFinder, list[Poses]] = {}
        self._unexplained: dict[WholeObjectFinder, ImageFrame] = {}  # without the pixels of its likely objects, too
        # found, and whether sure; its pixels are still in the frames
        self._to_hide: tuple[WholeObjectFinder, Poses, bool] | None = None

    def run(self, finders: Sequence[WholeObjectFinder], blobs: Sequence[Blob]) -> list[tuple[WholeObjectFinder, Poses]]:
        """Candidates of each target: first objects in plain view, then what takes more to find; the largest blobs
        first."""
        queue = [(f, b) for f in finders for b in blobs if b.label in f.root_labels]
        queue.sort(key=lambda fb: -fb[1].area_px)
        for look in (self._look_for_plain, self._look_closely):
            left = []
            for finder, blob in queue:
                if self._over(finder, blob):
                    continue
                found = look(finder, blob)
                if found is not None and not self._take(finder, found):
                    left.append((finder, blob))
            queue = left
        return [(finder, Poses.concatenate(poses)) for finder, poses in self._found.items()]

    def _look_for_plain(self, finder: WholeObjectFinder, blob: Blob) -> Poses | None:
        """An object beyond doubt whose required component made a blob, by a few guesses, and its rivals, best first;
        none where there is doubt. None: nor is the blob worth a longer look, for others would lead to the object."""
        found = finder.plain_guesses(self._frame, blob)
        verdict = self._judge.on_first(finder, found.poses, self._frame)
        if finder.is_alike_throughout and self._is_hopeless(verdict, climbs=1):
            return None
        if verdict is None or self._judge.trust(verdict) <= self._config.sure:
            return found.poses[:0]
        return finder.climbed(self._frame, found, self._plain_climb, sure=True).poses

    def _look_closely(self, finder: WholeObjectFinder, blob: Blob) -> Poses:
        """Hypotheses of which a component made a blob, or part of one, best first."""
        found, sure = finder.guesses(self._frame, blob), False
        for number, climb in enumerate(self._climbs):
            if self._frame.deadline.expired or not (found.votes > 0).any():
                break
            verdict = self._judge.on_first(finder, found.poses, self._frame)
            if self._is_hopeless(verdict, climbs=number):
                break
            sure = sure or (verdict is not None and self._judge.trust(verdict) > self._config.sure)
            if not sure or climb is self._climbs[-1]:
                found = finder.climbed(self._frame, found, climb, sure=sure)
        return found.poses

    def _over(self, finder: WholeObjectFinder, blob: Blob) -> bool:
        """Whether nothing of a blob is left to explain, or no time for it."""
        if self._frame.deadline.expired:
            return True
        self._hide_found()
        return self._unexplained.get(finder, self._frame).field.owned_share(blob.contour) > self._config.explained

    def _is_hopeless(self, verdict: Verdict | None, *, climbs: int) -> bool:
        """Whether no climb will make an object of the best one: what it lacks to be one it does not find on its way.

        A climb may yet bring the required component to its place; the next one does not.
        """
        if verdict is None or not verdict.confirmed[verdict.claim.finder.root]:
            return climbs > 0
        return verdict.probability < self._config.hopeless

    def _take(self, finder: WholeObjectFinder, poses: Poses) -> bool:
        """Keep hypotheses, the best one first; whether that is a sure object, which takes its pixels.

        A likely one may share them with a rival, but its own target's is not sought for them again.
        """
        self._found.setdefault(finder, []).append(poses)
        trust = self._judge.trust_in(finder, poses, self._frame)
        sure = trust > self._config.sure
        if sure or trust > self._config.likely:
            self._to_hide = finder, poses[:1], sure
        return sure

    def _hide_found(self) -> None:
        """Take the pixels of what was found last: put off until there is another blob to look at."""
        if self._to_hide is None:
            return
        (finder, pose, sure), self._to_hide = self._to_hide, None
        rest = cache(partial(ImageFrame.without, solids=silhouette(finder.surface, self._frame.camera, pose)))
        self._unexplained.setdefault(finder, self._frame)
        for other in self._unexplained if sure else (finder,):
            self._unexplained[other] = rest(self._unexplained[other])  # several finders may still share one
        if sure:
            self._frame = rest(self._frame)
