"""Which way round flat objects lie that look almost the same turned otherwise.

Votes count pixels, and a search keeps the first turn that has many. At rest on the contours both turns are compared by
votes and by how near the edges lie, as mirrored turns in space are, and by the names that they show.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.special import logsumexp

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .finder import WholeObjectFinder
from .other_turns import turn_odds
from .surface_model import Poses


def exchanged(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> tuple[Poses, NDArray[np.int64], Array]:
    """What lies where H poses at rest do, turned so that each marker lies on a like one, and of which pose each is; and
    log odds that it is the true one, names apart."""
    if finder.exchanges is None or not len(finder.exchanges) or not len(poses):
        return finder.surface.no_poses, np.zeros(0, np.int64), np.zeros(0)
    turned, of = finder.exchanges.of(poses)
    turned = finder.rest.fitted(frame, turned)
    return turned, of, turn_odds(finder, frame, poses[of], turned)


def likelier_layouts(
    finder: WholeObjectFinder,
    frame: ImageFrame,
    poses: Poses,
    used: NDArray[np.bool_],
    names: Sequence[int | None] = (),
) -> tuple[Poses, NDArray[np.bool_]]:
    """H poses at rest on the contours of markers used (H, M), turned where another turn is likelier, and these markers.

    :param names: of each its identity: all together may tell it though the pose does not. None: of any.
    """
    turned, of, log_odds = exchanged(finder, frame, poses)
    if not len(of):
        return poses, used
    both = Poses.concatenate([poses, turned])
    likelihood = np.concatenate([np.zeros(len(poses)), log_odds]) + _named(finder, frame, both, of, names)
    rows = np.arange(len(poses))
    for n, h in enumerate(of.tolist()):
        if likelihood[len(poses) + n] > likelihood[rows[h]]:
            rows[h] = len(poses) + n
    changed = np.flatnonzero(rows >= len(poses))
    if not len(changed):
        return poses, used
    used, poses = used.copy(), both[rows]
    used[changed] = finder.voter.supported(finder.voter.judge(frame, poses[changed], occlusion=True))
    return poses.replaced(changed, finder.rest.at_rest(frame, poses[changed], used[changed])), used


def _named(
    finder: WholeObjectFinder,
    frame: ImageFrame,
    poses: Poses,
    of: NDArray[np.int64],
    names: Sequence[int | None],
) -> Array:
    """(N,) log-likelihood of what poses show of names: of those that objects have, or of any."""
    says = finder.alternatives.evidence(frame, poses) * finder.config.verdict.identity_independent
    if not says.shape[1]:
        return np.zeros(len(poses))
    out = logsumexp(says, axis=1)
    whose = np.concatenate([np.arange(len(poses) - len(of)), of])
    for row, h in enumerate(whose.tolist() if names else ()):
        if (name := names[h]) is not None:
            out[row] = says[row, name]
    return np.asarray(out)
