"""Which of several objects it is that is seen in one place.

Who explains most takes its pixels, and nothing is left of who explains as much: a target of the same colours, laid
otherwise, or as it would be a little larger; or the same target, beside one of whose parts lies another like patch.
Such a rival may be what is there instead: both are brought to rest, and compared as two turns of one object are, by
what both explain and by how near edges lie to contours.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
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
from ..pose.turn_evidence import even_odds
from .claims import silhouette
from .judge import Judge
from .like_targets import Before, LikeTargets, Past
from .other_places import beside_its_rivals, may_lie_as
from .otherwise import as_it_lies
from .own_rivals import is_same, of_its_target, side_by_side
from .verdicts import Verdict

_LEAST = 1e-9  # of a probability


def rivals_of(
    taking: Mapping[int, Verdict], others: Mapping[int, Verdict], beside: Collection[int], boxes: Array, worth: Array
) -> dict[Verdict, list[Verdict]]:
    """Of each who took pixels those in its place of other targets, of each of these the best: each of the two is about
    the other's middle; and of its own target those near to it that show something beside all who took some.

    :param taking, others: by their rows. :param beside: rows of those that do. :param boxes: (N, 2, 2) of all rows,
        least and greatest x, y. :param worth: (N,) of them, by all pixels.
    """
    out, middles = dict[Verdict, list[Verdict]](), boxes.mean(axis=1)
    stood = np.array(sorted(others, key=lambda n: -worth[n]), np.int64)
    for row, verdict in taking.items():
        about = _holds(boxes[row], middles[stood]) & _holds(boxes[stood], middles[row])
        best = dict[WholeObjectFinder, Verdict]()
        for n in stood[about].tolist():
            if n not in taking:
                best.setdefault(others[n].finder, others[n])
        best.pop(verdict.finder, None)
        near = np.array([n for n in stood.tolist() if n in beside and others[n].finder is verdict.finder], np.int64)
        meet = ((boxes[row, 0] <= boxes[near, 1]) & (boxes[near, 0] <= boxes[row, 1])).all(axis=1)
        out[verdict] = [*best.values(), *(others[n] for n in near[meet].tolist())]
    return out


def _holds(boxes: Array, points: Array) -> NDArray[np.bool_]:
    """Whether boxes (..., 2, 2) hold points (..., 2)."""
    return np.asarray(((boxes[..., 0, :] <= points) & (points <= boxes[..., 1, :])).all(axis=-1))


class Rival(NamedTuple):
    """What may be there instead of an object. :ivar log_odds: of that. :ivar verdict, pose: on it, and at rest; None:
    it was not compared."""

    finder: WholeObjectFinder
    log_odds: float
    verdict: Verdict | None = None
    pose: Poses | None = None


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
        """Objects, each the likeliest of its rivals, and what is left of these. Where another target's is as likely it
        is the one that was told before.

        :param rivals: of each verdicts by all pixels. :param deadline: after it no more of them are compared.
        """
        told, left, late = list(accepted), dict[Verdict, list[Rival]](), deadline.expired
        for verdict in accepted:
            if verdict not in told:  # it is the rival of one before
                continue
            mine = rivals.get(verdict, ())
            late = late or (bool(mine) and deadline.expired)
            near, first = self._near(verdict, mine, told, late=late)
            if len(near) == 1:
                left[verdict] = []
                continue
            own = [r.verdict for r in near[1:] if r.verdict is not None and r.finder is verdict.finder]
            several = side_by_side(own, verdict.finder, self.judge)
            shown = sum(sum(v.confirmed) for v in several)  # fewer parts than one shows are parts of it
            chosen = several if shown > sum(verdict.confirmed) else [first]
            told = _exchanged(told, verdict, chosen, near)
            left |= {v: [r for r in near if r.verdict is not first] if len(chosen) == 1 else [] for v in chosen}
        return told, {v: left[v] for v in told}

    def _near(
        self, verdict: Verdict, rivals: Sequence[Verdict], told: Sequence[Verdict], *, late: bool
    ) -> tuple[list[Rival], Verdict]:
        """What may be there, an object itself first, and which of these is told. Of what was not compared with it
        nothing is known but what was known before; else each is as likely. :param told: all that is."""
        finder = verdict.finder
        like = [*self.like.at_once(verdict), *(v.finder for v in rivals if v.finder is not finder)]
        open_to = like if late else self.past.left_out(verdict)
        if not rivals and not open_to:
            return [Rival(finder, 0.0, verdict)], verdict
        before = self.past.before(verdict)
        near = [Rival(finder, 0.0, verdict)] if late else self._compared(verdict, rivals, told, before)
        first = _first(near, before.told)
        odds = {f: before.log_odds.get(f.target.name, 0.0) for f in open_to}
        known = {one.finder for one in near}
        near += [Rival(f, log_odds) for f, log_odds in odds.items() if f not in known and log_odds > -np.inf]
        return [one._replace(log_odds=one.log_odds - first.log_odds) for one in near], first.verdict or verdict

    def _compared(
        self, verdict: Verdict, rivals: Sequence[Verdict], told: Sequence[Verdict], before: Before
    ) -> list[Rival]:
        """An object, and those of its rivals that may be there instead, as the frame and those before it have them."""
        finder, least = verdict.finder, verdict.finder.config.verdict.mirrored_votes * verdict.votes
        mine = [v for v in rivals if v.finder is finder]
        may_be = (self._instead_of(verdict, v) for v in rivals if v.finder is not finder and v.votes >= least)
        found = [v for v in may_be if v is not None]
        if mine:
            beside = [v for v in told if v is not verdict and not any(is_same(v, r) for r in mine)]
            found += of_its_target(verdict, mine, beside, self.judge)
        if not found:
            return [Rival(finder, 0.0, verdict)]
        pose = _at_rest(verdict, verdict.claim.frame.unhurried())
        return [Rival(finder, 0.0, verdict, pose), *(_against(finder, pose, v, before) for v in found)]

    def _instead_of(self, verdict: Verdict, rival: Verdict) -> Verdict | None:
        """A rival by the pixels that an object was judged by; None: so it is none, or most of it lies on others'
        pixels: half hidden by them it may be of any size."""
        again = self.judge.verdicts(rival.finder, rival.poses, verdict.claim.frame.unhurried())[0]
        if self.judge.reason(again) or again.votes < verdict.finder.config.verdict.mirrored_votes * rival.votes:
            return None
        return replace(again, owners=verdict.owners, alone=rival.probability)


def _first(near: Sequence[Rival], before: str) -> Rival:
    """Which of these is told: the likeliest, or the likeliest of the target of before, if that is as likely.

    :param near: itself first.
    """
    best = max(near, key=lambda one: one.log_odds)
    least = best.log_odds - near[0].finder.config.verdict.least_turn_odds
    there = (r for r in near if r.finder.target.name == before and r.log_odds > least)
    return max(there, key=lambda one: one.log_odds, default=best)


def _exchanged(
    told: Sequence[Verdict], verdict: Verdict, chosen: Sequence[Verdict], near: Sequence[Rival]
) -> list[Verdict]:
    """Objects with some in place of one: none of what may be there instead is told besides."""
    at, gone = told.index(verdict), [r.verdict for r in near if r.verdict is not None]
    rest = [[v for v in part if not any(is_same(v, r) for r in gone)] for part in (told[:at], told[at:])]
    return [*rest[0], *chosen, *rest[1]]


def not_said(detection: Detection, verdict: Verdict, rivals: Sequence[Rival]) -> list[Rival]:
    """Rivals without those of which a detection tells already, saying that its components may lie on other blobs."""
    camera, finder = verdict.claim.frame.camera, verdict.finder
    own = (r.finder is finder and r.pose is not None and may_lie_as(finder, camera, r.pose, detection) for r in rivals)
    return [rival for rival, said in zip(rivals, own, strict=True) if not said]


def beside_rivals(detection: Detection, verdict: Verdict, rivals: Sequence[Rival]) -> Detection:
    """A detection that may be another target's object, or another one of its own. One of them at most is there, and
    each is as probable as by itself if no other one is."""
    if not rivals:
        return detection
    told, *shares = shares_of(detection, rivals)
    each = list(zip(rivals, shares, strict=True))
    mine = [(r.pose, s) for r, s in each if r.finder is verdict.finder and r.pose is not None]
    out = as_it_lies(detection, told)
    if mine:
        frame = verdict.claim.frame.unhurried()
        poses = Poses.concatenate([_at_rest(verdict, frame), *(pose for pose, _ in mine)])
        lie = np.array([told, *(share for _, share in mine)])
        out = beside_its_rivals(verdict.finder, frame.camera, poses, lie, detection)
    others = [(s, r.finder) for r, s in each if r.finder is not verdict.finder]
    share, finder = max(others, key=lambda one: one[0], default=(0.0, verdict.finder))
    if share <= verdict.finder.config.verdict.least_other_turn:
        return out
    return replace(out, other_object=OtherObject(finder.target.name, share))


def shares_of(detection: Detection, rivals: Sequence[Rival]) -> list[float]:
    """(1 + K,) of what a detection is probable by itself, and how probable each of its rivals is."""
    there = np.log(max(detection.there, _LEAST))
    return shares_beside(there + np.array([rival.log_odds for rival in rivals])).tolist()


def _against(finder: WholeObjectFinder, own: Poses, verdict: Verdict, before: Before) -> Rival:
    """A rival of an object, by the pixels that the rival was judged by; another target's by earlier frames, too.

    :param own: the object's pose at rest.
    """
    frame, other = verdict.claim.frame.unhurried(), verdict.finder
    pose = _at_rest(verdict, frame)
    log_odds = _odds(frame, finder, own, other, pose)
    if other is not finder:
        log_odds = before.with_frame(other.target.name, log_odds)
    return Rival(other, log_odds, verdict, pose)


def _odds(frame: ImageFrame, finder: WholeObjectFinder, own: Poses, other: WholeObjectFinder, pose: Poses) -> float:
    """Log odds that it is a rival that is there. :param frame: the pixels that it was judged by. :param own, pose: at
    rest."""
    if finder is other:
        return float(even_odds(finder, frame, own, pose)[0])
    left = frame.without(silhouette(finder.surface, frame.camera, own))
    votes, others = _votes(frame, finder, own), _votes(frame, other, pose)
    beside = max(_votes(left, other, pose), 0.0)
    found = said_of(frame, Laid(finder, own, votes), Laid(other, pose, others - beside))
    return found.log_odds(finder.config.verdict.rival_odds)


def _at_rest(verdict: Verdict, frame: ImageFrame) -> Poses:
    finder = verdict.finder
    return finder.rest.at_rest(frame, verdict.poses, finder.voter.supports(frame, verdict.poses))


def _votes(frame: ImageFrame, finder: WholeObjectFinder, pose: Poses) -> float:
    return float(finder.voter.votes(frame, pose, occlusion=True)[0])
