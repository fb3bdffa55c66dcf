"""Targets whose objects may be taken for one another: which ones they are, and what is known of them in a place."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import NamedTuple, Protocol

from ..pose.finder import WholeObjectFinder
from .verdicts import Verdict


class LikeTargets:
    """Among some targets."""

    def __init__(self, finders: Sequence[WholeObjectFinder]) -> None:
        self._classes = {finder: Counter(map(frozenset, finder.surface.labels)) for finder in finders}

    def of(self, verdict: Verdict) -> list[WholeObjectFinder]:
        """Other targets that have all classes that an object shows: what lacks some explains too little of it."""
        if len(self._classes) < 2:
            return []
        shown = self._shown(verdict)
        return [f for f, classes in self._classes.items() if f is not verdict.finder and shown <= classes]

    def at_once(self, verdict: Verdict) -> list[WholeObjectFinder]:
        """Those of them that may begin in it, as far as is known without a look: it shows their required component's
        class."""
        labels = {label for own in self._shown(verdict) for label in own}
        return [f for f in self.of(verdict) if not labels.isdisjoint(f.root_labels)]

    def pairs(self, verdicts: Sequence[Verdict]) -> list[tuple[Verdict, WholeObjectFinder]]:
        """Objects, each with one of these."""
        return [(v, finder) for v in verdicts for finder in self.at_once(v)]

    def _shown(self, verdict: Verdict) -> Counter[frozenset[int]]:
        labels = verdict.finder.surface.labels
        return Counter(frozenset(own) for own, yes in zip(labels, verdict.confirmed, strict=True) if yes)


class Before(NamedTuple):
    """What is known of an object's place. :ivar told: the target whose object was told there last; empty: none was.
    :ivar log_odds: by their names, of other targets' against the object; -inf of what is not there.
    :ivar counts: what these count against those of the frame."""

    told: str = ""
    log_odds: Mapping[str, float] = {}
    counts: float = 0.0

    def with_frame(self, name: str, log_odds: float) -> float:
        """Log odds of a target's by the frame, too: labels say as much in one as in the next, errors change."""
        before = self.log_odds.get(name, -math.inf)
        return log_odds if before == -math.inf else self.counts * before + (1 - self.counts) * log_odds


class Past(Protocol):
    """What earlier frames, and looks of this one, say of like targets in an object's place."""

    def before(self, verdict: Verdict) -> Before: ...

    def left_out(self, verdict: Verdict) -> Sequence[WholeObjectFinder]:
        """Those that should be looked for there, and were not."""
