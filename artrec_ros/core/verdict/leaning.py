"""How sure objects are that were judged while others owned pixels.

What an object explains says nothing of those judged after it, as if it were known to be there. Where it is not,
its pixels speak for them, or against them: beside a boiler at .44 a strip of it that was left made a peg at .87, of
which nothing is left where the strip is seen to go on. So each object is as probable as it is with the owners of pixels
that it looks at, as far as they are there, and without those that are not (total probability). Of several the surest
are there as long as any is: who is half hidden by a sure one is not doubtful for what else lies near.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise

from ..model.found import Detection
from .claims import widened
from .judge import Judge
from .verdicts import Verdict


class Leaning:
    """Of one frame's objects. :param there: how probable some are by themselves; others are as they were judged."""

    def __init__(self, judge: Judge, there: Mapping[Verdict, float]) -> None:
        self._judge, self._there, self._shares = judge, there, dict[Verdict, float]()

    def share(self, verdict: Verdict) -> float:
        """The share of an object's probability that is left where owners may not be there."""
        if verdict not in self._shares:
            self._shares[verdict] = self._share(verdict)
        return self._shares[verdict]

    def _share(self, verdict: Verdict) -> float:
        with_all = verdict.probability
        if not verdict.owners or verdict.alone >= with_all:  # what they own takes nothing that speaks against it
            return 1.0
        sure = {v: self._there.get(v, v.probability) * self.share(v) for v in verdict.owners}
        owners = sorted(verdict.owners, key=sure.__getitem__)
        least, *steps = [*(sure[v] for v in owners), 1.0]
        out = least * with_all
        for n, (low, high) in enumerate(pairwise([least, *steps])):
            if high > low:
                out += (high - low) * min(self._beside(verdict, owners[n + 1 :]), with_all)
        return out / with_all

    def _beside(self, verdict: Verdict, owners: Sequence[Verdict]) -> float:
        """How probable an object is where none but these owns pixels."""
        if not owners:
            return verdict.alone
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
