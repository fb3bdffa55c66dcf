"""How sure objects are that were judged while others owned pixels.

What an object explains says nothing of those judged after it, as if it were known to be there. Where it is not,
its pixels speak for them, or against them: beside a boiler at .44 a strip of it that was left made a peg at .87, of
which nothing is left where the strip is seen to go on. So each object is as probable as it is with the owners of pixels
that it looks at, as far as they are there, and without those that are not (total probability). Of several, those that
are surer are there as long as any is: who is half hidden by a sure one is not doubtful for what else lies near.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..model.found import Detection
from .claims import widened
from .judge import Judge
from .verdicts import Verdict

_LEAST = 0.01  # by which owners' probabilities differ: less is not looked into, each look takes as long as a verdict


class Leaning:
    """Of one frame's objects. :param there: how probable some are by themselves; others are as they were judged."""

    def __init__(self, judge: Judge, there: Mapping[Verdict, float]) -> None:
        self._judge, self._there, self._shares = judge, there, dict[Verdict, float]()

    def share(self, verdict: Verdict) -> float:
        """The share of an object's probability that is left where owners may not be there."""
        waiting = [verdict]  # owners first, and theirs before: in a row of many one leans on the other
        while waiting:
            last = waiting.pop()
            missing = [v for v in last.owners if v not in self._shares]
            if missing:
                waiting += [last, *missing]
            elif last not in self._shares:
                self._shares[last] = self._share(last)
        return self._shares[verdict]

    def _share(self, verdict: Verdict) -> float:
        with_all = verdict.probability
        if not verdict.owners or verdict.alone >= with_all:  # what they own takes nothing that speaks against it
            return 1.0
        sure = {v: self._there.get(v, v.probability) * self._shares[v] for v in verdict.owners}
        owners = sorted(verdict.owners, key=sure.__getitem__)
        steps = np.array([sure[v] for v in owners])
        first = 1 + int(np.argmax(np.diff(steps))) if steps[-1] - steps[0] > _LEAST else 0  # of those that are surer
        least, surer = float(steps[0]), float(steps[first])
        out = least * with_all + (1 - surer) * verdict.alone
        if surer > least:
            out += (surer - least) * min(self._beside(verdict, owners[first:]), with_all)
        return out / with_all

    def _beside(self, verdict: Verdict, owners: Sequence[Verdict]) -> float:
        """How probable an object is where none but these owns pixels."""
        solids = [widened(hull, v.wider_px) for v in owners for hull in v.claim.solids.corners]
        frame = verdict.claim.frame.unowned.unhurried().without(solids)
        verdicts = self._judge.verdicts(verdict.finder, verdict.poses, frame)
        larger = self._judge.swollen(verdicts) if verdict.wider_px else ()
        return max(float(v.probability[0]) for v in (verdicts, *(swollen for swollen, _, _ in larger)))

    def rated(self, detection: Detection, verdict: Verdict) -> Detection:
        """A detection as sure as that."""
        return _rated(detection, self.share(verdict))


def _rated(d: Detection, share: float) -> Detection:
    if share >= 1:
        return d
    parts, other = tuple(part.rated(part.score * share) for part in d.components), d.other_place
    if other is not None and other.told is not None:
        other = replace(other, told=_rated(other.told, share))
    return replace(d, score=d.score * share, components=parts, other_place=other, beyond_others=share)
