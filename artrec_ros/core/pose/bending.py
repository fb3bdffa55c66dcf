"""Objects whose joints carry joints, bent otherwise where labels like that better."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..image.image_frame import ImageFrame
from .climber import Climb
from .poses import PatchScores, Poses
from .ranked import Ranked
from .rebends import Rebends

if TYPE_CHECKING:
    from .finder import WholeObjectFinder


class Bending:
    """Of one object's hypotheses."""

    def __init__(self, finder: WholeObjectFinder) -> None:
        self._finder, self._surface, self._voter = finder, finder.surface, finder.voter
        self._search, self._inside = finder.config.search, float(finder.config.votes.inside[0])
        self._rebends = Rebends(self._surface, self._search, self._voter.value.hidden_cost)
        kin, s = self._surface.kinematics, self._surface
        self._jointed = s.markers[kin.moves[s.component[s.markers]].any(axis=1)]  # what joints carry

    def bent(self, frame: ImageFrame, found: Ranked, climb: Climb, begun: Poses | None = None) -> Ranked:
        """The same, the first one with joints bent otherwise where labels like that better.

        :param begun: poses with which the search has begun: their required component may be turned otherwise.
        """
        if not len(found):
            return found
        best = self._finder.rejointed(frame, found[:1], climb)
        if self._rebends.any:
            best = self._anew(frame, best, climb)
            if begun is not None and len(begun) and self._may_gain(frame, best):
                better = self._better(frame, best, begun, climb)
                best = best if better is best else self._anew(frame, better, climb)
        return best + found if best.votes[0] > found.votes[0] else found

    @property
    def any(self) -> bool:
        """Whether its joints carry joints: else a climb finds all there is."""
        return self._rebends.any

    def may_win(self, scores: PatchScores, votes: float) -> bool:
        """Whether one hypothesis has something to win by another bend. :param scores: of it. :param votes: its own."""
        m = self._jointed
        lost = np.maximum(self._inside * scores.area_px[0, m] - scores.votes[0, m], 0.0).sum()
        return bool(lost > self._search.bend_least * votes)

    def beginnings(self, frame: ImageFrame, poses: Poses) -> Poses:
        """One hypothesis as it fits the contours of its first half alone, its first fourth, and so on: what was drawn
        onto others' labels behind these does not move its required component."""
        used = self._voter.supports(frame, poses) & self._rebends.first_parts
        return self._finder.rest.fitted(frame, poses[np.zeros(len(used), int)], used)

    def _anew(self, frame: ImageFrame, best: Ranked, climb: Climb) -> Ranked:
        """One hypothesis with all joints sought anew while that is better, as it is turned and in its mirrored turns:
        these look alike, but with joints that were found for another one what hangs on the required component is
        elsewhere."""
        while not frame.deadline.expired and self._may_gain(frame, best):
            starts = Poses.concatenate([best.poses, self._finder.flips(best)])
            bent = self._better(frame, best, starts, climb)
            if bent is best:
                break
            best = bent
        return best

    def _better(self, frame: ImageFrame, best: Ranked, starts: Poses, climb: Climb) -> Ranked:
        """What some hypotheses come to with all joints sought anew, where that is better than the best; else that."""
        search, found = self._search, best[:0]
        for n in range(len(starts)):
            if len(found) and frame.deadline.expired:
                break
            tried = self._finder.ranked(frame, self._rebends.of(frame, starts[n : n + 1]))
            first = np.argsort(-tried.votes, kind="stable")[: search.bend_keep]
            tried = self._finder.climber.sweep(frame, tried[first])
            found = found + self._finder.fit_all(frame, tried.poses).best(search.bend_keep, search)
        found = self._finder.polished(frame, found.best(search.bend_keep, search), climb).best(1, search)
        return found if found.votes[0] > best.votes[0] else best

    def _may_gain(self, frame: ImageFrame, best: Ranked) -> bool:
        """Whether markers of the first hypothesis that joints carry, and that should be in view, lie so far off their
        labels that another bend has something to win."""
        return self.may_win(self._voter.judge(frame, best.poses, occlusion=True), float(best.votes[0]))
