"""Which blobs that no told object explains a component of an object may have made, by its reach, class and size."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import compress
from statistics import median
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.camera import Camera
from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.blobs import Blob, centres
from ..image.image_frame import ImageFrame
from ..pose.finder import WholeObjectFinder
from ..pose.surface_kernels import LEAST_DEPTH_M
from .claims import unexplained
from .verdicts import Verdict


class Sizes(NamedTuple):
    """Of B blobs: their middles (B, 2), classes (B,), and pixels (B,)."""

    middles: Array
    label: NDArray[np.int64]
    area_px: Array

    @classmethod
    def of(cls, blobs: Sequence[Blob]) -> Sizes:
        return cls(centres(blobs), np.array([b.label for b in blobs]), np.array([b.area_px for b in blobs]))


class FreeBlobs:
    """Those of one target's objects. :ivar of, middle, area: of the M markers, their components, middles and areas."""

    def __init__(self, finder: WholeObjectFinder) -> None:
        self._finder, self._config, surface = finder, finder.config, finder.surface
        self.of = surface.component[surface.markers]
        self.middle, self.area = (values[surface.markers] for values in surface.sides.blobs)

    def unexplained(
        self, frame: ImageFrame, blobs: Sequence[Blob], asked: NDArray[np.bool_], among: Sequence[Verdict]
    ) -> NDArray[np.bool_]:
        """(B,) which blobs, of those that are asked for, told objects own less of than would have them done with."""
        free = np.zeros(len(blobs), bool)
        if asked.any():
            looked = list(compress(blobs, asked))
            # what lies beside all of these takes nothing of them
            boxes = np.array([b.box for b in looked])
            low, high = boxes[:, 0].min(axis=0), boxes[:, 1].max(axis=0)
            left = frame.without([hull for v in among for hull in v.claim.solids.within(low - 1, high + 1)])
            free[asked] = unexplained(left, looked, self._config.search.explained)
        return free

    def near(
        self, missing: Sequence[int], seen: Sequence[int], at: Array, camera: Camera, blobs: Sizes
    ) -> dict[int, Array]:
        """By component (B,) how far each blob that it may have made is from where the pose has it, pixels; inf: none.

        :param at: (M, 3) the middles of all markers.
        """
        pixels, scale = project(camera, at), camera.focal_px / np.maximum(at[:, 2], LEAST_DEPTH_M)
        (middles, label, area_px), out = blobs, dict[int, Array]()
        shown = np.flatnonzero((self.of[:, None] == seen).any(axis=1))
        off, usual = np.linalg.norm(middles[:, None] - pixels[shown], axis=2), median(scale[shown].tolist())
        for c in missing:
            mine = np.flatnonzero(self.of == c)
            alike = self.as_large(area_px, self.area[mine] * usual**2)
            if alike.any():
                alike &= (label[:, None] == self._finder.surface.labels[c]).any(axis=1)
            if not alike.any():
                continue
            own_scale = np.sqrt(area_px / self.area[mine].max())  # a pose that is wrong may have another one
            within_px = self._finder.apart.within_px(c, shown, np.maximum(scale[shown], own_scale[:, None]))
            near = alike & (off <= within_px).all(axis=1)
            if near.any():
                out[c] = np.where(near, np.linalg.norm(middles - pixels[mine[0]], axis=1), np.inf)
        return out

    def as_large(self, area_px: Array, size_px: Array) -> NDArray[np.bool_]:
        """(B,) which blobs are about as large as one of a component's markers (m,)."""
        ratio = self._config.verdict.left_over_ratio
        share = area_px[:, None] / np.maximum(size_px, 1e-9)
        return np.asarray(((share <= ratio) & (share >= 1 / ratio)).any(axis=1))
