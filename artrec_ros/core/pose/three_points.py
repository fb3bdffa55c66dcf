"""Poses by three points of a few blobs: of an object whose markers lie far apart beside their size.

How a small marker looks tells its slant by a few degrees at best, and a disc's not at all: where the next marker lies
ten widths away, that is a width or more, and no search along its joints meets it. Three points tell a rigid object's
pose to a fraction of a degree (the P3P problem; Ke and Roumeliotis, 2017), be they the middles of three markers or both
ends of a long one and the middle of another, and how large the blobs are whether they can be its markers. The sides of
a solid make one blob: it is one marker here, seen from all around.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations, product
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.camera import Camera
from ..geometry.projection import normalise
from ..geometry.transforms import Array, rotation_from_rotvec
from ..image.blobs import Blob, centres
from ..image.image_frame import ImageFrame
from .poses import Poses
from .surface_kernels import LEAST_DEPTH_M
from .surface_model import SpatialModel
from .views import long_axis


class _Three(NamedTuple):
    """Three points of an object.

    :ivar markers: two or three, of the surface. :ivar of: whose each point is, of these.
    :ivar along: where it lies on that one's long axis: 0 the middle, -1 and 1 its ends.
    """

    markers: tuple[int, ...]
    of: tuple[int, int, int]
    along: tuple[int, int, int]


class ThreePoints:
    """Of one object in space.

    :ivar labels: classes of the markers by which it may be found so; none, where no three points are rigid.
    """

    def __init__(self, surface: SpatialModel, config: RecognizerConfig) -> None:
        self._surface, self._config, self._kin = surface, config.middles, surface.kinematics
        self._ratio = config.verdict.left_over_ratio
        first = {surface.markers_of[c][0] for c in surface.solids}
        one_each = [p for p in surface.markers if surface.component[p] not in surface.solids or p in first]
        self._markers = np.array(one_each, np.int64)  # of a solid's sides the first, which stands for all of it
        self._at, self._half, self._normal = self._placed()
        _, self._area = surface.sides.blobs
        # what looks much the same from all sides
        self._is_round = np.isin(surface.component, sorted(surface.sides.balls | surface.solids))
        self._threes = self._widest()
        self.labels = {label for three in self._threes for p in three.markers for label in self._labels(p)}
        self.least = min((len(three.markers) for three in self._threes), default=0)  # of blobs

    def of(self, frame: ImageFrame, blobs: Sequence[Blob], asked: NDArray[np.bool_]) -> list[Poses]:
        """Those that three points of some blobs allow, by the blobs on which they lay markers: first on those that are
        most as large as these would look, as far as there is time; joints half way between their limits.

        :param asked: (n,) blobs of which one is among those that bear the points at least.
        """
        camera, middles, area_px = frame.camera, centres(blobs), np.array([b.area_px for b in blobs])
        halves = np.array([long_axis(b.contour).half for b in blobs]).reshape(-1, 2)
        found, on = [_NO_POSES], list[tuple[tuple[int, int], ...]]()
        for three in self._threes:
            if frame.deadline.expired:
                break
            rows = self._alike(three, blobs, middles, area_px, asked)
            for way in (1, -1)[: 1 + any(three.along)]:  # no one knows which end of a blob is which
                points = middles[rows[:, three.of]] + way * np.array(three.along)[:, None] * halves[rows[:, three.of]]
                rays = normalise(camera, points.reshape(-1, 2)).reshape(-1, 3, 2)
                of, *poses = self._solved(camera, three, rays, area_px[rows])
                found.append((poses[0], poses[1], poses[2]))
                on += [tuple(sorted(zip(three.markers, rows[n].tolist(), strict=True))) for n in of.tolist()]
        off, R, t = (np.concatenate(kind) for kind in zip(*found, strict=True))
        kept = np.argsort(off, kind="stable")[: self._config.triples_kept].tolist()
        together = {key: [n for n in kept if on[n] == key] for key in dict.fromkeys(on[n] for n in kept)}
        return [Poses(R[own], t[own], np.tile(self._kin.middle, (len(own), 1))) for own in together.values()]

    def _solved(
        self, camera: Camera, three: _Three, rays: Array, area_px: Array
    ) -> tuple[NDArray[np.int64], Array, Array, Array]:
        """Of k poses under which markers may be blobs which of n combinations of these (k,), by how much they differ in
        size (k,), and R (k, 3, 3) and t (k, 3).

        :param rays: (n, 3, 2) of the points, normalised. :param area_px: (n, m) of the markers' blobs.
        """
        markers = list(three.markers)
        at, normal, area = self._at[markers], self._normal[markers], self._area[markers]
        points, of = self._points(np.array([markers]), three.of, three.along)[0], list[int]()
        turns, places = list[Array](), list[Array]()
        for n, seen in enumerate(rays):
            count, turn, place = cv2.solveP3P(points, seen, np.eye(3), None, flags=cv2.SOLVEPNP_AP3P)
            turns, places, of = [*turns, *turn], [*places, *place], of + [n] * count
        t = np.array(places, float).reshape(-1, 3)
        R = rotation_from_rotvec(np.array(turns, float).reshape(-1, 3))
        there = at @ R.swapaxes(1, 2) + t[:, None]
        depth = np.maximum(there[..., 2], LEAST_DEPTH_M)
        cosine = -((normal @ R.swapaxes(1, 2)) * there).sum(axis=2) / np.linalg.norm(there, axis=2)
        cosine[:, self._is_round[markers]] = 1.0
        looks_px = area * np.maximum(cosine, 1e-9) * (camera.focal_px / depth) ** 2
        off = np.abs(np.log(looks_px / area_px[of]))
        may_be = (there[..., 2] > LEAST_DEPTH_M) & (off < np.log(self._ratio))  # and none is turned away
        kept = np.flatnonzero(may_be.all(axis=1))
        return np.array(of, np.int64)[kept], off[kept].sum(axis=1), R[kept], t[kept]

    def _alike(
        self, three: _Three, blobs: Sequence[Blob], middles: Array, area_px: Array, asked: NDArray[np.bool_]
    ) -> NDArray[np.int64]:
        """(n, m) which blobs may be these markers, no farther apart than these look: the few first that are most alike
        in scale. :param middles, area_px: of the blobs. :param asked: as of `of`."""
        labels, markers = np.array([b.label for b in blobs]), list(three.markers)
        by_size = np.argsort(-area_px, kind="stable")
        made = [by_size[np.isin(labels[by_size], self._labels(p))][: self._config.triples_blobs] for p in markers]
        rows = np.array(list(product(*made)), np.int64).reshape(-1, len(markers))
        rows = rows[(rows != np.roll(rows, 1, axis=1)).all(axis=1) & asked[rows].any(axis=1)]
        scale = np.sqrt(area_px[rows] / self._area[markers])  # pixels per metre, less where slanted
        apart_px = np.linalg.norm(middles[rows] - middles[np.roll(rows, 1, axis=1)], axis=2)
        apart_m = np.linalg.norm(self._at[markers] - np.roll(self._at[markers], 1, axis=0), axis=1)
        near = (apart_px <= self._ratio**0.5 * scale.max(axis=1, keepdims=True) * apart_m).all(axis=1)
        rows, unlike = rows[near], np.ptp(np.log(scale[near]), axis=1)
        return rows[np.argsort(unlike, kind="stable")[: self._config.triples_tried]]

    def _labels(self, patch: int) -> tuple[int, ...]:
        return self._surface.labels[self._surface.component[patch]]

    def _placed(self) -> tuple[Array, Array, Array]:
        """(P, 3) each: middles of markers, from there to one of their ends, and normals, in the object; of solids their
        own middles and ends. Rows of other patches are 0."""
        surface, (frames, of) = self._surface, (self._kin.in_object(self._kin.middle[None]), self._surface.component)
        at, half, normal = np.zeros((3, len(surface.patches), 3))
        middles, _ = surface.sides.blobs
        for p in self._markers.tolist():
            patch, R, t = surface.patches[p], frames.R[0, of[p]], frames.t[0, of[p]]
            at[p], normal[p] = R @ middles[p] + t, R @ patch.normal
            if of[p] in surface.solids:
                half[p] = R @ self._end(surface.markers_of[of[p]])
            elif patch.marker is not None and patch.marker.T_component_marker is not None:
                along = long_axis(patch.marker.outline)
                if along.ratio > self._config.elongated:
                    half[p] = R @ patch.marker.T_component_marker.rotation @ np.append(along.half, 0.0)
        return at, half, normal

    def _end(self, sides: NDArray[np.int64]) -> Array:
        """(3,) from the middle of a solid along its long axis to its end, in its frame; 0 where it has none."""
        corners = np.concatenate([self._surface.patches[p].drawn[3:] for p in sides])
        corners = corners - corners.mean(axis=0)
        axes = np.linalg.svd(corners, full_matrices=False)[2]
        along, across, _ = np.abs(corners @ axes.T).max(axis=0)
        return np.asarray(along * axes[0] * (along > self._config.elongated * across))

    def _points(self, markers: NDArray[np.int64], of: Sequence[int], along: Sequence[int]) -> Array:
        """(n, 3, 3) in the object, of n tuples of markers (n, m). :param of, along: as of `_Three`."""
        own = markers[:, of]
        return np.asarray(self._at[own] + np.array(along)[:, None] * self._half[own])

    def _widest(self) -> list[_Three]:
        """Those few threes of points of markers that are rigid to each other and seen from one side that span most:
        three middles before ends."""
        markers, moves = self._markers, self._kin.moves[self._surface.component]
        seen_at_once = (self._normal @ self._normal.T > 0) | self._is_round | self._is_round[:, None]
        together = (moves[:, None] == moves).all(axis=2) & seen_at_once
        long = markers[self._half[markers].any(axis=1)].tolist()
        kinds = (
            (combinations(markers.tolist(), 3), (0, 1, 2), (0, 0, 0)),
            (((a, b) for a in long for b in markers.tolist() if a != b), (0, 0, 1), (1, -1, 0)),
        )
        out = list[_Three]()
        for tuples, of, along in kinds:
            own = np.array(list(tuples), np.int64).reshape(-1, max(of) + 1)
            own = own[together[own, np.roll(own, 1, axis=1)].all(axis=1)]
            spans, longest = _spans(self._points(own, of, along))
            widest = np.argsort(-spans, kind="stable")
            wide = widest[(spans > _ON_A_LINE * longest**2)[widest]][: self._config.triples]
            out += [_Three(tuple(row), of, along) for row in own[wide].tolist()]
        return out[: self._config.triples]


_NO_POSES = np.zeros(0), np.zeros((0, 3, 3)), np.zeros((0, 3))
_ON_A_LINE = 0.02  # of the square of a triangle's longest side: with less it spans nothing, and tells no turn about it


def _spans(points: Array) -> tuple[Array, Array]:
    """(n,) twice the areas of triangles (n, 3, 3), and their longest sides."""
    sides = points - np.roll(points, 1, axis=1)
    return np.linalg.norm(np.cross(sides[:, 0], sides[:, 1]), axis=1), np.linalg.norm(sides, axis=2).max(axis=1)
