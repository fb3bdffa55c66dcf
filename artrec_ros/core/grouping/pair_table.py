"""Candidates checked in pairs, and those kept that matter to a possible object (paper, step 8)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..constraints.pair_kernels import check_pairs
from ..geometry.transforms import Array
from .candidate_kernels import relate
from .candidates import Candidates


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


def pair_table(all_: Candidates, overlap: Array, config: RecognizerConfig) -> PairTable:
    """Check every pair of candidates: O(1) a pair (paper, step 8).

    :param overlap: `Matches.overlap`.
    """
    everyone = np.arange(len(all_))
    limits = (config.grouping.max_group_overlap, config.grouping.max_scale_ratio)
    return PairTable(*check_pairs(all_.packed, everyone, everyone, all_.roles.boxes, overlap, *limits, True))


def relevant(
    all_: Candidates, required: int, overlap: Array, config: RecognizerConfig
) -> tuple[NDArray[np.int64], Candidates, PairTable]:
    """Seeds, and of the other candidates those that go with one of them, all checked in pairs.

    Each seed's nearest miss of every component is kept too, to say why it is one.
    """
    limits = (config.grouping.max_group_overlap, config.grouping.max_scale_ratio, config.grouping.max_partners)
    kept, seeds, *table = relate(all_.packed, all_.weight, required, all_.roles.boxes, overlap, *limits)
    return np.arange(seeds), all_.take(kept), PairTable(*table)
