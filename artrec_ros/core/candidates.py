"""What could be which component: instances assigned to components and checked in pairs (paper, steps 6 and 8)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .compiled import pair_checks as compiled
from .compiled.candidacy import RoleArrays, candidates
from .compiled.jit import COMPILED
from .compiled.pair_checks import Boxes
from .config import RecognizerConfig
from .constraints import ConstraintSet
from .datatypes import Target
from .matching import Matches
from .pair_boxes import pack_boxes, reach_m
from .pairs import PairConstraint, configuration, configuration_noise
from .shapes import pack_shapes
from .symmetry import ANY_ANGLE
from .transforms import Array, wrap_angle

ShapeOf = dict[tuple[str, str], int]  # (component, marker) -> number of its shape


@dataclass(frozen=True)
class Poses:
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

    def at(self, index: Any) -> Poses:
        return Poses(*(a[index] for a in self.arrays))


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
    poses: Poses
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
        component = self.target.model.components[self.component[n]]
        return component.name, component.markers[self.marker[n]].name


@dataclass(frozen=True)
class Roles:
    """What instances can be in one target: a row per component and marker, in the model's order.

    :param shape, label, axis_angle: (K,) the marker's shape, class and axis in the shape.
    :param boxes: the target's constraints. :param least_perimeter_m: (N,) of each component's shortest marker.
    """

    target: Target
    component: NDArray[np.int64]
    marker: NDArray[np.int64]
    shape: NDArray[np.int64]
    label: NDArray[np.int64]
    axis_angle: Array
    boxes: Boxes
    least_perimeter_m: Array

    @classmethod
    def of(cls, target: Target, shape_of: ShapeOf) -> Roles:
        rows = [
            (c, m, shape_of[component.name, marker.name], target.label if component.label is None else component.label)
            for c, component in enumerate(target.model.components)
            for m, marker in enumerate(component.markers)
        ]
        angles = np.array([m.axis_angle for c in target.model.components for m in c.markers])
        component, marker, shape, label = np.array(rows, np.int64).T
        perimeters = np.array([min(m.perimeter for m in c.markers) for c in target.model.components])
        return cls(target, component, marker, shape, label, angles, pack_boxes(target), perimeters)

    @cached_property
    def packed(self) -> RoleArrays:
        """As compiled code takes them."""
        return RoleArrays(self.component, self.marker, self.shape, self.label, self.axis_angle)


def candidates_of(target: Target, shape_of: ShapeOf, matches: Matches, config: RecognizerConfig) -> Candidates:
    """Candidates of every component of a target, in the model's order."""
    return candidates_of_roles(Roles.of(target, shape_of), matches, config)


def candidates_of_roles(roles: Roles, matches: Matches, config: RecognizerConfig) -> Candidates:
    """Candidates of every component of a target, in the model's order."""
    return (_of_roles_compiled if COMPILED else _of_roles)(roles, matches, config)


def _of_roles_compiled(roles: Roles, matches: Matches, config: RecognizerConfig) -> Candidates:
    noise = config.contour_noise_px, config.model_noise
    shapes = pack_shapes(tuple(matches.shapes))
    p, marker, *values = candidates(matches.packed, roles.packed, shapes, config.symmetry_px, *noise)
    return Candidates(roles, p.component, marker, p.key, p.match, Poses(*p[:7]), *values)


def _of_roles(roles: Roles, matches: Matches, config: RecognizerConfig) -> Candidates:
    placed = matches.placed
    fits = (placed.shape == roles.shape[:, None]) & (matches.labels == roles.label[:, None])  # (K, instances)
    role, match = np.nonzero(fits)
    residual = np.stack([s.symmetry.residual_m for s in matches.shapes])[placed.shape[match]]  # (n, orders)
    same = residual * placed.scale[match][:, None] <= config.symmetry_px
    order = np.where(same[:, 0], ANY_ANGLE, same.shape[1] - 1 - same[:, ::-1].argmax(axis=1))
    turns = np.maximum(order, 1)
    row = np.repeat(np.arange(len(role)), turns)
    turn = np.arange(len(row)) - np.repeat(np.cumsum(turns) - turns, turns)
    role, match, order = role[row], match[row], order[row]
    axis = np.exp(1j * roles.axis_angle[role])
    theta = np.angle(placed.z[match] * axis + placed.w[match] * np.conj(axis))
    theta = wrap_angle(theta + 2 * np.pi * turn / turns[row])
    poses = _poses(matches, match, theta, order != ANY_ANGLE, config)
    score = placed.score[match]
    share, weight = matches.evidence.share[match], score * matches.perimeter_px[match]
    return Candidates(roles, roles.component[role], roles.marker[role], role, match, poses, share, score, weight)


def _poses(
    matches: Matches, match: NDArray[np.int64], theta: Array, directed: NDArray[np.bool_], config: RecognizerConfig
) -> Poses:
    """Noise: a contour's place, and what a flat rigid model leaves out (lens, slant, tolerance of make)."""
    t, scale = matches.placed.t[match], matches.placed.scale[match]
    radius_px = np.array([s.rms_radius_m for s in matches.shapes])[matches.placed.shape[match]] * scale
    place = np.hypot(config.contour_noise_px, config.model_noise * radius_px)
    relative = place / np.maximum(radius_px, 1e-9)
    return Poses(t.real, t.imag, theta, scale, place, np.where(directed, relative, np.pi), relative)


@dataclass(frozen=True)
class PairTable:
    """How two lists of candidates go together: (a, b) arrays.

    :param forbidden: cannot be in one object: same component, same pixels, unlike scales.
    :param checked: a constraint relates the two, and nothing forbids them.
    :param violation: by how much the worst dimension lies outside, in widths of what is allowed; 0: satisfied.
    """

    forbidden: NDArray[np.bool_]
    checked: NDArray[np.bool_]
    violation: Array


def pair_table(
    all_: Candidates, rows: NDArray[np.int64], columns: NDArray[np.int64], overlap: Array, config: RecognizerConfig
) -> PairTable:
    """Check every pair of candidates `rows` x `columns`: O(1) a pair (paper, step 8).

    :param overlap: `Matches.overlap`.
    """
    if COMPILED:
        limits = (config.max_group_overlap, config.max_scale_ratio)
        table = compiled.check_pairs(all_.packed, rows, columns, all_.roles.boxes, overlap, *limits, False)
        return PairTable(*table)
    a, b = all_.take(rows), all_.take(columns)
    ratio = np.abs(np.log(a.poses.scale[:, None] / b.poses.scale[None]))
    forbidden = (a.component[:, None] == b.component[None]) | (ratio > np.log(config.max_scale_ratio))
    forbidden |= overlap[np.ix_(a.match, b.match)] > config.max_group_overlap
    checked = all_.roles.boxes.pair[np.ix_(a.role, b.role)] >= 0
    violation = np.zeros(forbidden.shape)
    constraints = all_.target.constraints
    for p in constraints.pairs if isinstance(constraints, ConstraintSet) else ():
        for first, second, swap in ((p.first, p.second, False), (p.second, p.first, True)):
            i, j = _of_key(a, first), _of_key(b, second)
            if len(i) and len(j):
                left, right = a.poses.at(i).at((slice(None), None)), b.poses.at(j).at((None, slice(None)))
                pair = (right, left) if swap else (left, right)
                violation[np.ix_(i, j)] = _worst(p, violations(p, *pair, config))
    return PairTable(forbidden, checked & ~forbidden, np.where(forbidden, 0.0, violation))


def _of_key(c: Candidates, key: tuple[str, str]) -> NDArray[np.int64]:
    names = [component.name for component in c.target.model.components]
    component = names.index(key[0])
    markers = [m.name for m in c.target.model.components[component].markers]
    return np.flatnonzero((c.component == component) & (c.marker == markers.index(key[1])))


def violations(p: PairConstraint, first: Poses, second: Poses, config: RecognizerConfig) -> dict[str, Array]:
    """Per dimension, by how much T_ij lies outside what is allowed beyond twice its noise; 0 inside."""
    T = configuration(first, second)
    noise = configuration_noise(first, second, T)
    return {d: np.maximum(interval.excess(T[d]) - 2 * noise[d], 0.0) for d, interval in p.allowed.items() if d in noise}


def _worst(p: PairConstraint, outside: dict[str, Array]) -> Array:
    """The greatest excess in comparable units: radians, shares of a ratio, shares of the pair's greatest length."""
    scaled = [v / reach_m(p) if d.endswith("_m") else v for d, v in outside.items()]
    return np.max(np.stack(np.broadcast_arrays(*scaled)), axis=0)
