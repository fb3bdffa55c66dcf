"""Which of two mirrored bends a joint of a told pose has, and how probable the other one is.

A flat marker on a joint, bent from the camera by as much as towards it, looks almost the same: what `other_turns` says
of whole objects holds of every limb. And near the bend at which its marker faces the camera, where none changes what is
seen, no derivative tells how sure a joint is.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array, short_way
from ..image.image_frame import ImageFrame
from .finder import WholeObjectFinder
from .other_turns import ANY_DEPTH, WORTH_REST, Evidence, contour_evidence, share_of_votes
from .surface_model import PatchScores, Poses

_LEAST_BEND = 0.02  # radians: bends nearer to each other are one
_LEAST_LEVER = 0.1  # of a turn across the line of sight: a joint that tips its marker by less does not mirror it


@dataclass(frozen=True, eq=False)
class Bends:
    """N poses, each with one joint bent the other way.

    :param of: (N,) whose they are. :param joint: (N,).
    """

    poses: Poses
    of: NDArray[np.int64]
    joint: NDArray[np.int64]

    @property
    def q(self) -> Array:
        """(N,) of the joints that are bent."""
        return np.asarray(self.poses.q[np.arange(len(self.of)), self.joint], np.float64)

    def where(self, which: NDArray[np.bool_]) -> Bends:
        """Some of them. :param which: (N,)."""
        return Bends(self.poses[np.flatnonzero(which)], self.of[which], self.joint[which])


def likelier_bends(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> tuple[Poses, Array]:
    """H poses at rest on what the image shows, with those joints bent the other way where that is clearly likelier; and
    (H, J) by how much each joint's variance is greater because it may be so."""
    told, more = Poses(poses.R.copy(), poses.t.copy(), poses.q.copy()), np.zeros(poses.q.shape)
    bends = mirrored_bends(finder, frame, poses)
    if not len(bends.of):
        return poses, more
    bent, config = bends.poses, finder.config.verdict
    if frame.image is not None:
        bent = finder.on_colours(frame, bent, finder.supported(finder.judge(frame, bent, occlusion=True)))
    weights = config.turn_odds if frame.image is None else config.turn_odds_colour
    log_odds = bend_evidence(finder, frame, poses, replace(bends, poses=bent)).log_odds(weights)
    probability = 1 / (1 + np.exp(np.abs(log_odds)))
    turned = log_odds > config.least_turn_odds
    probability[(log_odds > 0) & ~turned] = 0.5
    apart = short_way(bends.q - poses.q[bends.of, bends.joint], finder.surface.kinematics.endless[bends.joint])
    more[bends.of, bends.joint] = np.where(probability > config.least_other_turn, probability * apart**2, 0.0)
    for n in np.flatnonzero(turned)[np.argsort(log_odds[turned], kind="stable")].tolist():
        row, joint = int(bends.of[n]), int(bends.joint[n])  # of several the likeliest one says where the object is
        told.R[row], told.t[row], told.q[row, joint] = bent.R[n], bent.t[n], bent.q[n, joint]
    return told, more


def mirrored_bends(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Bends:
    """Poses with one joint bent so that its marker leans as far from the camera as it leant towards it, at rest on the
    labels, with votes enough to be the true ones."""
    scores = finder.judge(frame, poses, occlusion=True)
    bends = _across(finder, poses, finder.supported(scores))
    if not len(bends.of):
        return bends
    told, least = finder.votes(frame, poses, occlusion=True), finder.config.verdict.mirrored_votes
    first = finder.refit.of(frame, bends.poses, ANY_DEPTH)[len(bends.of) :]
    bends = replace(bends, poses=first.poses)
    near = _share(finder, scores, told, bends, first.votes) > WORTH_REST * least
    if not near.any():
        return bends.where(near)
    bends = bends.where(near & _apart(finder, poses, bends))
    used = finder.supported(finder.judge(frame, bends.poses, occlusion=True))
    bends = replace(bends, poses=finder.settled(frame, bends.poses, used))
    near = _share(finder, scores, told, bends, finder.votes(frame, bends.poses, occlusion=True)) > least
    return bends.where(near & _apart(finder, poses, bends))


def bend_evidence(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, bends: Bends) -> Evidence:
    """For each of N bends, against the pose whose it is."""
    n, surface = len(bends.of), finder.surface
    both = Poses.concatenate([poses[bends.of], bends.poses])
    scores = finder.judge(frame, both, occlusion=True)
    total, used = finder.total(scores).reshape(2, n), finder.supported(scores).reshape(2, n, -1)
    moved = surface.kinematics.moves[:, bends.joint].T  # (N, C)
    own = np.where(moved[:, surface.component], scores.votes[:n], 0.0).sum(axis=1)
    differ = moved[:, surface.component[surface.markers]]
    return contour_evidence(finder, frame, both, share_of_votes(own + total[1] - total[0], own), used, differ)


def _across(finder: WholeObjectFinder, poses: Poses, used: NDArray[np.bool_]) -> Bends:
    """Poses with joints bent across the bend at which their markers face the camera. :param used: (H, M)."""
    surface, kin = finder.surface, finder.surface.kinematics
    frames, by = kin.forward(poses.R, poses.t, poses.q), np.full(poses.q.shape, np.nan)
    for m, patch in enumerate(surface.markers.tolist()):
        c = int(surface.component[patch])
        j = kin.joint_of[c]
        if j < 0 or not kin.revolute[j]:
            continue
        normal, axis = frames.R[:, c] @ surface.normal[patch], frames.axis[:, j]
        middle = frames.R[:, c] @ surface.centre[patch] + frames.t[:, c]
        sight = -middle / np.maximum(np.linalg.norm(middle, axis=1, keepdims=True), 1e-12)
        facing = _dots(normal, sight)
        along, across = facing - _dots(normal, axis) * _dots(sight, axis), _dots(np.cross(axis, normal), sight)
        tips = used[:, m] & (facing > 0) & (np.hypot(along, across) > _LEAST_LEVER)
        by[:, j] = np.where(tips, 2 * np.arctan2(across, along), by[:, j])
    of, joint = np.nonzero(np.isfinite(by))
    q = poses.q[of]
    q[np.arange(len(of)), joint] += by[of, joint]
    bends = Bends(Poses(poses.R[of], poses.t[of], kin.bound(q)), of, joint)
    return bends.where(_apart(finder, poses, bends))


def _apart(finder: WholeObjectFinder, poses: Poses, bends: Bends) -> NDArray[np.bool_]:
    """(N,) whose joint is elsewhere than it was."""
    off = short_way(bends.q - poses.q[bends.of, bends.joint], finder.surface.kinematics.endless[bends.joint])
    return np.asarray(np.abs(off) > _LEAST_BEND)


def _share(finder: WholeObjectFinder, scores: PatchScores, told: Array, bends: Bends, votes: Array) -> Array:
    """(N,) of the votes of what the joint carries that are left when it is bent.

    :param scores, told: of H poses, and their votes. :param votes: (N,) of the bends.
    """
    carried = finder.surface.kinematics.moves[:, bends.joint].T[:, finder.surface.component]
    own = np.where(carried, scores.votes[bends.of], 0.0).sum(axis=1)
    return share_of_votes(own + votes - told[bends.of], own)


def _dots(a: Array, b: Array) -> Array:
    return np.asarray((a * b).sum(axis=1), np.float64)
