"""Accepted objects brought to rest as they are told: on the contours that the image shows of each, turned and bent as
is likeliest."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import chain
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.range_limits import range_limits
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..model.found import OtherTurn
from ..pose.along_joints import likelier_along
from ..pose.covariance import pose_covariances
from ..pose.finder import WholeObjectFinder
from ..pose.laid_otherwise import LaidOtherwise, likelier_laid
from ..pose.likelier_ends import likelier_ends
from ..pose.other_bends import likelier_bends
from ..pose.other_rests import likelier_rests
from ..pose.other_turns import likelier_turns, look_otherwise, other_of
from ..pose.poses import Poses
from ..pose.turn_evidence import turn_odds
from .judge import Judge
from .nearer import behind_others
from .verdicts import Verdict


class AtRest(NamedTuple):
    """H objects as they are told.

    :ivar verdicts: on them: anew on those that are laid, turned or bent otherwise than they were found.
    :ivar frames: what of the image each is looked for in: without what nearer ones hide. :ivar used: (H, M) markers
        whose contours tell where each is.
    :ivar others: their other turns. :ivar elsewhere: other poses at which their contours rest.
    :ivar laid: how else they may be laid by what is seen of them. :ivar along: how else joints may have moved what they
        carry.
    :ivar bends: (H, J) by how much joints' variances are greater for other bends.
    :ivar drawn: where each of several would come to rest if what nearer ones hide were its own: what they leave of
        their rims may be drawn onto them. Of what faces the camera where each is with its ends as they were found.
    """

    verdicts: Sequence[Verdict]
    frames: Sequence[ImageFrame]
    poses: Poses
    used: NDArray[np.bool_]
    others: Sequence[OtherTurn | None]
    elsewhere: Sequence[OtherTurn | None]
    laid: Sequence[LaidOtherwise | None]
    along: Sequence[LaidOtherwise | None]
    bends: Array
    drawn: Poses

    def of(self, rows: list[int]) -> AtRest:
        """Some of them."""
        verdicts, frames = [self.verdicts[n] for n in rows], [self.frames[n] for n in rows]
        others, elsewhere = ([column[n] for n in rows] for column in (self.others, self.elsewhere))
        laid, along = ([column[n] for n in rows] for column in (self.laid, self.along))
        poses, used = self.poses[rows], self.used[rows]
        rest = others, elsewhere, laid, along, self.bends[rows], self.drawn[rows]
        return AtRest(verdicts, frames, poses, used, *rest)

    def covariances(self, finder: WholeObjectFinder) -> Array:
        """(H, 6+J, 6+J) as of `pose_covariances`, and of joints that may be bent otherwise."""
        size, facing = 6 + self.poses.q.shape[1], finder.facing
        made, joints = np.empty((len(self.poses), size, size)), np.arange(6, size)
        for rows, frame in _by_frame(self.frames):
            at = frame, self.poses[rows], self.used[rows]
            made[rows] = pose_covariances(finder.surface, *at, finder.config, facing=facing)
        made[:, joints, joints] += self.bends
        return made


def at_rest(
    finder: WholeObjectFinder, verdicts: Sequence[Verdict], among: Sequence[Verdict], frame: ImageFrame
) -> AtRest:
    """One target's objects at rest, those in space turned as is likelier, and bent while there is time.

    :param among: all objects of the frame, other targets' too.
    """
    frames = [frame] * len(verdicts) if finder.facing else behind_others(verdicts, among, frame)
    groups = [(rows, [verdicts[n] for n in rows], look) for rows, look in _by_frame(frames)]
    parts = [_at_rest_in(look, finder, mine) for _, mine, look in groups]
    # of one alone nobody asks whether another is in its place
    parts = [
        part if look is frame or len(verdicts) == 1 else part._replace(drawn=_drawn_in(frame, finder, mine))
        for part, (_, mine, look) in zip(parts, groups, strict=True)
    ]
    if len(parts) == 1:
        return parts[0]
    judged, looks, poses, used, others, elsewhere, laid, along, bends, drawn = map(list, zip(*parts, strict=True))
    told = list(chain(*others)), list(chain(*elsewhere)), list(chain(*laid)), list(chain(*along))
    rest = Poses.concatenate(poses), np.concatenate(used), *told, np.concatenate(bends), Poses.concatenate(drawn)
    order = np.argsort(list(chain(*(rows for rows, _, _ in groups))))
    return AtRest(list(chain(*judged)), list(chain(*looks)), *rest).of(order.tolist())


def candidates(verdicts: Sequence[Verdict]) -> Poses:
    """Where objects were found."""
    return Poses.concatenate([v.claim.poses for v in verdicts])


def _at_rest_in(frame: ImageFrame, finder: WholeObjectFinder, verdicts: Sequence[Verdict]) -> AtRest:
    hurried, frame = frame, frame.unhurried()
    frames = [hurried] * len(verdicts)
    used = np.concatenate([finder.voter.supported(v.claim.scores) for v in verdicts])
    found = candidates(verdicts)
    poses = finder.rest.at_rest(frame, found, used)
    if finder.at_scale is not None:  # it faces the camera
        (first, _), none = finder.at_scale.fitted(frame, poses, used), [None] * len(poses)
        likelier, along, along_found = likelier_along(finder, hurried, first, used)
        likelier, ends, as_found = likelier_ends(finder, hurried, likelier, used)
        rest = AtRest(verdicts, frames, likelier, used, none, none, ends, along, np.zeros(poses.q.shape), first)
        return _judged_anew(finder, rest, first, _moved(first, likelier).tolist(), as_found, along_found)
    poses = first = _in_reach(finder, frame, found, poses)
    finder.voter.keep(frame, poses)  # each of those that follow compares with these
    poses, used, elsewhere = likelier_rests(finder, hurried, poses, used)
    finder.voter.keep(frame, poses)
    lie, along, along_found = likelier_along(finder, hurried, poses, used)
    lie, laid, as_found = likelier_laid(finder, hurried, lie, used)
    bent, more = likelier_bends(finder, hurried, lie)
    likelier, others = likelier_turns(finder, frame, bent)
    moved = _moved(poses, likelier)
    if len(moved):
        elsewhere = [None if n in moved else other for n, other in enumerate(elsewhere)]  # it was of another pose
        used[moved] = finder.voter.supports(frame, likelier[moved])
    rest = AtRest(verdicts, frames, likelier, used, others, elsewhere, laid, along, more, likelier)
    return _judged_anew(finder, rest, first, _moved(first, likelier).tolist(), as_found, along_found)


def _in_reach(finder: WholeObjectFinder, frame: ImageFrame, found: Poses, rested: Poses) -> Poses:
    """Poses at rest; where these have left the distances that are looked for those found, which are in them."""
    near_m, far_m = range_limits(finder.config, frame.camera)
    depth_m = finder.required.anchors(rested)[:, 2]
    left = (depth_m < near_m) | (depth_m > far_m)
    return Poses.concatenate([rested, found])[np.arange(len(found)) + len(found) * left] if left.any() else rested


def _judged_anew(
    finder: WholeObjectFinder,
    rest: AtRest,
    first: Poses,
    moved: list[int],
    as_found: Sequence[LaidOtherwise | None],
    along_found: Sequence[LaidOtherwise | None],
) -> AtRest:
    """With those that are turned or bent otherwise than they were found as they are judged there, for other components
    may be where these have them; where that is no object any more, as it was found.

    :param first: H poses at rest as they were found. :param moved: rows that are elsewhere. :param as_found: how else
        the former may be laid. :param along_found: the same of joints.
    """
    judge, verdicts, rows = Judge.of(finder.config), list(rest.verdicts), list(range(len(first)))
    others = list(rest.others)
    for n in moved:
        again = judge.verdicts(finder, rest.poses[n : n + 1], verdicts[n].claim.frame.unhurried())[0]
        if judge.reason(again) is None:
            verdicts[n] = again
        else:
            rows[n] += len(first)
            others[n] = None
            if judge.is_but_improbable(again) and as_found[n] is None:  # it may be there, and is told in no other way
                others[n] = _doubted(finder, rest.frames[n].unhurried(), first[n : n + 1], rest.poses[n : n + 1])
    back = [n for n, row in enumerate(rows) if row != n]
    if not back:
        return rest._replace(verdicts=verdicts)
    poses, used, bends = Poses.concatenate([rest.poses, first])[rows], rest.used.copy(), rest.bends.copy()
    for n in back:
        used[n], bends[n] = finder.voter.supports(rest.frames[n].unhurried(), first[n : n + 1])[0], 0.0
    elsewhere = [None if n in back else other for n, other in enumerate(rest.elsewhere)]
    laid, along = (
        [found[n] if n in back else other for n, other in enumerate(told)]
        for found, told in ((as_found, rest.laid), (along_found, rest.along))
    )
    drawn = rest.drawn if finder.facing else poses
    return AtRest(verdicts, rest.frames, poses, used, others, elsewhere, laid, along, bends, drawn)


def _doubted(finder: WholeObjectFinder, frame: ImageFrame, told: Poses, likelier: Poses) -> OtherTurn | None:
    """The pose that an object would have by what tells turns apart, were it probable enough there: its outline may be
    off, or its file. It may be likelier than what is told."""
    if not look_otherwise(finder, told, likelier)[0]:
        return None
    odds = float(turn_odds(finder, frame, told, likelier)[0])
    return other_of(finder, Poses.concatenate([told, likelier]), 0, 1, float(1 / (1 + np.exp(-odds))))


def _moved(poses: Poses, likelier: Poses) -> NDArray[np.int64]:
    """Which are laid, turned or bent otherwise."""
    if likelier is poses:
        return np.zeros(0, np.int64)
    elsewhere = (likelier.q != poses.q).any(axis=1) | (likelier.t != poses.t).any(axis=1)
    return np.flatnonzero(elsewhere | (likelier.R != poses.R).any(axis=(1, 2)))


def _drawn_in(frame: ImageFrame, finder: WholeObjectFinder, verdicts: Sequence[Verdict]) -> Poses:
    used = np.concatenate([finder.voter.supported(v.claim.scores) for v in verdicts])
    return finder.rest.at_rest(frame.unhurried(), candidates(verdicts), used)


def _by_frame(frames: Sequence[ImageFrame]) -> Iterator[tuple[list[int], ImageFrame]]:
    """Rows of those that are looked at in one frame, and the frame."""
    rows = dict[int, list[int]]()
    for row, frame in enumerate(frames):
        rows.setdefault(id(frame), []).append(row)
    return ((mine, frames[mine[0]]) for mine in rows.values())
