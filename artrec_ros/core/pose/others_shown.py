"""Where an object that faces the camera could show another component than the required one, whatever its joints."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import cv2
import numpy as np
from numpy.typing import NDArray

from ..geometry.projection import project
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .finder import WholeObjectFinder
from .poses import Poses

_MOST_JOINTS = 4  # whose ends are looked at together: 16 places of each marker
_EDGE_PX = 2.0  # blends at an edge

Shown = Callable[[Poses], NDArray[np.bool_]]


class OthersShown:
    """A hypothesis under which no pixel speaks for any marker but the required component's is of a direction that
    nothing tells: to look for its joints is in vain. Where a joint turns markers they may be all around: none is asked.
    """

    def __init__(self, finder: WholeObjectFinder, lengths_off: float) -> None:
        """:param lengths_off: by what share of its distance a marker may lie off, as of `VerdictConfig`."""
        surface, kin, root = finder.surface, finder.surface.kinematics, finder.root
        others = [p for p in surface.markers if surface.component[p] != root]
        moved = kin.moves[surface.component[others]].any(axis=0)
        self._asks = not kin.moves[root].any() and not (moved & kin.revolute).any() and moved.sum() <= _MOST_JOINTS
        if not self._asks:
            return
        ends = [(kin.lower[j], kin.upper[j]) if moves else (0.0,) for j, moves in enumerate(moved.tolist())]
        at = kin.in_object(kin.bound(np.array([*product(*ends)], float)))
        middle = at.R[0, root] @ surface.anchor + at.t[0, root]
        self._labels, self._radius, places = list[tuple[int, ...]](), list[float](), list[Array]()
        for p in others:
            marker, c = surface.patches[p].marker, surface.component[p]
            assert marker is not None
            arms = at.R[:, c] @ marker.centre + at.t[:, c] - middle
            places.append(np.concatenate([middle + times * arms for times in (1 - lengths_off, 1 + lengths_off)]))
            self._labels.append(surface.patches[p].labels)
            self._radius.append(marker.radius)
        self._places, self._surface = np.array(places), surface  # (M, K, 3)

    def in_frame(self, frame: ImageFrame) -> Shown:
        """Which of hypotheses (H,) may show one of them in an image."""
        if not self._asks:
            return lambda poses: np.ones(len(poses), bool)
        sums = [self._sum(frame, labels) for labels in self._labels]
        return lambda poses: self._shown(frame, sums, poses)

    def _sum(self, frame: ImageFrame, labels: tuple[int, ...]) -> NDArray[np.int32]:
        """(H + 3, W + 3) of pixels that speak for a marker of these classes, above and left of each."""
        speaks = (self._surface.table[self._surface.roles.inside(labels)] > 0).astype(np.uint8)
        codes = frame.field.padded.reshape(-1, frame.field.codes.shape[1] + 2)
        return np.asarray(cv2.integral(cv2.LUT(codes, speaks)))

    def _shown(self, frame: ImageFrame, sums: list[NDArray[np.int32]], poses: Poses) -> NDArray[np.bool_]:
        found = np.zeros(len(poses), bool)
        for places, radius, total in zip(self._places, self._radius, sums, strict=True):
            there = np.einsum("hij,kj->hki", poses.R, places) + poses.t[:, None]
            px = project(frame.camera, there)
            around = (radius * frame.camera.focal_px / there[..., 2:].min(axis=1)) + _EDGE_PX
            most = np.array(total.shape[::-1]) - 1
            low = np.clip(np.floor(px.min(axis=1) - around) + 1, 0, most).astype(np.int64)  # of the padded image
            high = np.clip(np.ceil(px.max(axis=1) + around) + 2, 0, most).astype(np.int64)
            (x0, y0), (x1, y1) = low.T, high.T
            found |= total[y1, x1] - total[y0, x1] - total[y1, x0] + total[y0, x0] > 0
        return found
