"""The boxes of bodies that may hide what is behind them, and an object's outline by its solids."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from typing import NamedTuple

import numpy as np

from ..geometry.convex_pieces import convex_pieces
from ..geometry.transforms import Array, rotation_from_rotvec
from ..model.objects import ObjectModel
from ..model.surface import Patch

BEHIND = 1 - 1e-4  # share of the way to a point beyond which a box no longer hides it
_FLUSH_M = 1e-6
_STAR = 0.83  # of a ball's radius: half a side of two squares across each other that cover as much as it
_CORNERS = np.array(np.meshgrid(*[[-1.0, 1.0]] * 3)).reshape(3, -1).T


class BodyBoxes:
    """The B boxes of all components' bodies."""

    def __init__(self, model: ObjectModel) -> None:
        boxes = [(c, box) for c, component in enumerate(model.components) for box in component.bodies]
        self.component = np.array([c for c, _ in boxes], int)
        self.R = np.array([b.T_component_box.rotation for _, b in boxes]).reshape(-1, 3, 3)
        self.t = np.array([b.T_component_box.position for _, b in boxes]).reshape(-1, 3)
        self.half = np.array([b.size / 2 for _, b in boxes]).reshape(-1, 3)

    def __len__(self) -> int:
        return len(self.half)

    def behind_patches(self, patches: Sequence[Patch]) -> np.ndarray:
        """(P, B) bool: boxes wholly behind a patch of the same component; seen from its front they cannot hide it. Of a
        ball those within it."""
        out = np.zeros((len(patches), len(self)), bool)
        for b, (component, R, t, half) in enumerate(zip(self.component, self.R, self.t, self.half, strict=True)):
            corners = (_CORNERS * half) @ R.T + t
            for p, patch in enumerate(patches):
                if patch.bulge:
                    beyond = np.linalg.norm(corners - patch.drawn[0], axis=1) - patch.bulge
                else:
                    beyond = (corners - patch.inside[0]) @ patch.normal
                out[p, b] = patch.component == component and beyond.max() < _FLUSH_M
        return out


class Opaque(NamedTuple):
    """What hides things behind an object: K boxes in their components' frames.

    :param component: (K,). :param R, t: (K, 3, 3), (K, 3). :param half: (K, 3) half of their sizes.
    """

    component: np.ndarray
    R: Array
    t: Array
    half: Array


def opaque_of(boxes: BodyBoxes, patches: Sequence[Patch]) -> Opaque:
    """All boxes of bodies, and of markers the rectangles that hold them, of balls two squares across each other."""
    plates = []
    for patch in patches:
        if patch.bulge:
            half = np.append(np.full(2, _STAR * patch.bulge), _FLUSH_M)
            turns = (rotation_from_rotvec(np.array([0.0, 0.0, turn])) for turn in (0.0, np.pi / 4))
            plates += [(patch.component, R, patch.drawn[0], half) for R in turns]
        elif patch.marker is not None and patch.marker.T_component_marker is not None:
            at, outline = patch.marker.T_component_marker, patch.marker.outline
            low, high = outline.min(axis=0), outline.max(axis=0)
            middle = at.apply(np.append((low + high) / 2, 0.0)[None])[0]
            plates.append((patch.component, at.rotation, middle, np.append((high - low) / 2, _FLUSH_M)))
    component, R, t, half = map(np.array, zip(*plates, strict=True))
    both = (boxes.component, component), (boxes.R, R), (boxes.t, t), (boxes.half, half)
    return Opaque(*map(np.concatenate, both))


class Hulls(NamedTuple):
    """Solids whose hulls cover an object: solid k has corners[starts[k]:starts[k + 1]]."""

    corners: Array  # (n, 3) in their components' frames
    component: np.ndarray  # (n,)
    starts: list[int]  # and the end of the last


def hulls_of(model: ObjectModel) -> Hulls:
    """All boxes and markers of a spatial model; what lies in a marker's notch it does not cover."""
    solids = []
    for c, component in enumerate(model.components):
        solids += [(c, box.T_component_box.apply(_CORNERS * (np.array(box.size) / 2))) for box in component.bodies]
        for marker in component.markers:
            assert marker.T_component_marker is not None  # the model is spatial
            pieces = convex_pieces(marker.outline)
            solids += [(c, marker.T_component_marker.apply(np.pad(piece, ((0, 0), (0, 1))))) for piece in pieces]
    sizes = [len(corners) for _, corners in solids]
    component_of = np.repeat([c for c, _ in solids], sizes)
    return Hulls(np.concatenate([corners for _, corners in solids]), component_of, [0, *accumulate(sizes)])
