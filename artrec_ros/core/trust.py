"""How far a group of the image plane can be trusted: the probability that all of it is right.

A logistic model of what the labels and the constraints confirm. Its weights were fitted on objects made up at random
among what looks like them (`benchmarks/calibration.py`), which also measures on others how well it is calibrated.
"""

from __future__ import annotations

import numpy as np

from .constraints import ConstraintSet
from .grouping import Group
from .transforms import Array

WEIGHTS = (-1.88, 2.01, 1.75, 1.04)
_MOST_EVIDENCE = 30.0


def probability(group: Group) -> float:
    """0 to 1."""
    return float(1 / (1 + np.exp(-features(group) @ np.array(WEIGHTS))))


def features(group: Group) -> Array:
    """(4,) what is confirmed: 1; how well outlines match on average; what constraints say against chance; the share
    of components that were found. Each in steps that matter."""
    c, members = group.candidates, list(group.members)
    match = np.clip(c.share[members], 0, 1)
    found = len(members) / len(c.target.model.components)
    told = np.log1p(evidence(group))
    return np.array([1.0, (match.mean() - 0.9) / 0.05, told, (found - 0.8) / 0.2])


def evidence(group: Group) -> float:
    """The logarithm of how seldom unrelated markers would satisfy the group's constraints by chance.

    Each constraint counts by the background model (`PairConstraint.chance`), so that constraints of different kinds
    compare; of the pairs of m components m - 1 are independent.
    """
    learned = group.candidates.target.constraints
    if not isinstance(learned, ConstraintSet) or not group.checked:
        return 0.0
    keys = {group.candidates.key(n) for n in group.members}
    weights = [-np.log(p.chance(learned.reach_m)) for p in learned.pairs if {p.first, p.second} <= keys]
    share = group.satisfied / group.checked
    return float(min(_MOST_EVIDENCE, (len(group.members) - 1) * np.mean(weights) * share)) if weights else 0.0
