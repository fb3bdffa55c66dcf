"""Which way round flat objects lie that look almost the same turned otherwise.

Votes count pixels, and a search keeps the first turn that has many. Both turns are brought to rest alike, and compared
by votes and by how near to their contours the labels' edges lie, as mirrored turns in space are, and by the names that
they show. So is what lies elsewhere with other markers where seen ones are: of several that the image bears out alike
each is as probable.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .alternatives import Reading
from .differing import odds_among
from .finder import WholeObjectFinder
from .poses import Poses
from .turn_evidence import odds_by_seen, turn_odds
from .unseen import in_view, log_unseen, log_unseen_bent


@dataclass(frozen=True, eq=False)
class Layouts:
    """H poses at rest, and behind them n others: turned so that each marker lies on a like one where they do; or so
    that like ones lie where those are that are seen, and the others elsewhere.

    :param of: (n,) of which pose each of these is. :param log_odds: (n,) that it is the true one, names apart.
    :param by_seen: (n,) whether it is by the markers that are seen alone.
    :param read: what the pixels of these H + n say.
    """

    poses: Poses
    of: NDArray[np.int64]
    log_odds: Array
    by_seen: NDArray[np.bool_]
    read: Reading

    @classmethod
    def around(
        cls,
        finder: WholeObjectFinder,
        frame: ImageFrame,
        poses: Poses,
        shows: Sequence[ImageFrame] = (),
        seen: Sequence[Collection[int]] = (),
        leaves: Callable[[int, Poses], Array] | None = None,
    ) -> Layouts:
        """Those of H poses; of those for which there is no time none but what seen markers ask for, all as likely.

        :param shows: of each pose the frame in which its names are read: what others own tells nothing of its name.
            Not given: all of the frame is its own. :param seen: of each its components that are. Not given: all.
        :param leaves: log odds of poses of one of them, of which the first is it, by what they leave unexplained.
        """
        looks = list(shows) or [frame] * len(poses)
        found, odds, of, by_seen = [poses], [np.zeros(0)], list[int](), list[bool]()
        for h, look in enumerate(looks):
            pose = poses[h : h + 1]
            for asked in _asked(finder, frame, look, pose, seen[h] if seen else None):
                others, log_odds = _compared(finder, frame, pose, asked, leaves and partial(leaves, h))
                found.append(others)
                odds.append(log_odds)
                of += [h] * len(others)
                # of a lone one which way round it is counts where its file says more than that it is alike
                uncounted = asked.same if finder.surface.is_lone_marker else np.zeros(len(others), bool)
                by_seen += (asked.by_seen & ~uncounted).tolist()
        every, whose = Poses.concatenate(found), np.array([*range(len(poses)), *of], np.int64)
        read = finder.alternatives.read([looks[h] for h in whose.tolist()], every)
        return cls(every, whose[len(poses) :], np.concatenate(odds), np.array(by_seen, bool), read)

    def evidence(self) -> Array:
        """(H, N) of the poses' identities, whichever way round they lie."""
        told, turned = np.split(self.read.evidence, [len(self.poses) - len(self.of)])
        out = told.copy()
        np.logaddexp.at(out, self.of, turned + self.log_odds[:, None])
        return out

    def one_of_them(self) -> Array:
        """(H,) log odds that the poses' objects are of the identities that are declared, the way round that shows one
        best: of several ways one does so by chance the more easily."""
        told, turned = np.split(self.read.listed, [len(self.poses) - len(self.of)])
        out = told.copy()
        np.maximum.at(out, self.of, turned)
        return np.asarray(out - np.log1p(np.bincount(self.of, minlength=len(out))))

    def likelier(self, names: Sequence[int | None] = ()) -> tuple[Poses, NDArray[np.int64]]:
        """The H poses, turned where another turn is likelier, and rows of those that are turned.

        :param names: of each its identity: all together may tell it though the pose does not. None: of any.
        """
        likelihood, h = self._likelihood(names), len(self.poses) - len(self.of)
        rows = np.arange(h)
        for n, whose in enumerate(self.of.tolist(), h):
            if likelihood[n] > likelihood[rows[whose]]:
                rows[whose] = n
        return self.poses[rows], np.flatnonzero(rows >= h)

    def as_told(self, names: Sequence[int | None] = ()) -> Array:
        """(H,) how probable it is that objects lie as the H poses say, and are not turned as a whole: 1 of those of
        which no turn is likelier. :param names: as of `likelier`."""
        likelihood, h, turns = self._likelihood(names), len(self.poses) - len(self.of), ~self.by_seen
        likeliest = likelihood[:h].copy()
        np.maximum.at(likeliest, self.of[turns], likelihood[h:][turns])
        return np.where(likelihood[:h] < likeliest, self._among(turns, likelihood), 1.0)

    def as_told_unnamed(self, names: Sequence[int | None]) -> Array:
        """(H,) the same of objects without a name, among those of their turns that show another name than they do: of
        which name is not known direction is not known, either. :param names: as of `likelier`."""
        evidence, unnamed = self.read.evidence, np.array([name is None for name in names], bool)
        if not evidence.shape[1] or not unnamed.any():
            return np.ones(len(unnamed))
        best = evidence.argmax(axis=1)
        renamed = ~self.by_seen & unnamed[self.of] & (best[len(unnamed) :] != best[self.of])
        return self._among(renamed, self._likelihood(names))

    def _among(self, others: NDArray[np.bool_], likelihood: Array) -> Array:
        """(H,) how probable the H poses are beside some of the others (n,)."""
        h = len(self.poses) - len(self.of)
        total = likelihood[:h].copy()
        np.logaddexp.at(total, self.of[others], likelihood[h:][others])
        return np.asarray(np.exp(likelihood[:h] - total))

    def shares(self, names: Sequence[int | None] = ()) -> Array:
        """(H + n,) how probable each pose is among those that lay like markers where its own are seen, and these; 0 of
        what turns the whole object. :param names: as of `likelier`."""
        likelihood, h = self._likelihood(names), len(self.poses) - len(self.of)
        likelihood[h:][~self.by_seen] = -np.inf
        total = likelihood[:h].copy()
        np.logaddexp.at(total, self.of, likelihood[h:])
        return np.asarray(np.exp(likelihood - np.concatenate([total, total[self.of]])))

    def _likelihood(self, names: Sequence[int | None]) -> Array:
        """(H + n,) logarithms, of each pose and its others up to a constant. :param names: as of `likelier`."""
        h, named = len(self.poses) - len(self.of), np.zeros(len(self.poses))
        whose = np.concatenate([np.arange(h), self.of])
        if self.read.evidence.shape[1]:
            named = np.logaddexp.reduce(self.read.evidence, axis=1)
            known = [row for row, n in enumerate(whose.tolist()) if names and names[n] is not None]
            named[known] = [self.read.evidence[row, names[whose[row]]] for row in known]
        return np.asarray(named + np.concatenate([np.zeros(h), self.log_odds]))


class _Asked(NamedTuple):
    """Other placements of an object that are to be compared with one.

    :ivar same: (K,) after which of them what is seen is the same, not only alike. :ivar look: by which pixels.
    :ivar by_seen: whether they are by the markers that are seen alone.
    :ivar lone: the only component that is seen, of what is turned about it: what the others say, which are not, counts
        against no place by more than something unknown may hide them where they would be.
    :ivar fitted: whether they were found by fits, and may lie on nothing.
    """

    others: Poses
    same: NDArray[np.bool_]
    look: ImageFrame
    by_seen: bool
    lone: int | None = None
    fitted: bool = False


def _asked(
    finder: WholeObjectFinder, frame: ImageFrame, look: ImageFrame, pose: Poses, seen: Collection[int] | None
) -> Iterator[_Asked]:
    """Those of one object.

    :param seen: its components that are; None: nobody asks for those by what is seen.
    :param look: in which no pixels are others': where an unseen marker would be these may have its class.
    """
    if finder.exchanges and not frame.deadline.expired:
        yield _Asked(finder.exchanges.of(pose), finder.exchanges.same, frame, False)
    if finder.seen_alike is None or seen is None:
        return
    others = finder.seen_alike.of(seen)
    laid = others.of(pose)
    if finder.surface.is_lone_marker:  # all its turns together: two by two each may be the likelier one
        yield _Asked(laid, others.same, look, True)
    elif len(others):
        yield _Asked(laid, others.same, look, True, next(iter(seen)) if len(seen) == 1 else None)
    if finder.on_likes.any and not frame.deadline.expired:
        own = look.unhurried()  # it may be the judge's, whose time is over
        on_likes, whole = finder.on_likes.of(own, pose, seen), len(seen) == len(finder.target.model.components)
        same = finder.on_likes.same(frame.camera, pose, on_likes) & whole
        none = np.zeros(len(on_likes), bool)
        yield _Asked(on_likes[np.flatnonzero(~same)], none[~same], own, True, fitted=True)
        yield _Asked(on_likes[np.flatnonzero(same)], none[same], own, False, fitted=True)


def _compared(
    finder: WholeObjectFinder,
    frame: ImageFrame,
    pose: Poses,
    asked: _Asked,
    leaves: Callable[[Poses], Array] | None = None,
) -> tuple[Poses, Array]:
    """Other placements of an object, at rest, and log odds that it lies so: even ones where there is no time, and, by
    the markers seen, where it is likelier but not clearly so, as of mirrored turns."""
    others, look, config = asked.others, asked.look, finder.config.verdict
    if frame.deadline.expired or not len(others):
        others = others[:0] if asked.fitted else others
        return others, np.zeros(len(others))
    both = Poses.concatenate([pose, others])
    both = finder.rest.at_rest(frame, both, finder.voter.supports(frame, both))
    others = both[1:]
    told = both[np.zeros(len(others), int)]
    if asked.fitted or (asked.by_seen and asked.lone is None and not finder.surface.is_lone_marker):
        odds = odds_by_seen(finder, look, told, others)
        scores = finder.voter.judge(look, both, occlusion=True)
        unseen = log_unseen(finder, in_view(finder, look, both, scores).lacking)
        odds = odds + unseen[1:] - unseen[0] + (leaves(both)[1:] if leaves is not None else 0.0)
        if asked.fitted:
            kept = finder.on_likes.distinct(frame.camera, both[:1], others, odds)
            others, odds = others[kept], odds[kept]
    elif finder.surface.is_lone_marker:
        return others, odds_among(finder, look, both)
    else:
        odds = turn_odds(finder, look, told, others)
    if asked.lone is not None:
        alone = np.zeros(len(others))  # how well a fit came to rest tells nothing of what is the same after its turn
        if not asked.same.all():
            alone = np.where(asked.same, 0.0, turn_odds(finder, look, told, others, asked.lone))
        odds = alone + _by_others(finder, look, both, asked.lone, odds - alone)
    return others, np.where(odds > config.least_turn_odds, odds, np.minimum(odds, 0.0)) if asked.by_seen else odds


def _by_others(finder: WholeObjectFinder, look: ImageFrame, both: Poses, lone: int, votes: Array) -> Array:
    """(K,) log odds of turns about a lone component by the others, behind the pose that is told: as far as these should
    be seen and are not; where labels show some of one after all, by votes.

    :param votes: (K,) log odds by these.
    """
    others = np.flatnonzero(finder.surface.component[finder.surface.markers] != lone)
    scores = finder.voter.judge(look, both, occlusion=True)
    seen = np.any(in_view(finder, look, both, scores).seen[:, others], axis=1)
    by_votes, most = seen[1:] | seen[0], np.log(1 / finder.config.verdict.hidden_share - 1)
    if not by_votes.all():
        unseen = log_unseen_bent(finder, look, both)
        votes = np.where(by_votes, votes, unseen[1:] - unseen[0])
    return np.clip(votes, -most, most)
