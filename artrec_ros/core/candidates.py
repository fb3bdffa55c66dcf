"""What could be which component: instances assigned to components and checked in pairs (paper, steps 6 and 8)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .config import RecognizerConfig
from .constraints import ConstraintSet
from .datatypes import Target
from .matching import Matches
from .pairs import PairConstraint, configuration, configuration_noise
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

    def at(self, index: tuple[object, ...] | NDArray[np.int64]) -> Poses:
        return Poses(*(getattr(self, f)[index] for f in Poses.__dataclass_fields__))


@dataclass(frozen=True)
class Candidates:
    """All (instance, component, marker, turn) of one target. An instance whose shape looks the same after a turn
    is a candidate in each of these directions: constraints tell which one it is.

    :param component: (n,) number of the component; marker: (n,) number of its marker.
    :param match: (n,) number of the instance in `Matches`.
    :param share, score: (n,) as in `Evidence`; weight: (n,) contour explained, pixels.
    """

    target: Target
    component: NDArray[np.int64]
    marker: NDArray[np.int64]
    match: NDArray[np.int64]
    poses: Poses
    share: Array
    score: Array
    weight: Array

    def __len__(self) -> int:
        return len(self.component)

    def take(self, index: NDArray[np.int64]) -> Candidates:
        return Candidates(
            self.target,
            self.component[index],
            self.marker[index],
            self.match[index],
            self.poses.at(index),
            self.share[index],
            self.score[index],
            self.weight[index],
        )

    def key(self, n: int) -> tuple[str, str]:
        component = self.target.model.components[self.component[n]]
        return component.name, component.markers[self.marker[n]].name


def candidates_of(target: Target, shape_of: ShapeOf, matches: Matches, config: RecognizerConfig) -> Candidates:
    """Candidates of every component of a target, in the model's order."""
    rows: list[tuple[int, int, int, float, bool]] = []  # component, marker, match, theta, whether theta has meaning
    for c, component in enumerate(target.model.components):
        label = target.label if component.label is None else component.label
        for m, marker in enumerate(component.markers):
            shape = shape_of[component.name, marker.name]
            for n in np.flatnonzero((matches.placed.shape == shape) & (matches.labels == label)):
                k = float(matches.placed.scale[n])
                order = matches.shapes[shape].symmetry.order(k, config.symmetry_px)
                turns = 2 * np.pi * np.arange(max(order, 1)) / max(order, 1)
                theta = matches.axis_direction(int(n), marker.axis_angle)
                rows += [(c, m, int(n), theta + float(turn), order != ANY_ANGLE) for turn in turns]
    table = np.array(rows, float).reshape(-1, 5)
    match = table[:, 2].astype(np.int64)
    poses = _poses(matches, match, wrap_angle(table[:, 3]), table[:, 4] > 0, config)
    score = matches.placed.score[match]
    numbers = table[:, :2].astype(np.int64)
    share, weight = matches.evidence.share[match], score * matches.perimeter_px[match]
    return Candidates(target, numbers[:, 0], numbers[:, 1], match, poses, share, score, weight)


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
    :param checked: a constraint relates the two.
    :param violation: by how much the worst dimension lies outside, in widths of what is allowed; 0: satisfied.
    """

    forbidden: NDArray[np.bool_]
    checked: NDArray[np.bool_]
    violation: Array


def pair_table(
    all_: Candidates, rows: NDArray[np.int64], columns: NDArray[np.int64], matches: Matches, config: RecognizerConfig
) -> PairTable:
    """Check every pair of candidates `rows` x `columns`: O(1) a pair (paper, step 8)."""
    a, b = all_.take(rows), all_.take(columns)
    ratio = np.abs(np.log(a.poses.scale[:, None] / b.poses.scale[None]))
    forbidden = (a.component[:, None] == b.component[None]) | (ratio > np.log(config.max_scale_ratio))
    forbidden |= matches.overlap[np.ix_(a.match, b.match)] > config.max_group_overlap
    checked = np.zeros(forbidden.shape, bool)
    violation = np.zeros(forbidden.shape)
    constraints = all_.target.constraints
    for p in constraints.pairs if isinstance(constraints, ConstraintSet) else ():
        for first, second, swap in ((p.first, p.second, False), (p.second, p.first, True)):
            i, j = _of_key(a, first), _of_key(b, second)
            if len(i) and len(j):
                left, right = a.poses.at(i).at((slice(None), None)), b.poses.at(j).at((None, slice(None)))
                pair = (right, left) if swap else (left, right)
                worst = _worst(p, violations(p, *pair, config))
                checked[np.ix_(i, j)] = True
                violation[np.ix_(i, j)] = worst
    return PairTable(forbidden, checked, violation)


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
    lengths = [i for d, i in p.allowed.items() if d.endswith("_m")]
    reach = max([abs(end) for i in lengths for end in (i.low, i.high)] + [1e-9])
    scaled = [v / reach if d.endswith("_m") else v for d, v in outside.items()]
    return np.max(np.stack(np.broadcast_arrays(*scaled)), axis=0)
