"""Which other sides of a rigid object may be seen under a pose that is told, and where it would be then."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .distinct import best_distinct
from .finder import WholeObjectFinder
from .like_sides import Others
from .poses import Poses
from .through_middles import Middles

_MOST = 3  # of a pose that come to rest
_MOST_LAID = 2  # of the ways to lay what is seen on other markers, those that are nearest as they are


def other_sides(
    finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, least: Array
) -> tuple[Poses, NDArray[np.int64]]:
    """The few with most votes of each of H poses, each side slanted as is likelier; and whose each one is.

    :param least: (H,) votes that one must have.
    """
    kept, whose = [finder.surface.no_poses], list[int]()
    supported = finder.voter.supports(frame, poses)
    for h in range(len(poses)):
        others = _standing(finder, frame, poses[h : h + 1])
        laid, side = _laid_on_seen(finder, frame, poses[h : h + 1], others, supported[h])
        found = finder.ranked(frame, Poses.concatenate([others.poses, laid]))
        side = np.append(others.side, side)
        order = np.argsort(-found.votes, kind="stable")
        order = order[np.sort(np.unique(side[order], return_index=True)[1])]
        order = order[found.votes[order] > least[h]]
        best = order[best_distinct(found.poses[order], found.votes[order], _MOST, finder.config.search)]
        kept.append(found.poses[best])
        whose += [h] * len(best)
    return Poses.concatenate(kept), np.array(whose, np.int64)


def _laid_on_seen(
    finder: WholeObjectFinder, frame: ImageFrame, pose: Poses, others: Others, used: NDArray[np.bool_]
) -> tuple[Poses, NDArray[np.int64]]:
    """Other sides through the middles of all that is seen of one pose, where more than one side is, and which each
    shows: of those that are alike each lies otherwise beside the next. :param used: (M,) markers that are seen of it.
    """
    through, camera, sides = finder.through_middles, frame.camera, finder.like_sides
    at = through.places(pose, finder.surface.markers)[0]
    pixels, scale = project(camera, at), camera.focal_px / at[:, 2]
    nearest = dict[frozenset[tuple[int, int]], tuple[float, int]]()
    for n, k in enumerate(others.side.tolist()):
        there, here = sides.pairs(k, used)
        if len(there) > sides.covered(k, used):
            new = through.places(others.poses[n : n + 1], finder.surface.markers[there])[0]
            off = float(np.linalg.norm(project(camera, new) - pixels[here], axis=1).max())
            same = frozenset(zip(there, here, strict=True))
            nearest[same] = min(nearest.get(same, (np.inf, n)), (off, n))
    found, shown = [finder.surface.no_poses], list[int]()
    for _, n in sorted(nearest.values())[:_MOST_LAID]:
        there, here = sides.pairs(int(others.side[n]), used)
        middles = Middles(finder.surface.markers[there], pixels[here], scale[here])
        found.append(through.begun(camera, others.poses[n : n + 1], middles))
        shown += [int(others.side[n])] * len(found[-1])
    return Poses.concatenate(found), np.array(shown, np.int64)


def _standing(finder: WholeObjectFinder, frame: ImageFrame, pose: Poses) -> Others:
    """Those that stand on the scene's floor, about."""
    others = finder.like_sides.of(pose)
    slack = finder.config.guesses.standing_slack
    stand = np.flatnonzero(frame.scene.may_stand(others.poses.R, others.poses.t, slack))
    return Others(others.poses[stand], others.of[stand], others.side[stand])
