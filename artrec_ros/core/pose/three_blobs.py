"""Poses by the middles of three blobs: of an object whose markers lie far apart beside their size.

How a small marker looks tells its slant by a few degrees at best, and a disc's not at all: where the next marker lies
ten widths away, that is a width or more, and no search along its joints meets it. Three middles tell a rigid object's
pose to a fraction of a degree (the P3P problem; Ke and Roumeliotis, 2017), and how large the blobs are whether they can
be its markers.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, product

import cv2
import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.camera import Camera
from ..geometry.projection import normalise
from ..geometry.transforms import Array, rotation_from_rotvec
from ..image.blobs import Blob, centres
from ..image.image_frame import ImageFrame
from .surface_kernels import LEAST_DEPTH_M
from .surface_model import Poses, SpatialModel

_Triple = tuple[int, int, int]


class ThreeBlobs:
    """Of one object in space.

    :ivar labels: classes of the markers by which it may be found so; none, where no three are rigid to each other.
    """

    def __init__(self, surface: SpatialModel, config: RecognizerConfig) -> None:
        self._surface, self._config, self._kin = surface, config.middles, surface.kinematics
        self._ratio = config.verdict.left_over_ratio
        frames, of = self._kin.in_object(self._kin.middle[None]), surface.component[surface.markers]
        markers = surface.markers.tolist()
        local = np.array([surface.patches[p].drawn[0] for p in markers])
        normal = np.array([surface.patches[p].normal for p in markers])
        self._at = dict(zip(markers, (frames.R[0, of] @ local[..., None])[..., 0] + frames.t[0, of], strict=True))
        self._normal = dict(zip(markers, (frames.R[0, of] @ normal[..., None])[..., 0], strict=True))
        self._triples = self._widest(markers)
        self.labels = {label for triple in self._triples for p in triple for label in self._labels(p)}

    def of(self, frame: ImageFrame, blobs: Sequence[Blob], asked: NDArray[np.bool_]) -> Poses:
        """Those that three of some blobs allow, the one first whose markers look most as large as these, as far as
        there is time; joints half way between their limits.

        :param asked: (n,) blobs of which one is among the three at least.
        """
        camera, middles, area_px = frame.camera, centres(blobs), np.array([b.area_px for b in blobs])
        rays, parts = normalise(camera, middles), [(np.zeros(0), np.zeros((0, 3, 3)), np.zeros((0, 3)))]
        for triple in self._triples:
            if frame.deadline.expired:
                break
            threes = self._alike(triple, blobs, middles, area_px, asked)
            parts.append(self._solved(camera, triple, rays[threes], area_px[threes]))
        off, R, t = (np.concatenate(kind) for kind in zip(*parts, strict=True))
        kept = np.argsort(off, kind="stable")[: self._config.triples_kept]
        return Poses(R[kept], t[kept], np.tile(self._kin.middle, (len(kept), 1)))

    def _solved(self, camera: Camera, triple: _Triple, rays: Array, area_px: Array) -> tuple[Array, Array, Array]:
        """By how much markers differ from blobs in size (k,), R (k, 3, 3) and t (k, 3) of poses under which they may be
        some of n threes.

        :param rays: (n, 3, 2) normalised. :param area_px: (n, 3)
        """
        at, normal = (np.array([of[p] for p in triple]) for of in (self._at, self._normal))
        turns, places, of = list[Array](), list[Array](), list[int]()
        for n, three in enumerate(rays):
            count, turn, place = cv2.solveP3P(at, three, np.eye(3), None, flags=cv2.SOLVEPNP_AP3P)
            turns, places, of = [*turns, *turn], [*places, *place], of + [n] * count
        t = np.array(places, float).reshape(-1, 3)
        R = rotation_from_rotvec(np.array(turns, float).reshape(-1, 3))
        there = at @ R.swapaxes(1, 2) + t[:, None]
        depth = np.maximum(there[..., 2], LEAST_DEPTH_M)
        cosine = -((normal @ R.swapaxes(1, 2)) * there).sum(axis=2) / np.linalg.norm(there, axis=2)
        looks_px = self._surface.area[list(triple)] * np.maximum(cosine, 1e-9) * (camera.focal_px / depth) ** 2
        off = np.abs(np.log(looks_px / area_px[of]))
        may_be = (there[..., 2] > LEAST_DEPTH_M) & (off < np.log(self._ratio))  # and none is turned away
        kept = np.flatnonzero(may_be.all(axis=1))
        return off[kept].sum(axis=1), R[kept], t[kept]

    def _alike(
        self, triple: _Triple, blobs: Sequence[Blob], middles: Array, area_px: Array, asked: NDArray[np.bool_]
    ) -> NDArray[np.int64]:
        """(n, 3) which blobs may be these markers, no farther apart than these look: the few first that are most alike
        in scale. :param middles, area_px: of the blobs. :param asked: as of `of`."""
        labels = np.array([b.label for b in blobs])
        by_size = np.argsort(-area_px, kind="stable")
        made = [by_size[np.isin(labels[by_size], self._labels(p))][: self._config.triples_blobs] for p in triple]
        threes = np.array(list(product(*made)), np.int64).reshape(-1, 3)
        threes = threes[(threes != np.roll(threes, 1, axis=1)).all(axis=1) & asked[threes].any(axis=1)]
        scale = np.sqrt(area_px[threes] / self._surface.area[list(triple)])  # pixels per metre, less where slanted
        apart_px = np.linalg.norm(middles[threes] - middles[np.roll(threes, 1, axis=1)], axis=2)
        at = np.array([self._at[p] for p in triple])
        apart_m = np.linalg.norm(at - np.roll(at, 1, axis=0), axis=1)
        near = (apart_px <= self._ratio**0.5 * scale.max(axis=1, keepdims=True) * apart_m).all(axis=1)
        threes, unlike = threes[near], np.ptp(np.log(scale[near]), axis=1)
        return threes[np.argsort(unlike, kind="stable")[: self._config.triples_tried]]

    def _labels(self, patch: int) -> tuple[int, ...]:
        return self._surface.labels[self._surface.component[patch]]

    def _widest(self, markers: Sequence[int]) -> list[_Triple]:
        """Those few threes of markers that are rigid to each other and seen from one side that span most."""
        moves, at, normal = self._kin.moves, np.array(list(self._at.values())), np.array(list(self._normal.values()))
        moved = moves[self._surface.component[list(markers)]]
        together = (moved[:, None] == moved).all(axis=2) & (normal @ normal.T > 0)
        threes = np.array(list(combinations(range(len(markers)), 3)), np.int64).reshape(-1, 3)
        threes = threes[together[threes, np.roll(threes, 1, axis=1)].all(axis=1)]
        sides = at[threes[:, 1:]] - at[threes[:, :1]]
        spans = np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1)
        widest = np.argsort(-spans, kind="stable")[: self._config.triples]
        a, b, c = np.array(markers, np.int64)[threes[widest[spans[widest] > 0]]].T
        return list(zip(a.tolist(), b.tolist(), c.tolist(), strict=True))
