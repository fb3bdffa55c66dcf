"""Which way round flat objects lie that look almost the same turned otherwise.

Votes count pixels, and a search keeps the first turn that has many. Both turns are brought to rest alike, and compared
by votes and by how near to their contours the labels' edges lie, as mirrored turns in space are, and by the names that
they show.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .finder import WholeObjectFinder
from .other_turns import turn_odds
from .surface_model import Poses


@dataclass(frozen=True, eq=False)
class Layouts:
    """H poses at rest, and behind them n that lie where they do, turned so that each marker lies on a like one.

    :param of: (n,) of which pose each of these is. :param log_odds: (n,) that it is the true one, names apart.
    :param names: (H + n, N) log-likelihood of the pixels on the components under each identity.
    """

    poses: Poses
    of: NDArray[np.int64]
    log_odds: Array
    names: Array

    @classmethod
    def around(
        cls, finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, shows: Sequence[ImageFrame] = ()
    ) -> Layouts:
        """Those of H poses; of those for which there is no time none but themselves.

        :param shows: of each pose the frame in which its names are read: what others own tells nothing of its name.
            Not given: all of the frame is its own.
        """
        found, odds = [poses], [np.zeros(0)]
        for h in range(len(poses)):
            if not finder.exchanges or frame.deadline.expired:
                break
            one = poses[h : h + 1]
            both = Poses.concatenate([one, finder.exchanges.of(one)])
            both = finder.rest.at_rest(frame, both, finder.voter.supports(frame, both))
            found.append(both[1:])
            odds.append(turn_odds(finder, frame, both[np.zeros(len(both) - 1, int)], both[1:]))
        every = Poses.concatenate(found)
        of = np.repeat(np.arange(len(found) - 1), [len(more) for more in found[1:]])
        whose = np.concatenate([np.arange(len(poses)), of])
        looks = {id(look): look for look in shows or [frame]}
        which = np.array([id(look) for look in shows or [frame] * len(poses)], np.int64)[whose]
        names = np.empty((len(every), len(finder.alternatives.identities)))
        for key, look in looks.items():
            names[which == key] = finder.alternatives.evidence(look, every[np.flatnonzero(which == key)])
        return cls(every, of, np.concatenate(odds), names * finder.config.verdict.identity_independent)

    def evidence(self) -> Array:
        """(H, N) of the poses' identities, whichever way round they lie."""
        told, turned = np.split(self.names, [len(self.names) - len(self.of)])
        out = told.copy()
        np.logaddexp.at(out, self.of, turned + self.log_odds[:, None])
        return out

    def likelier(self, names: Sequence[int | None] = ()) -> tuple[Poses, NDArray[np.int64]]:
        """The H poses, turned where another turn is likelier, and rows of those that are turned.

        :param names: of each its identity: all together may tell it though the pose does not. None: of any.
        """
        h, named = len(self.poses) - len(self.of), np.zeros(len(self.poses))
        whose = np.concatenate([np.arange(h), self.of])
        if self.names.shape[1]:
            named = np.logaddexp.reduce(self.names, axis=1)
            known = [row for row, n in enumerate(whose.tolist()) if names and names[n] is not None]
            named[known] = [self.names[row, names[whose[row]]] for row in known]
        likelihood, rows = named + np.concatenate([np.zeros(h), self.log_odds]), np.arange(h)
        for n in range(h, len(whose)):
            if likelihood[n] > likelihood[rows[whose[n]]]:
                rows[whose[n]] = n
        return self.poses[rows], np.flatnonzero(rows >= h)
