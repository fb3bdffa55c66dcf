"""Which of several targets it is that is seen in one place.

Who explains most takes its pixels, and nothing is left of who explains as much: a target of the same colours, laid
otherwise, or as it would be a little larger. Such a rival may be what is there instead: both are brought to rest, and
compared as two turns of one object are, by what both explain and by how near edges lie to contours.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
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
    """What may be there instead of an object. :ivar log_odds: of that."""

    verdict: Verdict
    log_odds: float


def decided(
    accepted: Sequence[Verdict], rivals: Mapping[Verdict, Sequence[Verdict]], judge: Judge, deadline: Deadline
) -> tuple[list[Verdict], dict[Verdict, list[Rival]]]:
    """Objects, each the likeliest of its rivals, and what is left of these.

    :param rivals: of each verdicts by all pixels. :param deadline: after it no more of them are compared.
    """
    told, left = list(accepted), dict[Verdict, list[Rival]]()
    for n, verdict in enumerate(accepted):
        least = verdict.finder.config.verdict.mirrored_votes * verdict.votes
        large = [v for v in rivals.get(verdict, ()) if v.votes >= least and not deadline.expired]
        may_be = [again for v in large if (again := _instead_of(verdict, v, judge)) is not None]
        if not may_be:
            continue
        near = [Rival(verdict, 0.0), *(Rival(v, _odds(verdict, v)) for v in may_be)]
        first = max(near, key=lambda one: one.log_odds)
        told[n] = first.verdict
        left[first.verdict] = [Rival(v, odds - first.log_odds) for v, odds in near if v is not first.verdict]
    return told, left


def _instead_of(verdict: Verdict, rival: Verdict, judge: Judge) -> Verdict | None:
    """A rival by the pixels that an object was judged by; None: so it is none, or most of it lies on others' pixels:
    half hidden by them it may be of any size."""
    again = judge.verdicts(rival.finder, rival.poses, verdict.claim.frame.unhurried())[0]
    if judge.reason(again) or again.votes < verdict.finder.config.verdict.mirrored_votes * rival.votes:
        return None
    return replace(again, owners=verdict.owners, alone=rival.probability)


def beside_rivals(detection: Detection, rivals: Sequence[Rival]) -> Detection:
    """A detection that may be another target's object."""
    if not rivals:
        return detection
    shares = shares_beside([rival.log_odds for rival in rivals]).tolist()
    best = max(range(1, len(shares)), key=shares.__getitem__)
    told, finder = as_it_lies(detection, shares[0]), rivals[best - 1].verdict.finder
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
