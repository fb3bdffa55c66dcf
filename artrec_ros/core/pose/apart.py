"""How far apart the components of an object can be in the image, bent any way, and lengths being off."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.transforms import Array
from ..model.kinematics import Kinematics
from .surface_model import SpatialModel

_DRAWS, _ENDS = 512, 0.5  # ways to bend joints, and the share of joints that are at one of their limits in each


class Apart:
    """Of one object. :param scale: pixels per metre."""

    def __init__(self, surface: SpatialModel, config: RecognizerConfig) -> None:
        self._of, self._off = surface.component[surface.markers], config.verdict.lengths_off
        middle, area = (values[surface.markers] for values in surface.sides.blobs)
        self._reach = _reach(surface.kinematics, middle, self._of)
        self._wide = np.array([area[self._of == c].max(initial=0.0) for c in range(len(self._reach))])
        self._wide = 2 * np.sqrt(self._wide / np.pi)

    def within_px(self, component: int, shown: NDArray[np.int64], scale: Array) -> Array:
        """(B, n) how far from each of some markers a component's can be, at scales (B, n), and by its size and a
        share of that farther: lengths may be off by as much."""
        far = (1 + self._off) * self._reach[component, self._of[shown]]
        return np.asarray((far + self._wide[component]) * scale, np.float64)

    def farthest_px(self, scale: float) -> float:
        """How far apart two components can be."""
        return float(self._reach.max() * (1 + self._off) * scale)

    def off_px(self, seen: Sequence[int], scale: float) -> Array:
        """(C,) how far each component may lie from where a pose has it by what is seen."""
        others = np.where(np.eye(len(self._reach), dtype=bool), np.inf, self._reach)[:, seen]
        nearest = others.min(axis=1, initial=np.inf)
        off = np.where(np.isfinite(nearest), self._off * nearest, 0.0)
        return np.asarray((self._wide + off) * scale, np.float64)


def _reach(kin: Kinematics, middle: Array, of: NDArray[np.int64]) -> Array:
    """(C, C) how far apart two components' markers can be, metres: the most of many ways to bend all joints.

    :param middle: (M, 3) of each marker, in its component's frame. :param of: (M,) its component.
    """
    rng, n = np.random.default_rng(0), kin.n_joints
    q = rng.uniform(kin.lower, kin.upper, (_DRAWS, n))
    q = np.where(rng.random(q.shape) < _ENDS, np.where(rng.random(q.shape) < 0.5, kin.lower, kin.upper), q)
    frames = kin.in_object(np.ascontiguousarray(q))
    at = (frames.R[:, of] @ middle[:, :, None])[..., 0] + frames.t[:, of]
    out = np.zeros((len(kin.parent), len(kin.parent)))
    for m, c in enumerate(of.tolist()):
        np.maximum.at(out, (c, of), np.linalg.norm(at - at[:, m : m + 1], axis=2).max(axis=0))
    return np.maximum(out, out.T)
