"""Hypotheses of one object with their votes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..base.config import SearchConfig
from ..geometry.transforms import Array, rows_of
from .distinct import best_distinct
from .poses import Poses


@dataclass(frozen=True)
class Ranked:
    """H hypotheses and their votes (H,)."""

    poses: Poses
    votes: Array

    def __len__(self) -> int:
        return len(self.poses)

    def __getitem__(self, index: NDArray | list[int] | slice) -> Ranked:
        return Ranked(self.poses[index], *rows_of(index, self.votes))

    def __add__(self, other: Ranked) -> Ranked:
        return Ranked(Poses.concatenate([self.poses, other.poses]), np.concatenate([self.votes, other.votes]))

    def best(self, n: int, config: SearchConfig) -> Ranked:
        """The best `n` that differ from each other, best first."""
        return self[best_distinct(self.poses, self.votes, n, config)]

    def copied(self) -> Ranked:
        """The same in arrays of its own, to be moved in place."""
        poses = self.poses
        return Ranked(Poses(poses.R.copy(), poses.t.copy(), poses.q.copy()), self.votes.copy())

    @property
    def arrays(self) -> tuple[Array, Array, Array, Array]:
        """R, t, q and votes, as compiled code takes them."""
        return self.poses.R, self.poses.t, self.poses.q, self.votes


def first_of_each(group: NDArray[np.int64], votes: Array, most: int | NDArray[np.int64]) -> NDArray[np.int64]:
    """Indices of the best of each group of hypotheses, by group and then best first.

    :param group: (H,) which group each is of. :param most: of each group; of all the same, or (groups,).
    """
    rows = np.lexsort((-votes, group))
    rank = np.arange(len(rows)) - np.searchsorted(group[rows], group[rows])
    return np.asarray(rows[rank < (most if isinstance(most, int) else most[group[rows]])])
