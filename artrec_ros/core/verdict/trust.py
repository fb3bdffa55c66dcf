"""How far a group of the image plane can be trusted: the probability that all of it is right.

A logistic model of what the labels and the constraints confirm. Its weights were fitted on objects made up at random
among what looks like them (`benchmarks/calibration.py`), which also measures on others how well it is calibrated.
"""

from __future__ import annotations

import math

from ..constraints.constraint_set import ConstraintSet
from ..grouping.group_search import Group

WEIGHTS = (-1.88, 2.01, 1.75, 1.04)
_MOST_EVIDENCE = 30.0


def probability(group: Group) -> float:
    """0 to 1."""
    return 1 / (1 + math.exp(-sum(f * w for f, w in zip(features(group), WEIGHTS, strict=True))))


def features(group: Group) -> tuple[float, float, float, float]:
    """What is confirmed: 1; how well outlines match on average; what constraints say against chance; the share
    of components that were found. Each in steps that matter."""
    share, members = group.candidates.share, group.members
    match = sum(min(max(float(share[n]), 0.0), 1.0) for n in members) / len(members)
    found = len(members) / len(group.candidates.target.model.components)
    return 1.0, (match - 0.9) / 0.05, math.log1p(evidence(group)), (found - 0.8) / 0.2


def evidence(group: Group) -> float:
    """The logarithm of how seldom unrelated markers would satisfy the group's constraints by chance.

    Each constraint counts by the background model (`PairConstraint.chance`), so that constraints of different kinds
    compare; of the pairs of m components m - 1 are independent.
    """
    learned = group.candidates.target.constraints
    if not isinstance(learned, ConstraintSet) or not group.checked:
        return 0.0
    keys = {group.candidates.key(n) for n in group.members}
    told = [surprise for pair, surprise in learned.surprises if pair <= keys]
    share = group.satisfied / group.checked
    return min(_MOST_EVIDENCE, (len(group.members) - 1) * sum(told) / len(told) * share) if told else 0.0
