"""Hypotheses of a spatial object, batched."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array, numbers_of, rows_of


@dataclass(frozen=True)
class Poses:
    """H hypotheses: the object's pose in the camera R (H, 3, 3), t (H, 3), and its joints q (H, J)."""

    R: Array
    t: Array
    q: Array

    def __len__(self) -> int:
        return len(self.R)

    def __getitem__(self, index: NDArray | list[int] | slice) -> Poses:
        if isinstance(index, slice):
            return Poses(self.R[index], self.t[index], self.q[index])
        rows = numbers_of(index)
        return Poses(self.R.take(rows, 0), self.t.take(rows, 0), self.q.take(rows, 0))

    @property
    def key(self) -> bytes:
        """The same of the same hypotheses."""
        return b"".join(values.tobytes() for values in (self.R, self.t, self.q))

    @classmethod
    def concatenate(cls, parts: list[Poses]) -> Poses:
        """The rows of one part or more, in order."""
        R, t, q = [p.R for p in parts], [p.t for p in parts], [p.q for p in parts]
        return cls(np.concatenate(R), np.concatenate(t), np.concatenate(q))


@dataclass(frozen=True)
class PatchScores:
    """Per hypothesis and patch (H, P): summed votes, pixels seen, and the share of them with the patch's label."""

    votes: Array
    area_px: Array
    agree: Array

    @property
    def arrays(self) -> tuple[Array, Array, Array]:
        return self.votes, self.area_px, self.agree

    def __getitem__(self, index: NDArray | list[int] | slice) -> PatchScores:
        return PatchScores(*rows_of(index, *self.arrays))
