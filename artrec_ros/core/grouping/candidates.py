"""What could be which component: instances assigned to components (paper, step 6)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..alignment.matching import Matches
from ..alignment.shapes import pack_shapes
from ..base.config import RecognizerConfig
from ..constraints import pair_kernels as compiled
from ..constraints.pair_boxes import pack_boxes
from ..constraints.pair_kernels import Boxes
from ..geometry.transforms import Array
from ..model.target import Target
from .candidate_kernels import RoleArrays, candidates

ShapeOf = dict[tuple[str, str], int]  # (component, marker) -> number of its shape


@dataclass(frozen=True)
class ImagePoses:
    """Where candidates lie: arrays of one shape, units as in `Instance`.

    :param place_noise_px, theta_noise, scale_noise: standard deviations; that of the scale is relative.
    """

    x: Array
    y: Array
    theta: Array
    scale: Array
    place_noise_px: Array
    theta_noise: Array
    scale_noise: Array

    @property
    def arrays(self) -> tuple[Array, Array, Array, Array, Array, Array, Array]:
        return (self.x, self.y, self.theta, self.scale, self.place_noise_px, self.theta_noise, self.scale_noise)

    def at(self, index: Any) -> ImagePoses:
        return ImagePoses(*(a[index] for a in self.arrays))


@dataclass(frozen=True)
class Candidates:
    """All (instance, component, marker, turn) of one target. An instance whose shape looks the same after a turn
    is a candidate in each of these directions: constraints tell which one it is.

    :param component: (n,) number of the component; marker: (n,) number of its marker; role: (n,) row of `roles`.
    :param match: (n,) number of the instance in `Matches`.
    :param share, score: (n,) as in `Evidence`; weight: (n,) contour explained, pixels.
    """

    roles: Roles
    component: NDArray[np.int64]
    marker: NDArray[np.int64]
    role: NDArray[np.int64]
    match: NDArray[np.int64]
    poses: ImagePoses
    share: Array
    score: Array
    weight: Array

    def __len__(self) -> int:
        return len(self.component)

    @cached_property
    def component_list(self) -> list[int]:
        return self.component.tolist()

    @cached_property
    def choices(self) -> list[tuple[int, int]]:
        """(component, instance) of each: the same for candidates that differ in their turns alone."""
        return list(zip(self.component_list, self.match.tolist(), strict=True))

    @property
    def target(self) -> Target:
        return self.roles.target

    @property
    def packed(self) -> compiled.PoseArrays:
        """As compiled code takes them."""
        return compiled.PoseArrays(*self.poses.arrays, self.component, self.role, self.match)

    def take(self, index: NDArray[np.int64]) -> Candidates:
        return Candidates(
            self.roles,
            self.component[index],
            self.marker[index],
            self.role[index],
            self.match[index],
            self.poses.at(index),
            self.share[index],
            self.score[index],
            self.weight[index],
        )

    def key(self, n: int) -> tuple[str, str]:
        """Names of a candidate's component and marker."""
        component = self.target.model.components[self.component[n]]
        return component.name, component.markers[self.marker[n]].name


@dataclass(frozen=True)
class Roles:
    """What instances can be in one target: a row per marker and class that it may have, in the model's order.

    :param key: (K,) numbers of the markers in the model's order, as constraints count them.
    :param shape, label, axis_angle: (K,) the marker's shape, class and axis in the shape.
    :param boxes: the target's constraints. :param least_perimeter_m: (N,) of each component's shortest marker.
    """

    target: Target
    component: NDArray[np.int64]
    marker: NDArray[np.int64]
    key: NDArray[np.int64]
    shape: NDArray[np.int64]
    label: NDArray[np.int64]
    axis_angle: Array
    boxes: Boxes
    least_perimeter_m: Array

    @property
    def required_shapes(self) -> NDArray[np.int64]:
        """(n,) those of the required component's markers."""
        model = self.target.model
        return self.shape[self.component == model.components.index(model.required)]

    @classmethod
    def of(cls, target: Target, shape_of: ShapeOf) -> Roles:
        markers = [(c, m, marker) for c, p in enumerate(target.model.components) for m, marker in enumerate(p.markers)]
        rows = [
            (c, m, key, shape_of[target.model.components[c].name, marker.name], label)
            for key, (c, m, marker) in enumerate(markers)
            for label in target.model.components[c].labels(target.label)
        ]
        angles = np.array([markers[key][2].axis_angle for _, _, key, *_ in rows])
        # of its own memory each: columns of one array would be of another type where there is one row alone
        component, marker, key, shape, label = (np.array(column, np.int64) for column in zip(*rows, strict=True))
        perimeters = np.array([min(m.perimeter for m in c.markers) for c in target.model.components])
        return cls(target, component, marker, key, shape, label, angles, pack_boxes(target), perimeters)

    @cached_property
    def packed(self) -> RoleArrays:
        """As compiled code takes them."""
        return RoleArrays(self.component, self.marker, self.shape, self.label, self.axis_angle)


def candidates_of(roles: Roles, matches: Matches, config: RecognizerConfig) -> Candidates:
    """Candidates of every component of a target, in the model's order.

    Noise: a contour's place, and what a flat rigid model leaves out (lens, slant, tolerance of make).
    """
    noise = config.constraints.contour_noise_px, config.constraints.model_noise
    shapes = pack_shapes(tuple(matches.shapes))
    p, marker, *values = candidates(matches.packed, roles.packed, shapes, config.alignment.symmetry_px, *noise)
    return Candidates(roles, p.component, marker, roles.key[p.key], p.match, ImagePoses(*p[:7]), *values)
