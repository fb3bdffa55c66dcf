"""One look at one blob, or for one known object: what it shows depends on the frame alone."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .base.config import RecallConfig, SearchConfig
from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .memory.memory import Known
from .pose.climber import Climb
from .pose.distinct import is_near
from .pose.finder import WholeObjectFinder
from .pose.poses import Poses
from .pose.ranked import Ranked
from .verdict.judge import Judge
from .verdict.verdicts import Verdicts


@dataclass(frozen=True, eq=False)
class Followed:
    """A known object.

    :param expected: where it may be. :param trust: 0: it is not there. :param well: it is there as it was.
    :param behind: it is followed in what others leave.
    """

    known: Known
    finder: WholeObjectFinder
    expected: Poses
    found: Ranked
    trust: float
    well: bool
    behind: bool = False


class SpatialLooks:
    """How blobs are looked at."""

    def __init__(self, judge: Judge, config: SearchConfig) -> None:
        self.judge, self._config = judge, config
        climbs = zip(config.climb_hypotheses, config.climb_rounds, config.climb_first_steps, strict=True)
        self._climbs = [Climb(*climb) for climb in climbs]
        before_last = self._climbs[max(len(self._climbs) - 2, 0)]
        self._plain_climb = self._climbs[-1]._replace(rounds=before_last.rounds)

    def follow(
        self, frame: ImageFrame, finder: WholeObjectFinder, known: Known, now_s: float, config: RecallConfig
    ) -> Followed:
        """A known object as it is found now. :param now_s: of the memory's clock."""
        expected, found = self.near(frame, finder, known, now_s, config)
        trust = self.judge.trust_in(finder, found.poses, frame)
        strayed = finder.strayed(found.poses, expected) if trust > 0 else np.inf
        if strayed >= 1:
            return Followed(known, finder, expected, found, 0.0, False)
        well = bool(found.votes[0] >= config.kept * known.votes) and strayed < config.strayed
        return Followed(known, finder, expected, found, trust, well)

    def near(
        self, frame: ImageFrame, finder: WholeObjectFinder, known: Known, now_s: float, config: RecallConfig
    ) -> tuple[Poses, Ranked]:
        """Where a known object is expected, and what it has most votes for next to that, best first."""
        expected = known.at(now_s)
        expected = replace(expected, q=finder.surface.kinematics.bound(expected.q))
        return expected, finder.followed(frame, expected, known.votes, config.left, self._plain_climb)

    def plain(self, frame: ImageFrame, finder: WholeObjectFinder, blob: Blob) -> Poses | None:
        """An object beyond doubt whose required component made a blob, by a few guesses, and its rivals, best first;
        none where there is doubt. None: nor is the blob worth a longer look, for others would lead to the object."""
        if not finder.is_plain:
            return finder.surface.no_poses
        found = finder.plain_guesses(frame, blob)
        if not len(found):
            return None if finder.is_alike_throughout else found.poses
        verdicts = self.judge.verdicts(finder, found.poses if finder.is_alike_throughout else found.poses[:1], frame)
        if finder.is_alike_throughout and self._is_hopeless(verdicts, climbs=1):
            return None
        if self.judge.trust(verdicts[0]) <= self._config.sure:
            return found.poses[:0]
        begun, found = found.poses, finder.climbed(frame, found, self._plain_climb, sure=True)
        return finder.bending.bent(frame, found, self._plain_climb, begun).poses

    def close(self, frame: ImageFrame, finder: WholeObjectFinder, blob: Blob, piece: int = 0) -> Poses:
        """Hypotheses of which a component made a blob, or part of one, best first. :param piece: see `scale_range`."""
        found, aside = self._climbed(frame, finder, finder.guesses(frame, blob, piece))
        niche = self._config.niche_rad, self._config.niche_range
        if not len(aside) or is_near(found.poses, aside.poses, *niche).any() or frame.deadline.expired:
            return found.poses
        again = finder.climbed(frame, aside, self._plain_climb, sure=True)
        poses = Poses.concatenate([found.poses, again.poses])
        worth = self.judge.worth(self.judge.verdicts(finder, poses, frame))
        return poses[np.argsort(-worth, kind="stable")]

    def _climbed(self, frame: ImageFrame, finder: WholeObjectFinder, found: Ranked) -> tuple[Ranked, Ranked]:
        """Guesses after all climbs; and the one that was worth most on the way, where it was not the first: what lies
        across several things of its class has more votes than what lies on one of them."""
        sure, aside, most = False, found[:0], 0.0
        for number, climb in enumerate(self._climbs):
            if frame.deadline.expired or not (found.votes > 0).any():
                break
            verdicts = self.judge.verdicts(finder, found.poses, frame)
            if self._is_hopeless(verdicts, climbs=number):
                return found, aside
            worth = self.judge.worth(verdicts)
            if (best := int(np.argmax(worth))) > 0 and worth[best] > most:
                aside, most = found[best : best + 1], float(worth[best])
            sure = sure or self.judge.trust(verdicts[0]) > self._config.sure
            if not sure or climb is self._climbs[-1]:
                found = finder.climbed(frame, found, climb, sure=sure)
        # bent otherwise, what is in doubt would find parts of others
        return finder.bending.bent(frame, found, self._plain_climb) if sure else found, aside

    def thorough(self, frame: ImageFrame, finder: WholeObjectFinder, blob: Blob) -> Poses:
        """A close look, and where what it shows is not beyond doubt, at a blob that several things may make up, one in
        each range of their sizes: the most probable hypothesis comes first."""
        found, best, most = [self.close(frame, finder, blob)], 0, 0.0
        pieces = self._config.pieces if finder.may_be_several(blob) else 0
        if pieces:
            most = self.judge.trust_in(finder, found[0], frame)
        for piece in range(1, pieces + 1):
            if most > self._config.beyond_doubt or frame.deadline.expired:
                break
            found.append(self.close(frame, finder, blob, piece))
            trust = self.judge.trust_in(finder, found[-1], frame)
            if trust > max(most, self._config.sure):
                best, most = piece, trust
        return Poses.concatenate([found.pop(best), *found])

    def full(self, frame: ImageFrame, finder: WholeObjectFinder, blob: Blob) -> Poses | None:
        """What a plain look finds, or else a close one."""
        found = self.plain(frame, finder, blob)
        return found if found is None or len(found) else self.close(frame, finder, blob)

    def again(self, frame: ImageFrame, finder: WholeObjectFinder, poses: Poses) -> Poses | None:
        """One object bent anew, and begun from what its first components say; None where that explains no more."""
        found = finder.ranked(frame, poses)
        bent = finder.bending.bent(frame, found, self._plain_climb, finder.bending.beginnings(frame, poses))
        return bent.poses[:1] if bent.votes[0] > found.votes[0] else None

    def _is_hopeless(self, verdicts: Verdicts, *, climbs: int) -> bool:
        """Whether no climb will make an object of any of them: what they lack to be one they do not find on their way.

        The first climb may yet bring the required component to its place; later ones do not.
        """
        may_be = self.judge.may_stand(verdicts) & (verdicts.probability >= self._config.hopeless)
        return not may_be.any() or (climbs > 0 and not self.judge.shows_required(verdicts[0]))
