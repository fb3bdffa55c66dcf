"""Where an object's markers lie, and which of them are alternatives: views of one thing that lie on each other."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ...core.geometry.transforms import Array
from ...core.model.kinematics import Kinematics
from ...core.model.objects import ObjectModel
from ...core.model.solids import closed_components
from ...core.model.surface import MEETING, sample_contour

ONE_WAY = 0.7
"""Cosine: who face so nearly one way are mostly seen together."""
_SAMPLES = 96  # of an outline
_DRAWN_PX = 100  # extent of outlines that are laid on each other
_COVERED = 0.1  # of the smaller one: whose outlines have so much in common are not there at once


class Placed(NamedTuple):
    """A marker in the object: its outline (n, 3) and normal (3,)."""

    name: str
    labels: tuple[int, ...]
    outline: Array
    normal: Array
    size_m: float
    component: int
    moves: tuple[bool, ...]  # by which joints it does
    is_of_solid: bool  # of a component whose markers meet all around

    @property
    def low(self) -> Array:
        return np.asarray(self.outline.min(axis=0))

    @property
    def high(self) -> Array:
        return np.asarray(self.outline.max(axis=0))


def placed(model: ObjectModel) -> list[Placed]:
    """All markers with a pose, joints mid-range; but for balls, which lie in no plane."""
    kin = Kinematics(model)
    frames, known = kin.in_object(kin.middle[None]), list[Placed]()
    solid = closed_components(model)
    for c, part in enumerate(model.components):
        for marker in part.markers if part.ball is None else ():
            if (T := marker.T_component_marker) is not None:
                points = np.pad(sample_contour(marker.outline, _SAMPLES)[0], ((0, 0), (0, 1)))
                outline = T.apply(points) @ frames.R[0, c].T + frames.t[0, c]
                normal = frames.R[0, c] @ T.rotation[:, 2]
                about = outline, normal, marker.area**0.5, c, tuple(kin.moves[c].tolist()), part.name in solid
                known.append(Placed(f"{part.name}/{marker.name}", part.labels(0), *about))
    return known


def places(known: Sequence[Placed]) -> dict[str, int]:
    """A number for each marker, the same of alternatives: of one component that face one way and lie on each other,
    directly or by others. They are views of one thing, of which one at a time is there."""
    place = {m.name: n for n, m in enumerate(known)}
    for a, b in combinations(known, 2):
        if a.component == b.component and not a.is_of_solid and _cover(a, b):
            joined = place[b.name]
            place = {name: place[a.name] if n == joined else n for name, n in place.items()}
    return place


def _cover(a: Placed, b: Placed) -> bool:
    """Whether two markers that face one way have much of their areas in common."""
    return bool(a.normal @ b.normal > ONE_WAY) and _in_common(a, b) > _COVERED


def _in_common(a: Placed, b: Placed) -> float:
    """The share of the smaller one of two markers that face about one way which lies on the other."""
    near_m = MEETING * min(a.size_m, b.size_m)
    if (a.low > b.high + near_m).any() or (b.low > a.high + near_m).any():
        return 0.0
    one, other = _drawn([a, b])
    return float((one & other).sum() / min(one.sum(), other.sum()))


def _drawn(markers: Sequence[Placed]) -> NDArray[np.bool_]:
    """(n, H, W) which pixels each of n markers covers, seen as the first one is from in front."""
    first = markers[0]
    u = first.outline[0] - first.outline.mean(axis=0)
    u /= np.linalg.norm(u)
    flat = [m.outline @ np.stack([u, np.cross(first.normal, u)], axis=1) for m in markers]
    low, high = np.min([f.min(axis=0) for f in flat], axis=0), np.max([f.max(axis=0) for f in flat], axis=0)
    masks = np.zeros((len(flat), _DRAWN_PX + 1, _DRAWN_PX + 1), np.uint8)
    for mask, points in zip(masks, flat, strict=True):
        cv2.fillPoly(mask, [np.rint((points - low) / (high - low).max() * _DRAWN_PX).astype(np.int32)], 1)
    return np.asarray(masks > 0)
