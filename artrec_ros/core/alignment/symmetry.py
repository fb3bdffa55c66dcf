"""Turns after which a shape cannot be told from itself, found from its contour alone."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..geometry.polygons import distance_to_outline
from ..geometry.transforms import Array

ANY_ANGLE = 0  # the order of a disc: every turn leaves it as it is
_MAX_ORDER = 12
_PROBES_RAD = 2 * np.pi * np.arange(1, 19) / 37  # turns that no polygon of few sides repeats after


@dataclass(frozen=True)
class Symmetry:
    """How far a shape moves off itself by a turn about its centroid.

    :param residual_m: (13,) residual_m[n] is the rms distance between the outline and itself turned by 2 pi / n;
        residual_m[0] is the largest over turns of any size, residual_m[1] is 0.
    """

    residual_m: Array

    def is_any_angle(self, scale: float, ambiguous_px: float) -> bool:
        """Whether `order` is `ANY_ANGLE`."""
        return bool(self.residual_m[0] * scale <= ambiguous_px)

    def order(self, scale: float, ambiguous_px: float) -> int:
        """Order n of the symmetry as seen at a scale (pixels per metre): turns by 2 pi / n look the same.

        A shape's turns are told apart only where the outline moves by `ambiguous_px` or more: a small
        shape is more symmetric than a large one. 1: no symmetry; `ANY_ANGLE`: direction has no meaning.
        """
        same = np.flatnonzero(self.residual_m * scale <= ambiguous_px)
        return ANY_ANGLE if same[0] == 0 else int(same[-1])


def find_symmetry(points: Array, outline: Array) -> Symmetry:
    """Symmetry of a closed outline.

    :param points: (m, 2) samples of the outline, about its centroid.
    :param outline: (n, 2) the outline's vertices, about the same point.
    """
    residual = np.zeros(_MAX_ORDER + 1)
    for n in range(2, _MAX_ORDER + 1):
        residual[n] = _turned_distance(points, outline, 2 * np.pi / n)
    residual[0] = max(_turned_distance(points, outline, a) for a in _PROBES_RAD)
    residual.setflags(write=False)
    return Symmetry(residual)


def _turned_distance(points: Array, outline: Array, angle: float) -> float:
    c, s = np.cos(angle), np.sin(angle)
    d = distance_to_outline(points @ np.array([[c, s], [-s, c]]), outline)
    return float(np.sqrt(np.mean(d**2)))
