"""Candidates checked in pairs, and those kept that matter to a possible object (paper, step 8)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .candidates import Candidates, Poses
from .compiled import pair_checks as compiled
from .compiled.candidacy import relate
from .compiled.jit import COMPILED
from .config import RecognizerConfig
from .constraints import ConstraintSet
from .pair_boxes import reach_m
from .pairs import PairConstraint, configuration, configuration_noise
from .transforms import Array

_MAX_PARTNERS = 500  # candidates that go with any seed of a target


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


def relevant(
    all_: Candidates, required: int, overlap: Array, config: RecognizerConfig
) -> tuple[NDArray[np.int64], Candidates, PairTable]:
    """Seeds, and of the other candidates those that go with one of them, all checked in pairs."""
    if COMPILED:
        limits = (config.max_group_overlap, config.max_scale_ratio, _MAX_PARTNERS)
        kept, seeds, *table = relate(all_.packed, all_.weight, required, all_.roles.boxes, overlap, *limits)
        return np.arange(seeds), all_.take(kept), PairTable(*table)
    seeds = np.flatnonzero(all_.component == required)
    others = np.flatnonzero(all_.component != required)
    with_seeds = pair_table(all_, seeds, others, overlap, config)
    near = np.asarray((~with_seeds.forbidden & (with_seeds.violation <= 0)).any(axis=0))
    miss = np.where(with_seeds.checked & ~with_seeds.forbidden, with_seeds.violation, np.inf)
    for component in np.unique(all_.component[others]):  # each seed's nearest miss, to say why it is one
        mine = np.flatnonzero(all_.component[others] == component)
        near[mine[miss[:, mine].argmin(axis=1)]] = True
    partners = others[near]
    partners = np.sort(partners[np.argsort(-all_.weight[partners], kind="stable")][:_MAX_PARTNERS])
    kept = np.concatenate([seeds, partners])
    candidates = all_.take(kept)
    everyone = np.arange(len(kept))
    return np.arange(len(seeds)), candidates, pair_table(candidates, everyone, everyone, overlap, config)
