"""Where like markers that one joint carries are: moved along it they lie on each other's.

Of three like men on a rod one is hidden: moved on by one place the rod shows the other two as well, if its limits let
it, and nothing in the image tells where on it the hidden one is. Of four like blades one is marked: a quarter turn on
all blades are where they are seen, and the mark alone tells. A search keeps the bend that it found first. So where
something that the joint carries is not seen, the others that lay like markers where those lie that are seen are
compared with it, by what differs.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .exchanges import OFF
from .finder import WholeObjectFinder
from .joint_steps import Steps
from .laid_otherwise import LaidOtherwise, told_likelier
from .poses import Poses
from .turn_evidence import evidence
from .unseen import bare, in_view, log_unseen


class Bent(NamedTuple):
    """How sure it is that an object is bent as it is told.

    :ivar stays: of components that other bends put elsewhere how probable it is that they are where they are told.
    :ivar variance: by how much joints' variances are greater for these, by their names.
    """

    stays: Mapping[str, float]
    variance: Mapping[str, float]


def likelier_along(
    finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_]
) -> tuple[Poses, Sequence[LaidOtherwise | None], Sequence[LaidOtherwise | None]]:
    """As `likelier_laid`, of poses at rest whose joints may be moved on by `JointSteps`.

    :param used: (H, M) markers that the labels support.
    """
    found: list[LaidOtherwise | None] = [None] * len(poses)
    if finder.joint_steps.of:
        found = [_others(finder, frame, poses[h : h + 1], used[h]) for h in range(len(poses))]
    return told_likelier(poses, found)


def doubts_along(finder: WholeObjectFinder, pose: Poses, along: LaidOtherwise | None) -> Bent:
    """What the others cost one that is told."""
    stays, variance, model = dict[str, float](), dict[str, float](), finder.surface.model
    if along is None:
        return Bent(stays, variance)
    shares = along.shares()[1:]
    off = np.array([finder.joint_steps.off(along.poses, pose, j) for j in finder.joint_steps.of])
    mine = np.abs(off / finder.surface.kinematics.unit[list(finder.joint_steps.of), None]).argmax(axis=0)
    for n, j in enumerate(finder.joint_steps.of):
        doubt = shares[mine == n]
        for c in np.flatnonzero(finder.joint_steps.elsewhere(j)).tolist():
            name = model.components[c].name
            stays[name] = stays.get(name, 1.0) * (1 - float(doubt.sum()))
        variance[model.joint_names[j]] = float(doubt @ off[n, mine == n] ** 2)
    return Bent(stays, variance)


def _others(finder: WholeObjectFinder, frame: ImageFrame, pose: Poses, used: NDArray[np.bool_]) -> LaidOtherwise | None:
    """Of one pose at rest those with one joint elsewhere. Likelier ones but a little are as likely."""
    found = list[tuple[Poses, Array]]()
    for j, steps in finder.joint_steps.of.items():
        mine = used[steps.markers]
        if mine.any() and not mine.all() and not frame.deadline.expired:
            # those that lay like markers where all of these are
            rows = np.flatnonzero(steps.taken[:, mine].all(axis=1))
            found.append(_of_one(finder, frame.unhurried(), pose, j, rows))
    if not any(len(others) for others, _ in found):
        return None
    log_odds = np.concatenate([odds for _, odds in found])
    likelier = log_odds > finder.config.verdict.least_turn_odds
    log_odds = np.where(likelier, log_odds, np.minimum(log_odds, 0.0))
    return LaidOtherwise(Poses.concatenate([others for others, _ in found]), log_odds)


def _of_one(
    finder: WholeObjectFinder, frame: ImageFrame, pose: Poses, j: int, rows: NDArray[np.int64]
) -> tuple[Poses, Array]:
    """Poses at rest with one joint moved on by some of its steps, where its markers are borne out as they are as it is
    told; and their log odds."""
    others, rows = finder.joint_steps.others(pose, j, rows)
    if not len(others):
        return others, np.zeros(0)
    steps = finder.joint_steps.of[j]
    others = finder.rest.at_rest(frame, others, finder.voter.supports(frame, others))
    least = finder.config.verdict.mirrored_votes * finder.voter.votes(frame, pose, occlusion=True)[0]
    apart = np.abs(finder.joint_steps.off(others, pose, j)) > OFF * np.abs(steps.by[rows])
    apart &= frame.scene.stand(others.R, others.t)
    kept = np.flatnonzero(apart & (finder.voter.votes(frame, others, occlusion=True) > least))
    others, rows = others[kept], rows[kept]
    return others, _odds(finder, frame, pose, others, steps, rows) if len(others) else np.zeros(0)


def _odds(
    finder: WholeObjectFinder, frame: ImageFrame, pose: Poses, others: Poses, steps: Steps, rows: NDArray[np.int64]
) -> Array:
    """(n,) log odds of others, before anything is known as likely as the pose that is told: by the markers that lie
    where nothing is under the other one, and by what votes and contours of all say."""
    told = pose[np.zeros(len(others), int)]
    both, alone = Poses.concatenate([told, others]), np.concatenate([~steps.taken[rows], ~steps.lies[rows]])
    scores, columns = finder.voter.judge(frame, both, occlusion=True), finder.surface.markers[steps.markers]
    weight, least_px, *rest = finder.config.verdict.differing_odds
    seen_px = np.where(alone, np.maximum(scores.votes[:, columns], 0.0), 0.0).sum(axis=1)
    worth = weight * np.log(seen_px / finder.config.votes.inside[0] + least_px)
    for absent in (in_view(finder, frame, both, scores).lacking, bare(finder, frame, both, scores)):
        worth += log_unseen(finder, absent[:, steps.markers] & alone)
    first, second = worth.reshape(2, -1)
    return second - first + evidence(finder, frame, told, others).log_odds((0.0, *rest))
