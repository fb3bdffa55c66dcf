"""Which way round flat objects lie that look almost the same turned otherwise.

Votes count pixels, and a search keeps the first turn that has many. Both turns are brought to rest alike, and compared
by votes and by how near to their contours the labels' edges lie, as mirrored turns in space are, and by the names that
they show.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .finder import WholeObjectFinder
from .other_turns import turn_odds
from .surface_model import Poses


def exchanged(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> tuple[Poses, NDArray[np.int64], Array]:
    """What lies where H poses at rest do, turned so that each marker lies on a like one, and of which pose each is; and
    log odds that it is the true one, names apart. None of those for which there is no time."""
    found, of, odds = [finder.surface.no_poses], [np.zeros(0, np.int64)], [np.zeros(0)]
    exchanges = finder.exchanges
    for h in range(len(poses)):
        if not exchanges or frame.deadline.expired:
            break
        one = poses[h : h + 1]
        turned, _ = exchanges.of(one)
        both = Poses.concatenate([one, turned])
        both = finder.rest.at_rest(frame, both, finder.voter.supported(finder.voter.judge(frame, both, occlusion=True)))
        found.append(both[1:])
        of.append(np.full(len(turned), h))
        odds.append(turn_odds(finder, frame, both[np.zeros(len(turned), int)], both[1:]))
    return Poses.concatenate(found), np.concatenate(of), np.concatenate(odds)


def likelier_layouts(
    finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, names: Sequence[int | None] = ()
) -> tuple[Poses, NDArray[np.int64]]:
    """H poses at rest, turned where another turn is likelier, and rows of those that are turned.

    :param names: of each its identity: all together may tell it though the pose does not. None: of any.
    """
    turned, of, log_odds = exchanged(finder, frame, poses)
    both = Poses.concatenate([poses, turned])
    likelihood = np.concatenate([np.zeros(len(poses)), log_odds]) + _named(finder, frame, both, of, names)
    rows = np.arange(len(poses))
    for n, h in enumerate(of.tolist()):
        if likelihood[len(poses) + n] > likelihood[rows[h]]:
            rows[h] = len(poses) + n
    return both[rows], np.flatnonzero(rows >= len(poses))


def _named(
    finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, of: NDArray[np.int64], names: Sequence[int | None]
) -> Array:
    """(N,) log-likelihood of what poses show of names: of those that objects have, or of any."""
    says = finder.alternatives.evidence(frame, poses) * finder.config.verdict.identity_independent
    if not says.shape[1]:
        return np.zeros(len(poses))
    out = np.logaddexp.reduce(says, axis=1)
    whose = np.concatenate([np.arange(len(poses) - len(of)), of])
    for row, h in enumerate(whose.tolist() if names else ()):
        if (name := names[h]) is not None:
            out[row] = says[row, name]
    return np.asarray(out)
