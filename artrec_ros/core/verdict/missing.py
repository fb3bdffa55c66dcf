"""Why components of an object are not told: where its pose puts them, nothing could be seen, or nothing was."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..model.found import Missing, MissingState
from ..model.kinematics import Frames
from ..pose.finder import WholeObjectFinder
from .acceptance import Verdict
from .claims import silhouette

_ITSELF = "itself"
_OPEN = 0.5  # of a marker that is seen, or that nothing of one sort leaves, says which it is
# from what is nearest to being seen to what is farthest from it
_ORDER: tuple[MissingState, ...] = ("not seen", "too small", "hidden", "out of view", "turned away")


class MarkersInView(NamedTuple):
    """What of the M markers of H objects, by n points on each, could be seen.

    :param centre: (H, M, 2) their centroids, pixels. :param depth: (H, M) of these. :param within: (H, M, n) in the
        image. :param open: (H, M, n) not hidden by the object itself; of markers that face the camera.
    :param free: (H, M, n) not owned by another object.
    """

    centre: Array
    depth: Array
    within: NDArray[np.bool_]
    open: NDArray[np.bool_]
    free: NDArray[np.bool_]

    @property
    def seen(self) -> NDArray[np.bool_]:
        return self.within & self.open & self.free


class MissingParts:
    """Those of one target's objects."""

    def __init__(self, finder: WholeObjectFinder) -> None:
        self._finder, self._surface = finder, finder.surface
        patches = [self._surface.patches[p] for p in self._surface.markers]
        self._normal = np.array([p.normal for p in patches])
        self._middle = np.array([p.drawn[0] for p in patches])
        self._area = np.array([p.marker.area if p.marker is not None else 0.0 for p in patches])
        self._of = self._surface.component[self._surface.markers]
        self._names = [c.name for c in finder.target.model.components]

    def of(
        self,
        verdicts: Sequence[Verdict],
        told: Sequence[set[int]],
        probable: Sequence[dict[int, float]],
        view: MarkersInView,
        frames: Frames,
        frame: ImageFrame,
        among: Sequence[Verdict],
    ) -> list[tuple[Missing, ...]]:
        """Of each object the components that are not told.

        :param told: those that are. :param probable: of those that something shows, how probable it is.
        :param among: all objects of the frame, one of which may hide another.
        """
        every, out = set(range(len(self._names))), list[tuple[Missing, ...]]()
        cosine, area_px = self._aspects(view, frames, frame)
        for h, verdict in enumerate(verdicts):
            left = sorted(every - told[h])
            others = [v for v in among if v is not verdict] if left else []
            states = (
                [self._state(h, m, view, cosine[h, m], area_px[h, m]) for m in range(len(self._of))] if left else []
            )
            doubted = {c: p for c, p in probable[h].items() if c != self._surface.root}
            out.append(tuple(self._missing(h, c, states, doubted, view, others, frame) for c in left))
        return out

    def _aspects(self, view: MarkersInView, frames: Frames, frame: ImageFrame) -> tuple[Array, Array]:
        """(H, M) cosines of the angles between markers' normals and the lines of sight, and their areas in pixels."""
        R, t = frames.R[:, self._of], frames.t[:, self._of]
        at = np.einsum("hmij,mj->hmi", R, self._middle) + t
        normal = np.einsum("hmij,mj->hmi", R, self._normal)
        cosine = -np.sum(normal * at, axis=2) / np.maximum(np.linalg.norm(at, axis=2), 1e-9)
        scale = frame.camera.focal_px / np.maximum(view.depth, 1e-6)
        return cosine, self._area * scale**2 * np.maximum(cosine, 0.0)

    def _state(self, h: int, m: int, view: MarkersInView, cosine: float, area_px: float) -> MissingState:
        if cosine <= self._surface.limits.least_cosine:
            return "turned away"
        if view.within[h, m].mean() < _OPEN:
            return "out of view"
        share = view.seen[h, m].mean()
        if share < _OPEN:
            return "hidden"
        return "too small" if area_px * share < self._finder.config.min_blob_px else "not seen"

    def _missing(
        self,
        h: int,
        component: int,
        states: Sequence[MissingState],
        doubted: dict[int, float],
        view: MarkersInView,
        others: Sequence[Verdict],
        frame: ImageFrame,
    ) -> Missing:
        mine = np.flatnonzero(self._of == component).tolist()
        best = min(mine, key=lambda m: (_ORDER.index(states[m]), -view.seen[h, m].mean()))
        state, (x, y) = states[best], view.centre[h, best].tolist()
        if component in doubted:
            return Missing(self._names[component], "in doubt", x, y, score=doubted[component])
        by = ""
        if state == "hidden":
            within = view.within[h, best]
            own = (within & ~view.open[h, best]).sum() >= (within & ~view.free[h, best]).sum()
            by = _ITSELF if own else _hider(others, (x, y), frame)
        return Missing(self._names[component], state, x, y, by)


def _hider(others: Sequence[Verdict], at: tuple[float, float], frame: ImageFrame) -> str:
    """Which object covers a place in the image, of those that do the one whose outline is farthest around it."""
    around = [(_depth_in(v, at, frame), v.claim.finder.target.name) for v in others]
    inside = [(px, name) for px, name in around if px >= 0]
    return max(inside)[1] if inside else ""


def _depth_in(verdict: Verdict, at: tuple[float, float], frame: ImageFrame) -> float:
    """How far inside of an object's silhouette a place is, pixels; outside it is negative."""
    hulls = silhouette(verdict.claim.finder.surface, frame.camera, verdict.claim.poses)
    return max(float(cv2.pointPolygonTest(cv2.convexHull(hull), at, True)) for hull in hulls)
