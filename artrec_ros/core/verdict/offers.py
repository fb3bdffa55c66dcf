"""Objects that are told; the pixels of those that are not are offered to others again.

An object takes its pixels as soon as the labels bear it out. Only when all are brought to rest is it known how many
there are of what occurs once, and what is sure enough to be told of each: one that then goes has kept others from what
it leaves. So pixels are shared out again without it, as long as more comes of that.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.blobs import Blob
from ..image.image_frame import ImageFrame
from ..model.found import Detection
from ..model.frame_result import Rejection
from ..pose.finder import WholeObjectFinder
from ..pose.poses import Poses
from .descriptions import Describer
from .enough import enough_of, without_surplus
from .judge import Judge
from .leaning import Leaning
from .like_targets import LikeTargets, Past
from .other_objects import OtherObjects, Rival, beside_rivals, not_said, shares_of
from .ownership import Shared
from .verdicts import Verdict

_ROUNDS = 3  # what one that went has kept away may go in its turn
Found = Sequence[tuple[WholeObjectFinder, Poses]]


@dataclass(frozen=True)
class Told:
    """What is told of a frame.

    :param detections: of each target. :param others: that are not told. :param doubtful: why.
    :param verdicts: of each target those on its objects. :param shared: as of `share_out`.
    :param surplus: verdicts on objects of which there are enough.
    :param fallen: verdicts on those that are not told by what is told of them.
    :param go_on: of each target those from which the next frame goes on: see `Described`.
    :param rivals: of all that are objects what each may be instead. :param shares: of these how probable it is.
    """

    detections: Sequence[Sequence[Detection]]
    others: Sequence[Detection]
    doubtful: Sequence[Rejection]
    verdicts: Sequence[Sequence[Verdict]]
    shared: Shared
    surplus: Sequence[Verdict]
    fallen: Sequence[Verdict]
    go_on: Sequence[Sequence[Verdict]] = ()
    rivals: Mapping[Verdict, Sequence[Rival]] = field(default_factory=dict)
    shares: Mapping[Verdict, float] = field(default_factory=dict)

    @property
    def worth(self) -> float:
        """How many of its objects are there, as far as is known."""
        return sum(d.score for mine in self.detections for d in mine)

    def left(self, found: Found) -> Found:
        """The candidates without those in the places of what is not told: of targets of which there are enough none is
        left but those that are told."""
        enough = {v.claim.finder for v in self.surplus}
        kept = [(v.claim.finder, v.claim.poses) for mine in self.verdicts for v in mine if v.claim.finder in enough]
        rest = ((finder, poses) for finder, poses in found if finder not in enough)
        return [*kept, *((finder, poses[self._elsewhere(finder, poses)]) for finder, poses in rest)]

    def _elsewhere(self, finder: WholeObjectFinder, poses: Poses) -> NDArray[np.bool_]:
        """(H,) which of these are not in the place of one that fell, or are in that of one that is told."""
        fallen = [v for v in self.fallen if v.claim.finder is finder]
        return ~_in_place_of(fallen, finder, poses) | _in_place_of(self.standing(finder), finder, poses)

    def standing(self, finder: WholeObjectFinder) -> list[Verdict]:
        """Verdicts on one target's objects that are told."""
        return [v for mine in self.verdicts for v in mine if v.claim.finder is finder and v not in self.fallen]

    def may_be_another(self, verdict: Verdict) -> bool:
        """Whether one that is told may well be another one of its target."""
        least = verdict.finder.config.verdict.least_other_turn
        odds = (math.exp(min(rival.log_odds, 1.0)) for rival in self._of_its_target(verdict))  # at most a half is asked
        return any(one * (1 - least) > least for one in odds)

    def of_enough(self, verdict: Verdict) -> list[Rival]:
        """Rivals of its target of one of which there are enough: these are no candidates any more."""
        enough = any(v.finder is verdict.finder for v in self.surplus)
        return self._of_its_target(verdict) if enough else []

    def _of_its_target(self, verdict: Verdict) -> list[Rival]:
        """Those that may be there instead of an object of a target, of this target."""
        finder = verdict.finder
        there = [v for v, rivals in self.rivals.items() if rivals and v.finder is finder]
        there = [v for v in there if _in_place_of([v], finder, verdict.poses).all()]
        return [r for v in there for r in self.rivals[v] if r.finder is finder]

    def keeps(self, other: Told) -> bool:
        """Whether all that the other one tells is told here, too: nothing sure is given up for several in doubt."""
        finders = {v.claim.finder for mine in other.verdicts for v in mine}
        return all(
            _in_place_of(self.standing(finder), finder, v.claim.poses).all()
            for finder in finders
            for v in other.standing(finder)
        )


def _in_place_of(verdicts: Sequence[Verdict], finder: WholeObjectFinder, poses: Poses) -> NDArray[np.bool_]:
    """(H,) which poses put an object where one of these is."""
    if not verdicts or not len(poses):
        return np.zeros(len(poses), bool)
    there = Poses.concatenate([v.claim.poses for v in verdicts])
    found = finder.required.is_in_place_of(poses, there, finder.config.search.niche_rad)
    return np.asarray(found.any(axis=1))


@dataclass(frozen=True)
class Offers:
    """:param frame: where objects are. :param blobs: in which what they lack may be.
    :param like: targets that may be taken for one another. :param past: what is known of them.
    :param known: of targets where earlier frames have their objects.
    :param surplus_alone: whether only what occurs too often is offered again: in space half hidden objects fall in most
        frames of a crowd, and each time would take as long as the first.
    """

    describers: Sequence[Describer]
    judge: Judge
    frame: ImageFrame
    blobs: Sequence[Blob]
    like: LikeTargets
    past: Past
    known: Mapping[WholeObjectFinder, Poses] = field(default_factory=dict)
    surplus_alone: bool = False

    def told(self, found: Found, shared: Shared, share: Callable[[Found], Shared | None]) -> Told:
        """What is told of objects, those among them that others have kept away.

        :param found: all candidates. :param shared: what became of them. :param share: `share_out`; None: too late.
        """
        best = told = self._once(shared)
        for _ in range(_ROUNDS - 1):
            gone = told.surplus or (told.fallen and not self.surplus_alone)
            if not gone or self.frame.deadline.expired:
                break
            found, before = told.left(found), told
            again = share(found)
            if again is None:
                break
            told = self._once(again, before)
            surplus, others = [*before.surplus, *told.surplus], [*before.others, *told.others]
            told = replace(told, others=others, doubtful=[*before.doubtful, *told.doubtful], surplus=surplus)
            told = replace(told, shares={**before.shares, **told.shares})
            best = told if told.worth > best.worth and told.keeps(best) else best
        return best

    def _once(self, shared: Shared, before: Told | None = None) -> Told:
        choice = OtherObjects(self.judge, self.like, self.past)
        accepted, rivals = choice.decided(shared.accepted, shared.rivals, self.frame.deadline)
        shared = shared._replace(accepted=accepted)
        told, surplus, objects, instead = without_surplus(self.describers, accepted, self.frame, self.judge)
        for v in (v for mine in told for v in mine):
            rivals[v] = [*rivals.get(v, ()), *instead.get(v, ()), *(before.of_enough(v) if before else ())]
        shares = dict[Verdict, float]()
        detections, fallen = list[Sequence[Detection]](), list[Verdict]()
        others, doubtful = list[Detection](), list[Rejection]()
        each = [
            d.described(mine, self.frame, objects, self.blobs, self.known.get(d.finder))
            for d, mine in zip(self.describers, told, strict=True)
        ]
        described, go_on = [d.detections for d in each], [d.verdicts for d in each]
        leaning = self._leaning(shared.accepted, described, surplus)
        for describer, mine, seen in zip(self.describers, told, described, strict=True):
            lie = [(leaning.rated(d, v), v) for d, v in zip(seen, _behind(mine, seen), strict=True)]
            for d, v in lie:
                of = zip(rivals.get(v, ()), shares_of(d, rivals.get(v, ()))[1:], strict=True)
                shares |= {r.verdict: share for r, share in of if r.verdict is not None}
            rivals |= {v: not_said(d, v, rivals.get(v, ())) for d, v in lie}
            rated = [beside_rivals(d, v, rivals[v]) for d, v in lie]
            sure, unsure, reasons = enough_of(rated, describer.finder, self.judge)
            detections.append(sure)
            others += unsure
            doubtful += reasons
            fallen += _behind(mine, unsure)
        return Told(detections, others, doubtful, told, shared, surplus, fallen, go_on, rivals, shares)

    def _leaning(
        self, accepted: Sequence[Verdict], described: Sequence[Sequence[Detection]], surplus: Sequence[Verdict]
    ) -> Leaning:
        """How far objects lean on others, those of which there are enough being none."""
        there = dict[Verdict, float]()
        if any(v.owners for v in accepted):
            for describer, seen in zip(self.describers, described, strict=True):
                mine = [v for v in accepted if v.finder is describer.finder]
                there |= zip(_behind(mine, seen), (d.there for d in seen), strict=True)
                gone = [v.poses.t[0] for v in surplus if v.finder is describer.finder]
                there |= dict.fromkeys(_nearest(mine, gone), 0.0)
        return Leaning(self.judge, there)


def _behind(verdicts: Sequence[Verdict], detections: Sequence[Detection]) -> list[Verdict]:
    """The verdict that each detection with a pose is about: nothing else is as near to where it came to rest."""
    return _nearest(verdicts, [d.pose.position for d in detections if d.pose is not None])


def _nearest(verdicts: Sequence[Verdict], places: Sequence[Array]) -> list[Verdict]:
    """Of each place the verdict on what is nearest to it."""
    there = np.array([v.claim.poses.t[0] for v in verdicts])
    return [verdicts[int(np.linalg.norm(there - place, axis=1).argmin())] for place in places]
