"""Which of several targets it is that is seen in one place.

Who explains most takes its pixels, and nothing is left of who explains as much: a target of the same colours, laid
otherwise, or as it would be a little larger. Such a rival may be what is there instead: both are brought to rest, and
compared as two turns of one object are, by what both explain and by how near edges lie to contours.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.deadline import Deadline
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..model.found import Detection, OtherObject
from ..pose.between_targets import Laid, said_of
from ..pose.finder import WholeObjectFinder
from ..pose.laid_otherwise import shares_beside
from ..pose.poses import Poses
from .claims import silhouette
from .judge import Judge
from .like_targets import Before, LikeTargets, Past
from .otherwise import as_it_lies
from .verdicts import Verdict


def rivals_of(
    taking: Mapping[int, Verdict], others: Mapping[int, Verdict], boxes: Array, worth: Array
) -> dict[Verdict, list[Verdict]]:
    """Of each who took pixels those in its place of other targets, of each of these the best: each of the two is about
    the other's middle.

    :param taking, others: by their rows. :param boxes: (N, 2, 2) of all rows, least and greatest x, y.
    :param worth: (N,) of them, by all pixels.
    """
    out, middles = dict[Verdict, list[Verdict]](), boxes.mean(axis=1)
    stood = np.array(sorted(others, key=lambda n: -worth[n]), np.int64)
    for row, verdict in taking.items():
        about = _holds(boxes[row], middles[stood]) & _holds(boxes[stood], middles[row])
        best = dict[WholeObjectFinder, Verdict]()
        for n in stood[about].tolist():
            best.setdefault(others[n].finder, others[n])
        best.pop(verdict.finder, None)
        out[verdict] = list(best.values())
    return out


def _holds(boxes: Array, points: Array) -> NDArray[np.bool_]:
    """Whether boxes (..., 2, 2) hold points (..., 2)."""
    return np.asarray(((boxes[..., 0, :] <= points) & (points <= boxes[..., 1, :])).all(axis=-1))


class Rival(NamedTuple):
    """What may be there instead of an object. :ivar log_odds: of that. :ivar verdict: None: it was not compared."""

    finder: WholeObjectFinder
    log_odds: float
    verdict: Verdict | None = None


@dataclass(frozen=True)
class OtherObjects:
    """:param judge: what is an object. :param like: targets that may be taken for one another.
    :param past: what is known of them."""

    judge: Judge
    like: LikeTargets
    past: Past

    def decided(
        self, accepted: Sequence[Verdict], rivals: Mapping[Verdict, Sequence[Verdict]], deadline: Deadline
    ) -> tuple[list[Verdict], dict[Verdict, list[Rival]]]:
        """Objects, each the likeliest of its rivals, and what is left of these. Where they are as likely it is the one
        that was told before.

        :param rivals: of each verdicts by all pixels. :param deadline: after it no more of them are compared.
        """
        chosen, late = list[tuple[Verdict, list[Rival]]](), deadline.expired
        for verdict in accepted:
            mine = rivals.get(verdict, ())
            late = late or (bool(mine) and deadline.expired)
            chosen.append(self._choice(verdict, mine, late=late))
        return [verdict for verdict, _ in chosen], dict(chosen)

    def _choice(self, verdict: Verdict, rivals: Sequence[Verdict], *, late: bool) -> tuple[Verdict, list[Rival]]:
        """What is told of one object, and what it may be instead. Of what was not compared with it nothing is known but
        what was known before; else each is as likely."""
        open_to = [*self.like.at_once(verdict), *(v.finder for v in rivals)] if late else self.past.left_out(verdict)
        if not rivals and not open_to:
            return verdict, []
        before = self.past.before(verdict)
        near = [Rival(verdict.finder, 0.0, verdict), *(() if late else self._compared(verdict, rivals, before))]
        first = _first(near, before.told)
        odds = {f: before.log_odds.get(f.target.name, 0.0) for f in open_to}
        known = {one.finder for one in near}
        near += [Rival(f, log_odds) for f, log_odds in odds.items() if f not in known and log_odds > -np.inf]
        others = [one._replace(log_odds=one.log_odds - first.log_odds) for one in near if one is not first]
        return first.verdict or verdict, others

    def _compared(self, verdict: Verdict, rivals: Sequence[Verdict], before: Before) -> list[Rival]:
        least = verdict.finder.config.verdict.mirrored_votes * verdict.votes
        may_be = (self._instead_of(verdict, v) for v in rivals if v.votes >= least)
        there = ((v, before.with_frame(v.finder.target.name, _odds(verdict, v))) for v in may_be if v is not None)
        return [Rival(v.finder, log_odds, v) for v, log_odds in there]

    def _instead_of(self, verdict: Verdict, rival: Verdict) -> Verdict | None:
        """A rival by the pixels that an object was judged by; None: so it is none, or most of it lies on others'
        pixels: half hidden by them it may be of any size."""
        again = self.judge.verdicts(rival.finder, rival.poses, verdict.claim.frame.unhurried())[0]
        if self.judge.reason(again) or again.votes < verdict.finder.config.verdict.mirrored_votes * rival.votes:
            return None
        return replace(again, owners=verdict.owners, alone=rival.probability)


def _first(near: Sequence[Rival], before: str) -> Rival:
    """Which of these is told: the likeliest, or the one of before, if that is as likely. :param near: itself first."""
    best = max(near, key=lambda one: one.log_odds)
    least = best.log_odds - near[0].finder.config.verdict.least_turn_odds
    return next((r for r in near if r.finder.target.name == before and r.log_odds > least), best)


def beside_rivals(detection: Detection, rivals: Sequence[Rival]) -> Detection:
    """A detection that may be another target's object."""
    if not rivals:
        return detection
    shares = shares_beside([rival.log_odds for rival in rivals]).tolist()
    best = max(range(1, len(shares)), key=shares.__getitem__)
    told, finder = as_it_lies(detection, shares[0]), rivals[best - 1].finder
    if shares[best] <= finder.config.verdict.least_other_turn:
        return told
    return replace(told, other_object=OtherObject(finder.target.name, shares[best]))


def _odds(verdict: Verdict, rival: Verdict) -> float:
    """Log odds that it is the rival that is there, by the pixels that an object was judged by."""
    frame = verdict.claim.frame.unhurried()
    own, other = ((v.finder, _at_rest(v, frame)) for v in (verdict, rival))
    left = frame.without(silhouette(own[0].surface, frame.camera, own[1]))
    votes, others, beside = _votes(frame, *own), _votes(frame, *other), _votes(left, *other)
    found = said_of(frame, Laid(*own, votes), Laid(*other, others - max(beside, 0.0)))
    return found.log_odds(verdict.finder.config.verdict.rival_odds)


def _at_rest(verdict: Verdict, frame: ImageFrame) -> Poses:
    finder = verdict.finder
    return finder.rest.at_rest(frame, verdict.poses, finder.voter.supports(frame, verdict.poses))


def _votes(frame: ImageFrame, finder: WholeObjectFinder, pose: Poses) -> float:
    return float(finder.voter.votes(frame, pose, occlusion=True)[0])
