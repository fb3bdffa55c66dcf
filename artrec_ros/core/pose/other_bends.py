"""Which of two bends a joint of a told pose has, and how probable the other one is.

A flat marker on a joint, bent from the camera by as much as towards it, looks almost the same: what `other_turns` says
of whole objects holds of every limb. So does a solid of one class, of which an outline is all there is to see
(tipped_markers.py), and of several in a row each may lean either way. And near the bend at which a marker faces the
camera, where none changes what is seen, no derivative tells how sure a joint is. A slender part, too, may have come to
rest beside its place while all of the object moved towards its own: where labels like it better, that is compared in
the same way.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array, short_way
from ..image.image_frame import ImageFrame
from .across_kernels import bend_across
from .finder import WholeObjectFinder
from .poses import PatchScores, Poses
from .rivals import ANY_DEPTH, WORTH_REST
from .turn_evidence import Evidence, contour_evidence, share_of_votes

_LEAST_BEND = 0.02  # radians: bends nearer to each other are one
_LEAST_LEVER = 0.1  # of a turn across the line of sight: a joint that tips its marker by less does not mirror it


@dataclass(frozen=True, eq=False)
class Bends:
    """N poses, each with one joint bent otherwise.

    :param of: (N,) whose they are. :param joint: (N,). :param apart: (N,) bends nearer to the one that is told are it.
    """

    poses: Poses
    of: NDArray[np.int64]
    joint: NDArray[np.int64]
    apart: Array

    @property
    def q(self) -> Array:
        """(N,) of the joints that are bent."""
        return np.asarray(self.poses.q[np.arange(len(self.of)), self.joint], np.float64)

    def and_(self, others: Bends) -> Bends:
        """These, and then the others."""
        if not len(others.of):
            return self
        poses = Poses.concatenate([self.poses, others.poses])
        rows = zip((self.of, self.joint, self.apart), (others.of, others.joint, others.apart), strict=True)
        return Bends(poses, *(np.append(mine, theirs) for mine, theirs in rows))

    def where(self, which: NDArray[np.bool_]) -> Bends:
        """Some of them. :param which: (N,)."""
        return Bends(self.poses[np.flatnonzero(which)], self.of[which], self.joint[which], self.apart[which])


def likelier_bends(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> tuple[Poses, Array]:
    """H poses at rest on what the image shows, with those joints bent otherwise where that is clearly likelier; and
    (H, J) by how much each joint's variance is greater because it may be so. Late, all stay as they are."""
    more, bends = np.zeros(poses.q.shape), other_bends(finder, frame, poses)
    if not len(bends.of):
        return poses, more
    config = finder.config.verdict
    weights = config.turn_odds if frame.image is None else config.bend_odds_colour
    log_odds = bend_evidence(finder, frame, poses, bends).log_odds(weights)
    bent, told = poses, np.zeros(poses.q.shape)
    if (log_odds > config.least_turn_odds).any():
        bent, told = _bent(finder, poses, bends, log_odds, config.least_turn_odds)
    # below what makes them told, both are as likely
    rival = 1 / (1 + np.exp(np.maximum(told[bends.of, bends.joint] - log_odds, 0.0)))
    rival *= np.abs(_off(finder, bent, bends)) > bends.apart
    found = np.where(told > 0, 1 / (1 + np.exp(told)), 0.0)
    probability = np.concatenate([found, rival[:, None] * _carries(finder)[bends.joint]])
    of = np.append(np.arange(len(poses)), bends.of)
    off = short_way(np.concatenate([poses.q, bends.poses.q]) - bent.q[of], finder.surface.kinematics.endless)
    np.maximum.at(more, of, np.where(probability > config.least_other_turn, probability * off**2, 0.0))
    return bent, more


def _bent(finder: WholeObjectFinder, poses: Poses, bends: Bends, log_odds: Array, least: float) -> tuple[Poses, Array]:
    """Poses as the likeliest bend of each has it, with the joints of its others, and what these carry; and of each
    joint the log odds of the bend that is told of it or of those that carry each other with it, 0: none (H, J).

    Of joints that carry each other the likeliest alone is bent: each was judged with the others as they were, and bent
    as well they would put what hangs on them where nobody has looked. :param least: log odds from which on one is told.
    """
    R, t, q = poses.R.copy(), poses.t.copy(), poses.q.copy()
    carries = _carries(finder)
    along, told = carries | carries.T, np.zeros(q.shape)
    for n in np.argsort(-log_odds, kind="stable").tolist():
        h, joint = bends.of[n], bends.joint[n]
        if log_odds[n] <= least or told[h, joint]:
            continue
        if told[h].any():
            moved = carries[joint]
            q[h, moved] = bends.poses.q[n, moved]
        else:
            R[h], t[h], q[h] = bends.poses.R[n], bends.poses.t[n], bends.poses.q[n]
        told[h, along[joint]] = np.maximum(told[h, along[joint]], log_odds[n])
    return Poses(R, t, q), told


def _carries(finder: WholeObjectFinder) -> NDArray[np.bool_]:
    """(J, J) joints that each one carries, itself among them."""
    kin = finder.surface.kinematics
    return np.asarray(kin.moves[kin.carried].T, bool)


def other_bends(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Bends:
    """Poses with one joint bent so that its marker leans as far from the camera as it leant towards it, or so that
    labels like it better, at rest on what the image shows, with votes enough to be the true ones."""
    if not finder.surface.kinematics.n_joints or frame.deadline.expired:
        return _none(poses)
    frame = frame.unhurried()
    scores = finder.voter.judge(frame, poses, occlusion=True)
    used = finder.voter.supported(scores)
    bends = _across(finder, poses, used).and_(_liked_better(finder, frame, poses, scores))
    if not len(bends.of):
        return bends
    bends = _either_way(finder, with_carried(finder, frame, bends), used)
    least = finder.config.verdict.mirrored_votes * _own_votes(finder, scores[bends.of], bends)
    bends = replace(bends, poses=finder.refit.of(frame, bends.poses, ANY_DEPTH).poses[len(bends.of) :])
    scores = finder.voter.judge(frame, bends.poses, occlusion=True)
    used, rests = (
        finder.voter.supported(scores),
        [finder.rest.settled, finder.rest.on_colours][: 1 + (frame.image is not None)],
    )
    near = _is_near(finder, poses, bends, scores, WORTH_REST * least)
    for rest in rests:
        bends, used, least = bends.where(near), used[near], least[near]
        if not len(bends.of):
            return bends
        bends = replace(bends, poses=rest(frame, bends.poses, used))
        near = _is_near(finder, poses, bends, finder.voter.judge(frame, bends.poses, occlusion=True), least)
    near &= frame.scene.stand(bends.poses.R, bends.poses.t)
    return bends.where(near)


def _is_near(
    finder: WholeObjectFinder, poses: Poses, bends: Bends, scores: PatchScores, least: Array
) -> NDArray[np.bool_]:
    """(N,) whether what the joints carry has votes enough, and they are elsewhere than they were."""
    return np.asarray((_own_votes(finder, scores, bends) > least) & _apart(finder, poses, bends))


def bend_evidence(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, bends: Bends) -> Evidence:
    """For each of N bends, against the pose whose it is. Of what the joint carries alone, or others of the pose's bends
    along with it, so that these compare: the rest is where it was, but for what fits make of it."""
    n, surface, carries = len(bends.of), finder.surface, _carries(finder)
    both = Poses.concatenate([poses[bends.of], bends.poses])
    scores = finder.voter.judge(frame, both, occlusion=True)
    along = (carries | carries.T)[bends.joint[:, None], bends.joint] & (bends.of[:, None] == bends.of)
    moved = (along @ carries[bends.joint]) @ surface.kinematics.moves.T.astype(bool)
    own, other = (_votes_of(finder, scores[part], moved) for part in (slice(n), slice(n, None)))
    differ = moved[:, surface.component[surface.markers]]
    used = finder.voter.supported(scores).reshape(2, n, -1)
    return contour_evidence(finder, frame, both, share_of_votes(other, own), used, differ)


def _across(finder: WholeObjectFinder, poses: Poses, used: NDArray[np.bool_]) -> Bends:
    """Poses with joints bent across the bend at which their markers face the camera. :param used: (H, M)."""
    surface, kin = finder.surface, finder.surface.kinematics
    frames, by = kin.forward(poses.R, poses.t, poses.q), np.full(poses.q.shape, np.nan)
    rows, tipped = surface.across
    shows = used @ surface.of_component[surface.markers] > 0
    beyond = shows @ kin.moves[:, tipped.joint]  # of a limb as of what hangs on it, whatever hides it
    tips = np.where(tipped.ball, beyond, used[:, rows])
    bend_across(tipped, frames.R, frames.t, frames.axis, tips, _LEAST_LEVER, by)
    of, joint = np.nonzero(np.isfinite(by))
    if not len(of):
        return _none(poses)
    q = poses.q[of]
    q[np.arange(len(of)), joint] += by[of, joint]
    bends = Bends(Poses(poses.R[of], poses.t[of], kin.bound(q)), of, joint, np.full(len(of), _LEAST_BEND))
    return bends.where(_apart(finder, poses, bends))


def _liked_better(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, scores: PatchScores) -> Bends:
    """Poses with one joint elsewhere, where that alone brings more votes: while all of an object moved towards its
    place a slender part of little weight may have come to rest anywhere. :param scores: of H poses."""
    votes, bends = finder.voter.total(scores), _none(poses)
    step, unit = finder.config.search.fine_joint_step, finder.surface.kinematics.unit
    for h in range(len(poses)):
        bent = finder.other_joints.of(frame, poses[h : h + 1], float(votes[h]))
        better = bent.poses[np.flatnonzero(bent.votes > votes[h])]
        if len(better):
            joint = np.abs(better.q - poses.q[h]).argmax(axis=1)
            bends = bends.and_(Bends(better, np.full(len(better), h), joint, step * unit[joint]))
    return bends


def _none(poses: Poses) -> Bends:
    return Bends(poses[:0], np.zeros(0, int), np.zeros(0, int), np.zeros(0))


def with_carried(finder: WholeObjectFinder, frame: ImageFrame, bends: Bends) -> Bends:
    """The same with what the joints carry on further joints where the labels like it best; of an object with solids,
    which hide what hangs on them, where that brings more votes: such a search knows nothing of what hides what."""
    poses, surface = bends.poses, finder.surface
    kin, q = surface.kinematics, bends.poses.q.copy()
    further = _carries(finder) & ~np.eye(kin.n_joints, dtype=bool)
    rows = np.flatnonzero(further[bends.joint].any(axis=1))
    if not len(rows):
        return bends
    for n in rows.tolist():
        grids = finder.first_grids.copy()
        stays = ~further[bends.joint[n]]
        grids[stays, 0], grids[stays, 1:] = q[n, stays], np.nan
        q[n] = surface.search_joints(frame, poses[[n]], grids).q[0]
    if surface.solids:
        both = Poses.concatenate([poses[rows], Poses(poses.R[rows], poses.t[rows], q[rows])])
        votes = finder.voter.votes(frame, both, occlusion=True).reshape(2, -1)
        q[rows] = np.where((votes[1] > votes[0])[:, None], q[rows], poses.q[rows])
    return replace(bends, poses=Poses(poses.R, poses.t, q))


def _either_way(finder: WholeObjectFinder, bends: Bends, used: NDArray[np.bool_]) -> Bends:
    """These, and with solids that the joints carry bent across in their turn: of links in a row each may lean either
    way. Flat ones show how they lie.

    :param used: (H, M) markers that labels support.
    """
    carries, deeper = _carries(finder), bends
    used = used & np.isin(finder.surface.component[finder.surface.markers], sorted(finder.surface.solids))
    if not used.any():
        return bends
    for _ in range(int(carries.sum(axis=1).max()) - 1):
        again = _across(finder, deeper.poses, used[deeper.of])
        root = deeper.joint[again.of]
        again = again.where(carries[root, again.joint] & (root != again.joint))
        deeper = Bends(again.poses, deeper.of[again.of], deeper.joint[again.of], deeper.apart[again.of])
        if not len(deeper.of):
            break
        bends = bends.and_(deeper)
    return bends


def _off(finder: WholeObjectFinder, poses: Poses, bends: Bends) -> Array:
    """(N,) how far joints are from where they were."""
    off = short_way(bends.q - poses.q[bends.of, bends.joint], finder.surface.kinematics.endless[bends.joint])
    return np.asarray(off, np.float64)


def _apart(finder: WholeObjectFinder, poses: Poses, bends: Bends) -> NDArray[np.bool_]:
    """(N,) whose joint is elsewhere than it was."""
    return np.asarray(np.abs(_off(finder, poses, bends)) > bends.apart)


def _own_votes(finder: WholeObjectFinder, scores: PatchScores, bends: Bends) -> Array:
    """(N,) votes of what the joints carry. :param scores: of N."""
    return _votes_of(finder, scores, finder.surface.kinematics.moves[:, bends.joint].T)


def _votes_of(finder: WholeObjectFinder, scores: PatchScores, which: NDArray[np.bool_]) -> Array:
    """(N,) votes of components (N, C); one that speaks against itself is hidden. :param scores: of N."""
    votes = np.maximum(scores.votes @ finder.surface.of_component, 0.0)
    return np.asarray(np.where(which, votes, 0.0).sum(axis=1), np.float64)
