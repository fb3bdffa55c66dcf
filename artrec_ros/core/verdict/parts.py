"""Which components of an accepted object lie on their own markers: a probability of each from what labels say there.

An additive logistic model, as for whole objects (`acceptance.py`), fitted by the same program on the same worlds. That
a component is where the model says, and not on a sibling's pixels or on nothing, is asked of each one by itself.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

from ..geometry.transforms import Array
from ..pose.poses import Poses
from . import acceptance_curves, facing_curves
from .acceptance import packed
from .curve_kernels import Curves, probabilities
from .parts_kernels import shares_alone
from .verdicts import Verdict


class PartEvidence(NamedTuple):
    """What speaks for a component; the more of each, the likelier it is there.

    :param own: logarithm of its marker's pixels that bear its label, those of likelier siblings not counted.
    :param alone: share of its marker that does not lie on that of a likelier sibling of its class.
    :param open: share of its marker, as far as its own object lets it be seen, that no other object hides.
    :param agree: share of what is in view of it that bears its label. :param colour: mean vote there.
    :param edge: how well its outline parts its class from others.
    :param parted: share of its outline that does not lie amid its class.
    :param confirmed: 1 where the labels say clearly that it is there.
    :param whole: logarithm of the odds that the object is there.
    """

    own: float
    alone: float
    open: float
    agree: float
    colour: float
    edge: float
    parted: float
    confirmed: float
    whole: float


_MOST_ODDS = 7.0


def part_probabilities(verdicts: Sequence[Verdict]) -> list[dict[int, float]]:
    """Of each component that something shows of one target's objects, by its index, the probability that it lies on its
    own marker. The required one does where the object is there."""
    if not verdicts:
        return []
    finder, rows = verdicts[0].claim.finder, _rows(verdicts)
    out = np.empty(rows.shape[:2])
    flat = np.ascontiguousarray(rows.reshape(-1, rows.shape[2]))
    probabilities(_curves(finder.facing), np.zeros(len(flat), np.int64), flat, out.reshape(-1))
    out[:, finder.root] = [v.probability for v in verdicts]
    return [{c: float(out[h, c]) for c, patch in enumerate(v.shown) if patch >= 0} for h, v in enumerate(verdicts)]


def part_evidence(verdict: Verdict) -> dict[int, PartEvidence]:
    """Of each component that something shows, by its index: what benchmarks fit curves to."""
    rows = _rows([verdict])[0].tolist()
    return {c: PartEvidence(*rows[c]) for c, patch in enumerate(verdict.shown) if patch >= 0}


def _rows(verdicts: Sequence[Verdict]) -> Array:
    """(H, C, columns) `PartEvidence` of all components of one target's objects; only of those that something shows it
    says anything."""
    shown, claims = np.array([v.shown for v in verdicts]), [v.claim for v in verdicts]
    patch = np.maximum(shown, 0)
    scores, full_px = [claim.scores.arrays for claim in claims], np.array([claim.full_px for claim in claims])
    row = np.arange(len(claims))[:, None]
    votes, area_px, agree, full_px = (
        values[row, patch]
        for values in (*(np.concatenate([arrays[i] for arrays in scores]) for i in range(3)), full_px)
    )
    p = np.minimum(np.maximum([v.probability for v in verdicts], 1e-6), 1 - 1e-6)
    whole = np.minimum(np.maximum(np.log(p / (1 - p)), -_MOST_ODDS), _MOST_ODDS)
    alone = _alone(verdicts, shown)
    evidence = {
        "own": np.log1p(area_px * agree),
        "alone": alone,
        "open": np.minimum(area_px / np.maximum(full_px, 1e-9), 1.0),
        "agree": agree,
        "colour": votes / np.maximum(area_px, 1.0),
        "edge": np.array([v.outline for v in verdicts]),
        "parted": np.array([v.parted for v in verdicts]),
        "confirmed": np.array([v.confirmed for v in verdicts], float),
        "whole": np.repeat(whole[:, None], shown.shape[1], axis=1),
    }
    return np.stack([evidence[name] for name in PartEvidence._fields], axis=2)


def _alone(verdicts: Sequence[Verdict], shown: np.ndarray) -> Array:
    """(H, C) of what shows each component the share that is not on a sibling's of its class with more votes."""
    claims, surface = [v.claim for v in verdicts], verdicts[0].claim.finder.surface
    poses = Poses.concatenate([claim.poses for claim in claims])
    out, votes = np.empty(shown.shape), np.array([v.marker_votes for v in verdicts])
    shares_alone(
        surface.compiled, surface.kinematics.chain, claims[0].frame.view, poses.R, poses.t, poses.q, shown, votes,
        surface.alike, out,
    )  # fmt: skip
    return out


@cache
def _curves(facing: bool) -> Curves:
    return packed([(facing_curves if facing else acceptance_curves).PARTS], PartEvidence)
