"""What a body hides from the camera: boxes against rays, batched over hypotheses."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from .compiled.hiding import hidden
from .compiled.jit import COMPILED
from .kinematics import Frames
from .objects import ObjectModel
from .surface import Patch
from .transforms import Array

BEHIND = 1 - 1e-4  # share of the way to a point beyond which a box no longer hides it
SUNK_M = 2e-3  # a marker may be declared this much below the face that it sticks on
_CORNERS = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T


class Boxes:
    """The B boxes of all components' bodies."""

    def __init__(self, model: ObjectModel) -> None:
        boxes = [(c, box) for c, component in enumerate(model.components) for box in component.bodies]
        self.component = np.array([c for c, _ in boxes], int)
        self.R = np.array([b.T_component_box.rotation for _, b in boxes]).reshape(-1, 3, 3)
        self.t = np.array([b.T_component_box.position for _, b in boxes]).reshape(-1, 3)
        self.half = np.array([b.size / 2 for _, b in boxes]).reshape(-1, 3)

    def __len__(self) -> int:
        return len(self.half)

    def in_camera(self, frames: Frames) -> tuple[Array, Array]:
        """Rotations of all boxes (H, B, 3, 3), and the camera's centre in their frames (H, B, 3)."""
        R_component = frames.R[:, self.component]
        R = R_component @ self.R
        t = np.einsum("hbij,bj->hbi", R_component, self.t) + frames.t[:, self.component]
        return R, -np.einsum("hbji,hbj->hbi", R, t)

    def hidden(self, frames: Frames, X: Array, ignored: np.ndarray) -> np.ndarray:
        """(H, n) bool: which points (H, n, 3) a box hides from the camera (slab test).

        :param ignored: (n, B) boxes that cannot hide a point, `behind_patches` of its patch.
        """
        out = np.zeros(X.shape[:2], bool)
        R, eye = self.in_camera(frames)
        if COMPILED:
            turn, eye, X = (np.ascontiguousarray(values) for values in (R.transpose(0, 1, 3, 2), eye, X))
            hidden(turn, eye, self.half, X, ignored, BEHIND, out)
            return out
        axes = [np.ascontiguousarray(X[..., i]) for i in range(3)]  # one array an axis: no short reductions
        for b, half in enumerate(self.half):
            enter, leave = np.float64(0.0), np.float64(BEHIND)
            for i in range(3):
                ray = sum(axes[j] * R[:, b, j, i, None] for j in range(3))
                ray = np.where(np.abs(ray) < 1e-9, 1e-9, ray)
                near, far = (-half[i] - eye[:, b, i, None]) / ray, (half[i] - eye[:, b, i, None]) / ray
                enter, leave = np.maximum(enter, np.minimum(near, far)), np.minimum(leave, np.maximum(near, far))
            out |= (enter < leave) & ~ignored[:, b]
        return out

    def behind_patches(self, patches: Sequence[Patch]) -> np.ndarray:
        """(P, B) bool: boxes wholly behind a patch of the same component; seen from its front they cannot hide it."""
        out = np.zeros((len(patches), len(self)), bool)
        for b, (component, R, t, half) in enumerate(zip(self.component, self.R, self.t, self.half, strict=True)):
            corners = (_CORNERS * half) @ R.T + t
            for p, patch in enumerate(patches):
                above = (corners - patch.inside[0]) @ patch.normal
                out[p, b] = patch.component == component and above.max() < SUNK_M
        return out


class Hulls(NamedTuple):
    """Solids whose hulls cover an object: solid k has corners[starts[k]:starts[k + 1]]."""

    corners: Array  # (n, 3) in their components' frames
    component: np.ndarray  # (n,)
    starts: list[int]  # and the end of the last


def hulls_of(model: ObjectModel) -> Hulls:
    """All boxes and markers of a spatial model."""
    solids = []
    for c, component in enumerate(model.components):
        solids += [(c, box.T_component_box.apply(_CORNERS * (np.array(box.size) / 2))) for box in component.bodies]
        for marker in component.markers:
            assert marker.T_component_marker is not None  # the model is spatial
            solids.append((c, marker.T_component_marker.apply(np.pad(marker.outline, ((0, 0), (0, 1))))))
    sizes = [len(corners) for _, corners in solids]
    component_of = np.repeat([c for c, _ in solids], sizes)
    return Hulls(np.concatenate([corners for _, corners in solids]), component_of, [0, *accumulate(sizes)])
