"""The required component turned about the one joint by which all else that is seen of its object hangs on it.

A turret on a base, an arm on its foot: how the base is turned its own outline alone tells. Where something unknown
covers half of that, or it is seen from one side, what is left of it may be taken for another side, or for one that is
more slanted; all that the joint carries stays where it is, for the joint gives way by as much. So the base is turned
about that joint through its range, the rest held where it is, and what comes to rest is compared as mirrored turns are.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..model.kinematics import Kinematics
from .finder import WholeObjectFinder
from .poses import Poses
from .rivals import rivals_at_rest
from .turn_evidence import evidence


def turned_alone(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> tuple[Poses, NDArray[np.int64]]:
    """Such turns of H poses, at rest, that may be the true ones, and whose each is."""
    turned, of, surface, kin = [poses[:0]], list[int](), finder.surface, finder.surface.kinematics
    supported, step = finder.voter.supports(frame, poses), finder.config.search.first_joint_step
    for h in range(len(poses)):
        seen = np.unique(surface.component[surface.markers[supported[h]]])
        others = seen[(kin.moves[seen] != kin.moves[finder.root]).any(axis=1)]
        for j in _between(kin, finder.root, others):
            about = _about(kin, poses[h : h + 1], j, int(others[0]), step)
            turned.append(about)
            of += [h] * len(about)
    begun, whose = Poses.concatenate(turned), np.array(of, np.int64)
    told = finder.voter.votes(frame, poses, occlusion=True) if len(begun) else np.zeros(len(poses))
    return rivals_at_rest(finder, frame, poses, told, begun, whose, elsewhere=True)


def alone_odds(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, turned: Poses) -> Array:
    """(H,) log odds that such a turn is the true one, for each of H poses at rest. A search finds the pose with most
    votes of all these; so a turn with less is seldom right, however few more contours tell."""
    config, in_colour = finder.config.verdict, finder.rest.tells_colour_edges(frame)
    found = evidence(finder, frame, poses, turned)
    return found.log_odds(config.alone_odds_colour if in_colour else config.alone_odds)


def _between(kin: Kinematics, root: int, others: NDArray[np.int64]) -> list[int]:
    """Joints that turn, and part the required component from all others that are seen."""
    if not len(others):
        return []
    return np.flatnonzero(kin.revolute & (kin.moves[others] != kin.moves[root]).all(axis=0)).tolist()


def _about(kin: Kinematics, pose: Poses, j: int, held: int, step: float) -> Poses:
    """A pose with joint `j` elsewhere in its range, and component `held` where it is. :param step: see `grids`."""
    values = kin.grid(j, step)
    values = values[np.abs(values - pose.q[0, j]) > step * kin.unit[j]]
    q = np.repeat(pose.q, len(values), axis=0)
    q[:, j] = values
    was, now = kin.in_object(pose.q), kin.in_object(q)
    R = pose.R[0] @ was.R[0, held] @ now.R[:, held].swapaxes(1, 2)
    at = pose.R[0] @ was.t[0, held] + pose.t[0]
    return Poses(R, at - np.einsum("hij,hj->hi", R, now.t[:, held]), q)
