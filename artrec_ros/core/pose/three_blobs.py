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
from ..geometry.transforms import Array
from ..image.blobs import Blob, centres
from .surface_model import Poses, SpatialModel

_Triple = tuple[int, int, int]
_LEAST_DEPTH_M = 1e-3


class ThreeBlobs:
    """Of one object in space.

    :ivar labels: classes of the markers by which it may be found so; none, where no three are rigid to each other.
    """

    def __init__(self, surface: SpatialModel, config: RecognizerConfig) -> None:
        self._surface, self._config, self._kin = surface, config.middles, surface.kinematics
        self._ratio = config.verdict.left_over_ratio
        frames, q = self._kin.in_object(self._kin.middle[None]), surface.component
        markers = surface.markers.tolist()
        local = np.array([surface.patches[p].drawn[0] for p in markers])
        normal = np.array([surface.patches[p].normal for p in markers])
        of = q[surface.markers]
        self._at = dict(zip(markers, (frames.R[0, of] @ local[..., None])[..., 0] + frames.t[0, of], strict=True))
        self._normal = dict(zip(markers, (frames.R[0, of] @ normal[..., None])[..., 0], strict=True))
        self._triples = self._widest(markers)
        self.labels = {label for triple in self._triples for p in triple for label in self._labels(p)}

    def of(self, camera: Camera, blobs: Sequence[Blob]) -> Poses:
        """Those that three of some blobs allow, the one first whose markers look most as large as these; joints half
        way between their limits."""
        middles, area_px = centres(blobs), np.array([b.area_px for b in blobs])
        rays, found = normalise(camera, middles), list[tuple[float, Array, Array]]()
        for triple in self._triples:
            for three in self._alike(triple, blobs, area_px):
                found += self._solved(camera, triple, rays[three], area_px[three])
        found.sort(key=lambda one: one[0])
        kept = found[: self._config.triples_kept]
        if not kept:
            return self._surface.no_poses
        q = np.tile(self._kin.middle, (len(kept), 1))
        return Poses(np.array([R for _, R, _ in kept]), np.array([t for _, _, t in kept]), q)

    def _solved(self, camera: Camera, triple: _Triple, rays: Array, area_px: Array) -> list[tuple[float, Array, Array]]:
        """By how much markers differ from blobs in size, and pose, of each pose under which they may be these.

        :param rays: (3, 2) normalised. :param area_px: (3,)
        """
        at, normal = (np.array([of[p] for p in triple]) for of in (self._at, self._normal))
        _, turns, places = cv2.solveP3P(at, rays, np.eye(3), None, flags=cv2.SOLVEPNP_AP3P)
        out = []
        for turn, place in zip(turns, places, strict=True):
            R, t = cv2.Rodrigues(turn)[0], place[:, 0]
            there = at @ R.T + t
            range_m = np.linalg.norm(there, axis=1)
            cosine = -((normal @ R.T) * there).sum(axis=1) / np.maximum(range_m, _LEAST_DEPTH_M)
            if not (np.isfinite(t).all() and there[:, 2].min() > _LEAST_DEPTH_M and cosine.min() > 0):
                continue
            looks_px = self._surface.area[list(triple)] * cosine * (camera.focal_px / there[:, 2]) ** 2
            off = np.abs(np.log(looks_px / area_px))
            if off.max() < np.log(self._ratio):
                out.append((float(off.sum()), R, t))
        return out

    def _alike(self, triple: _Triple, blobs: Sequence[Blob], area_px: Array) -> NDArray[np.int64]:
        """(n, 3) which blobs may be these markers, the few first that are most alike in scale."""
        made = [[n for n, b in enumerate(blobs) if b.label in self._labels(p)] for p in triple]
        threes = np.array(list(product(*made)), np.int64).reshape(-1, 3)
        threes = threes[(threes != np.roll(threes, 1, axis=1)).all(axis=1)]
        scale = np.log(area_px[threes] / self._surface.area[list(triple)])
        return threes[np.argsort(np.ptp(scale, axis=1), kind="stable")[: self._config.triples_tried]]

    def _labels(self, patch: int) -> tuple[int, ...]:
        return self._surface.labels[self._surface.component[patch]]

    def _widest(self, markers: Sequence[int]) -> list[_Triple]:
        """Those few threes of markers of different components, rigid to each other and seen from one side, that span
        most."""
        moves, of = self._kin.moves, self._surface.component
        spans = list[tuple[float, _Triple]]()
        for triple in combinations(markers, 3):
            a, b, c = (of[p] for p in triple)
            rigid = len({a, b, c}) == 3 and (moves[a] == moves[b]).all() and (moves[a] == moves[c]).all()
            if rigid and min(self._normal[p] @ self._normal[r] for p, r in combinations(triple, 2)) > 0:
                x, y, z = (self._at[p] for p in triple)
                spans.append((float(np.linalg.norm(np.cross(y - x, z - x))), triple))
        spans.sort(key=lambda one: -one[0])
        return [triple for span, triple in spans[: self._config.triples] if span > 0]
