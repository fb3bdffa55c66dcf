"""Why components of an object are not told: where its pose puts them, nothing could be seen, or nothing was."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..model.found import Missing, MissingState
from ..model.kinematics import Frames
from ..pose.finder import WholeObjectFinder
from ..pose.surface_kernels import LEAST_DEPTH_M
from ..pose.unseen import in_view
from .claims import silhouette
from .verdicts import Verdict

_ITSELF = "itself"
_OPEN = 0.5  # share of a marker of which this says what is said of all of it
# from what is nearest to being seen to what is farthest from it
_STATES: tuple[MissingState, ...] = ("not seen", "too small", "hidden", "out of view", "turned away")
_NOT_SEEN, _TOO_SMALL, _HIDDEN, _OUT_OF_VIEW, _TURNED_AWAY = range(len(_STATES))


@dataclass(frozen=True, eq=False)
class MarkersInView:
    """What of the M markers of H objects, by n points on each, could be seen.

    :param centre: (H, M, 2) their centroids, pixels. :param depth: (H, M) of these, metres.
    :param outlines: of each of the M markers (H, n, 2), pixels.
    :param within: (H, M, n) in the image. :param open: (H, M, n) not hidden by the object itself, of markers that face
        the camera. :param free: (H, M, n) not hidden by another one; where it is not known what is nearer, not owned.
    :param by: (N, H, M, n) which of the frame's N objects hides what; None: which one is nearer is not known.
    """

    centre: Array
    depth: Array
    outlines: Sequence[Array]
    within: NDArray[np.bool_]
    open: NDArray[np.bool_]
    free: NDArray[np.bool_]
    by: NDArray[np.bool_] | None

    @cached_property
    def seen(self) -> NDArray[np.bool_]:
        """(H, M, n) points that are."""
        return self.within & self.open & self.free


class MissingParts:
    """Those of one target's objects."""

    def __init__(self, finder: WholeObjectFinder) -> None:
        self._finder, self._surface, self._least_px = finder, finder.surface, finder.config.min_blob_px
        self._thin_px, self._told_agree = finder.config.votes.ring_width_px, finder.config.verdict.told_agree
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
        left = [sorted(set(range(len(self._names))) - mine) for mine in told]
        if not any(left):
            return [()] * len(verdicts)
        states, out = self._states(verdicts, view, frames, frame), list[tuple[Missing, ...]]()
        for h, verdict in enumerate(verdicts):
            doubted = {c: p for c, p in probable[h].items() if c != self._surface.root}
            out.append(tuple(self._missing(h, c, states[h], doubted, view, verdict, among, frame) for c in left[h]))
        return out

    def _states(
        self, verdicts: Sequence[Verdict], view: MarkersInView, frames: Frames, frame: ImageFrame
    ) -> NDArray[np.int64]:
        """(H, M) which of `_STATES` each marker is in, if it shows nothing. One that is mostly beyond the image's
        border is not seen where enough of it is in plain view and does not bear its class."""
        R, t = frames.R[:, self._of], frames.t[:, self._of]
        at = (R @ self._middle[:, :, None])[..., 0] + t
        towards = -np.sum((R @ self._normal[:, :, None])[..., 0] * at, axis=2)
        cosine = towards / np.maximum(np.linalg.norm(at, axis=2), 1e-9)
        scale, share = frame.camera.focal_px / np.maximum(view.depth, LEAST_DEPTH_M), view.seen.mean(axis=2)
        area_px = self._area * scale**2 * np.maximum(cosine, 0.0) * share
        away = cosine <= self._surface.limits.least_cosine
        within = view.within.mean(axis=2)
        outside = within < _OPEN
        for h in np.flatnonzero(outside.any(axis=1)).tolist():
            claim = verdicts[h].claim
            outside[h] &= ~in_view(self._finder, claim.frame, claim.poses, claim.scores).lacking[0]
        beyond = (view.depth <= LEAST_DEPTH_M) | outside
        state = np.where(area_px < self._least_px, _TOO_SMALL, _NOT_SEEN)
        for holds, which in ((share < _OPEN * within, _HIDDEN), (beyond, _OUT_OF_VIEW), (away, _TURNED_AWAY)):
            state[holds] = which
        return state

    def _missing(
        self,
        h: int,
        component: int,
        states: NDArray[np.int64],
        doubted: dict[int, float],
        view: MarkersInView,
        verdict: Verdict,
        among: Sequence[Verdict],
        frame: ImageFrame,
    ) -> Missing:
        mine = np.flatnonzero(self._of == component)
        mine_in = np.array([self._state(states[m], view.outlines[m][h]) for m in mine.tolist()])
        best, state = int(mine[np.argmin(mine_in)]), int(mine_in.min())
        name, (x, y) = self._names[component], view.centre[h, best].tolist()
        if component in doubted:
            return Missing(name, "in doubt", x, y, score=doubted[component])
        if component == self._surface.root and state == _NOT_SEEN and self._shows_some(verdict):
            return Missing(name, "in doubt", x, y)  # its probability, as others', nothing tells: its object's is known
        by = ""
        if state == _HIDDEN:
            within = view.within[h, best]
            own, anothers = (int((within & ~by_whom[h, best]).sum()) for by_whom in (view.open, view.free))
            by = _ITSELF if own >= anothers else _hider(h, best, verdict, among, view, frame)
        return Missing(name, _STATES[state], x, y, by)

    def _shows_some(self, verdict: Verdict) -> bool:
        """Whether the required component's marker bears its class on a share that would do, did votes speak for it."""
        scores, patch = verdict.claim.scores, verdict.shown[self._surface.root]
        return bool(scores.agree[0, patch] > self._told_agree and scores.area_px[0, patch] > self._least_px)

    def _state(self, state: int, outline: Array) -> int:
        """One marker's, by its outline (n, 2) in pixels: a sliver, be it long, may have no label of its own between the
        seams along its two sides."""
        if state != _NOT_SEEN:
            return int(state)
        drawn = outline.astype(np.float32)
        return _TOO_SMALL if 2 * cv2.contourArea(drawn) < self._thin_px * cv2.arcLength(drawn, True) else _NOT_SEEN


def _hider(
    h: int, marker: int, verdict: Verdict, among: Sequence[Verdict], view: MarkersInView, frame: ImageFrame
) -> str:
    """Which object hides a marker of another: most of it, or, where it is not known which one is nearer, of those that
    cover its middle the one in whose silhouette it lies deepest."""
    names = [v.claim.finder.target.name for v in among]
    if view.by is not None:
        hidden = (view.by[:, h, marker] & view.within[h, marker]).sum(axis=1)
        return names[int(hidden.argmax())] if hidden.any() else ""
    x, y = view.centre[h, marker].tolist()
    around = [(_depth_px(v, (x, y), frame), n) for v, n in zip(among, names, strict=True) if v is not verdict]
    inside = [(px, name) for px, name in around if px >= 0]
    return max(inside)[1] if inside else ""


def _depth_px(verdict: Verdict, at: tuple[float, float], frame: ImageFrame) -> float:
    """How deep inside of an object's silhouette a place lies; outside it is negative."""
    hulls = silhouette(verdict.claim.finder.surface, frame.camera, verdict.claim.poses)
    return max(float(cv2.pointPolygonTest(cv2.convexHull(hull), at, True)) for hull in hulls)
