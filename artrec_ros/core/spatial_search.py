"""Search of one image for whole objects of all targets, blob by blob; a sure object takes its pixels."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import cache, partial
from typing import NamedTuple

import numpy as np

from .base.config import SearchConfig
from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .memory.recall import Recall
from .memory.turns import Turns
from .pose.finder import Climb, WholeObjectFinder
from .pose.ranked import Ranked
from .pose.surface_model import Poses
from .verdict.acceptance import Verdict
from .verdict.claims import silhouette
from .verdict.judge import Judge


class _Followed(NamedTuple):
    """A known object. :param trust: 0: it is not where it is expected. :param well: it is as it was."""

    finder: WholeObjectFinder
    expected: Poses
    found: Ranked
    trust: float
    well: bool
    was_there: bool


class SpatialSearch:
    """What is found so far, and the frame without the pixels of sure objects."""

    def __init__(self, frame: ImageFrame, judge: Judge, config: SearchConfig, recall: Recall | None = None) -> None:
        self._frame, self._judge, self._config, self._recall = frame, judge, config, recall or Recall()
        self._turns: dict[WholeObjectFinder, Turns] = {}
        climbs = zip(config.climb_hypotheses, config.climb_rounds, config.climb_first_steps, strict=True)
        self._climbs = [Climb(*climb) for climb in climbs]
        self._plain_climb = self._climbs[-1]._replace(rounds=config.plain_climb_rounds)
        self._found: dict[WholeObjectFinder, list[Poses]] = {}
        self._unexplained: dict[WholeObjectFinder, ImageFrame] = {}  # without the pixels of its likely objects, too
        # found, and whether sure; its pixels are still in the frames
        self._to_hide: tuple[WholeObjectFinder, Poses, bool] | None = None

    def run(self, finders: Sequence[WholeObjectFinder], blobs: Sequence[Blob]) -> list[tuple[WholeObjectFinder, Poses]]:
        """Candidates of each target: known objects, then others in plain view, then what takes more to find; the
        largest blobs first."""
        queue = [(f, b) for f in finders for b in blobs if b.label in f.root_labels]
        queue.sort(key=lambda fb: -fb[1].area_px)
        for finder in finders:
            self._turns[finder] = self._recall.turns(finder.target.name, [b for f, b in queue if f is finder])
        queue = self._look_again(queue)
        for look in (self._look_for_plain, self._look_closely):
            left = []
            for finder, blob in queue:
                if self._over(finder, blob) or self._waits(finder, blob):
                    continue
                found = look(finder, blob)
                if found is not None and not self._take(finder, found):
                    left.append((finder, blob))
            queue = left
        return [(finder, Poses.concatenate(poses)) for finder, poses in self._found.items()]

    def _look_again(self, queue: list[tuple[WholeObjectFinder, Blob]]) -> list[tuple[WholeObjectFinder, Blob]]:
        """Look for known objects, and at the blobs whose turn it is, both as if nothing were known; what is left.

        Only then known objects take their pixels: what was found anew can prove to be better.
        """
        known = [followed for finder in self._turns for followed in self._follow(finder)]
        asked = [k for k in known if k.was_there]
        if 2 * sum(k.well for k in asked) < len(asked):  # another scene: what is remembered says nothing of it
            for turns in self._turns.values():
                turns.forget()
            return queue
        for k in known:
            if k.was_there and not k.well:
                turns = self._turns[k.finder]
                look_anew = turns.doubt if k.trust > self._config.sure else turns.hurry
                look_anew(*k.finder.discs(self._frame.camera, k.expected))
        known = sorted((k for k in known if k.trust > 0), key=lambda k: -k.found.votes[0])
        again: list[tuple[WholeObjectFinder, Poses]] = []
        for finder, blob in queue:
            turns = self._turns[finder]
            if self._frame.deadline.expired or not (turns.is_due(blob) or turns.is_doubted(blob)):
                continue
            found = self._look_for_plain(finder, blob)
            if turns.is_due(blob):
                turns.search(blob)
                if found is not None and not len(found):
                    found = self._look_closely(finder, blob)
            if found is not None and len(found):
                again.append((finder, found))
        for finder, poses in (*((k.finder, k.found.poses) for k in known), *again):
            self._hide_found()
            self._take(finder, poses)
        return [(f, b) for f, b in queue if not self._turns[f].is_due(b)]

    def _follow(self, finder: WholeObjectFinder) -> Iterator[_Followed]:
        """A target's known objects, each as it is found now."""
        for known in self._recall.known(finder.target.name):
            if self._frame.deadline.expired:
                return
            expected, recall = known.at(self._recall.clock_s), self._recall.config
            found = finder.followed(self._frame, expected, recall.left * known.votes, self._plain_climb)
            trust = self._judge.trust_in(finder, found.poses, self._frame)
            strayed = finder.strayed(found.poses, expected) if trust > 0 else np.inf
            trust = trust if strayed < 1 else 0.0
            well = trust > 0 and found.votes[0] >= recall.kept * known.votes and strayed < recall.strayed
            yield _Followed(finder, expected, found, trust, bool(well), self._recall.was_there(known))

    def _waits(self, finder: WholeObjectFinder, blob: Blob) -> bool:
        """Whether a blob is left alone in this frame; else it is searched now."""
        waits = self._turns[finder].waits(blob)
        if waits:
            self._recall.waiting += 1
        else:
            self._turns[finder].search(blob)
        return waits

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
