"""What could be which component: instances assigned to components and checked in pairs (paper, steps 6 and 8)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .config import RecognizerConfig
from .constraints import ConstraintSet, PairConstraint, configuration
from .datatypes import Target
from .matching import Matches
from .symmetry import ANY_ANGLE
from .transforms import Array

ShapeOf = dict[tuple[str, str], int]  # (component, marker) -> number of its shape


@dataclass(frozen=True)
class Poses:
    """Where candidates lie: arrays of one length, units as in `Instance`, and the noise of theta (rad)."""

    x: Array
    y: Array
    theta: Array
    scale: Array
    theta_noise: Array

    def at(self, index: tuple[object, ...] | NDArray[np.int64]) -> Poses:
        return Poses(*(getattr(self, f)[index] for f in ("x", "y", "theta", "scale", "theta_noise")))


@dataclass(frozen=True)
class Candidates:
    """All (instance, component, marker, turn) of one target. An instance whose shape looks the same after a turn
    is a candidate in each of these directions: constraints tell which one it is.

    :param component: (n,) number of the component; marker: (n,) number of its marker.
    :param match: (n,) number of the instance in `Matches`.
    :param score: (n,) share of evidence; weight: (n,) contour explained, pixels.
    """

    target: Target
    component: NDArray[np.int64]
    marker: NDArray[np.int64]
    match: NDArray[np.int64]
    poses: Poses
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
            self.score[index],
            self.weight[index],
        )

    def key(self, n: int) -> tuple[str, str]:
        component = self.target.model.components[self.component[n]]
        return component.name, component.markers[self.marker[n]].name


def candidates_of(target: Target, shape_of: ShapeOf, matches: Matches, config: RecognizerConfig) -> Candidates:
    """Candidates of every component of a target, in the model's order."""
    rows: list[tuple[int, int, int, float, float]] = []  # component, marker, match, theta, theta noise
    for c, component in enumerate(target.model.components):
        label = target.label if component.label is None else component.label
        for m, marker in enumerate(component.markers):
            shape = shape_of[component.name, marker.name]
            for n in np.flatnonzero((matches.placed.shape == shape) & (matches.labels == label)):
                z = matches.placed.z[n]
                order = matches.shapes[shape].symmetry.order(abs(z), config.symmetry_px)
                noise = config.contour_noise_px / (matches.shapes[shape].rms_radius_m * abs(z))
                theta = float(np.angle(z)) + marker.axis_angle
                turns = [theta + 2 * np.pi * s / order for s in range(order)] if order != ANY_ANGLE else [theta]
                rows += [(c, m, int(n), a, np.pi if order == ANY_ANGLE else noise) for a in turns]
    table = np.array(rows, float).reshape(-1, 5)
    match = table[:, 2].astype(np.int64)
    t, scale = matches.placed.t[match], np.abs(matches.placed.z[match])
    theta = (table[:, 3] + np.pi) % (2 * np.pi) - np.pi
    score = matches.placed.score[match]
    return Candidates(
        target,
        table[:, 0].astype(np.int64),
        table[:, 1].astype(np.int64),
        match,
        Poses(t.real, t.imag, theta, scale, table[:, 4]),
        score,
        score * matches.perimeter_px[match],
    )


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
    k = np.sqrt(first.scale * second.scale)
    noise_px = np.sqrt(2.0) * config.contour_noise_px  # of the difference of two places
    place, bearing = noise_px / k, noise_px / np.maximum(T["distance_px"], 1e-6)
    theta_noise = np.hypot(first.theta_noise, second.theta_noise)
    noise = {
        "distance_m": place,
        "offset_x_m": place + T["distance_m"] * first.theta_noise,
        "offset_y_m": place + T["distance_m"] * first.theta_noise,
        "bearing_rad": np.hypot(first.theta_noise, bearing),
        "turn_rad": theta_noise,
        "scale_ratio": T["scale_ratio"] * theta_noise,  # a scale is known as well as a direction: noise over radius
    }
    return {d: np.maximum(interval.excess(T[d]) - 2 * noise[d], 0.0) for d, interval in p.allowed.items() if d in noise}


def _worst(p: PairConstraint, outside: dict[str, Array]) -> Array:
    """The greatest excess in comparable units: radians, shares of a ratio, shares of the pair's greatest length."""
    lengths = [i for d, i in p.allowed.items() if d.endswith("_m")]
    reach = max([abs(end) for i in lengths for end in (i.low, i.high)] + [1e-9])
    scaled = [v / reach if d.endswith("_m") else v for d, v in outside.items()]
    return np.max(np.stack(np.broadcast_arrays(*scaled)), axis=0)
