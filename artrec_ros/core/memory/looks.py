"""Blobs that were searched in full, and which of them a blob of a later frame still is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from ..base.config import RecallConfig
from ..geometry.transforms import Array
from ..image.blobs import Blob


@dataclass(frozen=True, eq=False)
class Looks:
    """n blobs, each as it was when it was searched, and where it was last.

    :param label: (n,). :param box: (n, 4) where it was last: middle and size of its bounding box, pixels.
    :param least: (n, 3) width, height and pixels enclosed, the least of each since it was searched.
    :param at_s: (n,) when that was. :param wait_s: (n,) how long after that it is searched again.
    """

    label: Array
    box: Array
    least: Array
    at_s: Array
    wait_s: Array

    def __len__(self) -> int:
        return len(self.label)

    def __getitem__(self, index: NDArray) -> Looks:
        return Looks(self.label[index], self.box[index], self.least[index], self.at_s[index], self.wait_s[index])

    @classmethod
    def of(cls, blobs: Sequence[Blob], at_s: float) -> Looks:
        """Blobs as they are now."""
        rects = np.array([cv2.boundingRect(b.pixels) for b in blobs], float).reshape(-1, 4)
        box = np.column_stack([rects[:, :2] + rects[:, 2:] / 2, rects[:, 2:]])
        least = np.column_stack([rects[:, 2:], [b.area_px for b in blobs]])
        label, at_s_each = np.array([b.label for b in blobs], int), np.full(len(blobs), at_s)
        return cls(label, box, least, at_s_each, np.zeros(len(blobs)))

    @classmethod
    def joined(cls, parts: Sequence[Looks]) -> Looks:
        return cls(
            *(np.concatenate([getattr(p, n) for p in parts]) for n in ("label", "box", "least", "at_s", "wait_s"))
        )

    def moved_to(self, now: Looks) -> Looks:
        """The same blobs where they are now."""
        return Looks(self.label, now.box, np.minimum(self.least, now.least), self.at_s, self.wait_s)

    def waiting(self, wait_s: Array) -> Looks:
        """The same with other times to wait."""
        return replace(self, wait_s=wait_s)

    def same(self, now: Looks, config: RecallConfig) -> np.ndarray:
        """(N,) of each blob of now the one of these that it still is, -1: none; no two are the same."""
        if not len(self) or not len(now):
            return np.full(len(now), -1)
        off = np.abs(now.box[:, None, :2] - self.box[None, :, :2])
        near = (off <= config.moved_px + config.moved_share * self.box[:, 2:]).all(axis=2)
        distance = np.where((now.label[:, None] == self.label) & near, off.max(axis=2), np.inf)
        nearest, mine = distance.argmin(axis=1), distance.argmin(axis=0)
        rows = np.arange(len(now))
        mutual = (mine[nearest] == rows) & np.isfinite(distance[rows, nearest])
        return np.where(mutual, nearest, -1)

    def grown(self, now: Looks, config: RecallConfig) -> NDArray[np.bool_]:
        """(n,) which of these show more now than when they were searched. What shrinks, or is cut otherwise by what
        hides it, does not.

        :param now: the same blobs as they are now.
        """
        slack = config.grown_px, config.grown_px, config.grown_px**2
        return np.asarray((now.least > (1 + config.grown_share) * self.least + slack).any(axis=1))


NO_LOOKS = Looks(np.zeros(0, int), np.zeros((0, 4)), np.zeros((0, 3)), np.zeros(0), np.zeros(0))
