"""Which components of an accepted object lie on their own markers: a probability of each from what labels say there.

An additive logistic model, as for whole objects (`acceptance.py`), fitted by the same program on the same worlds. That
a component is where the model says, and not on a sibling's pixels or on nothing, is asked of each one by itself.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..geometry.projection import project
from ..model.surface import INSIDE_POINTS, contains
from . import acceptance_curves, facing_curves
from .acceptance import Verdict, logistic


class PartEvidence(NamedTuple):
    """What speaks for a component; the more of each, the likelier it is there.

    :param own: logarithm of its marker's pixels that bear its label, those of likelier siblings not counted.
    :param alone: share of its marker that does not lie on that of a likelier sibling of its class.
    :param open: share of its marker, as far as its own object lets it be seen, that no other object hides.
    :param agree: share of what is in view of it that bears its label. :param colour: mean vote there.
    :param edge: how well its outline parts its class from others.
    :param confirmed: 1 where the labels say clearly that it is there.
    :param whole: logarithm of the odds that the object is there.
    """

    own: float
    alone: float
    open: float
    agree: float
    colour: float
    edge: float
    confirmed: float
    whole: float


_MOST_ODDS = 7.0


def part_probabilities(verdict: Verdict) -> dict[int, float]:
    """Of each component that something shows, by its index, the probability that it lies on its own marker. The
    required one does where the object is there."""
    root = verdict.claim.finder.root
    rows = part_evidence(verdict)
    curves = facing_curves if verdict.claim.finder.facing else acceptance_curves
    return {c: verdict.probability if c == root else logistic(curves.PARTS, row) for c, row in rows.items()}


def part_evidence(verdict: Verdict) -> dict[int, PartEvidence]:
    """Of each component that something shows, by its index."""
    claim = verdict.claim
    shown = {c: patch for c, patch in enumerate(verdict.shown) if patch >= 0}
    votes, area_px, agree = (values[0].tolist() for values in claim.scores.arrays)
    alone, p = _alone(verdict, shown), min(max(verdict.probability, 1e-6), 1 - 1e-6)
    whole = min(max(math.log(p / (1 - p)), -_MOST_ODDS), _MOST_ODDS)
    return {
        c: PartEvidence(
            own=math.log1p(area_px[patch] * agree[patch] * alone[c]),
            alone=alone[c],
            open=min(area_px[patch] / max(float(claim.all_scores.area_px[0, patch]), 1e-9), 1.0),
            agree=agree[patch],
            colour=votes[patch] / max(area_px[patch], 1.0),
            edge=verdict.outline(patch)[0],
            confirmed=float(verdict.confirmed[c]),
            whole=whole,
        )
        for c, patch in shown.items()
    }


def _alone(verdict: Verdict, shown: dict[int, int]) -> dict[int, float]:
    """Of each component's marker the share that is not on a sibling's of its class with more votes."""
    claim, surface = verdict.claim, verdict.claim.finder.surface
    order = sorted(shown, key=lambda c: -verdict.marker_votes[c])
    out = dict.fromkeys(shown, 1.0)
    labels = [set(surface.patches[shown[c]].labels) for c in order]
    alike = np.array([[bool(a & b) for b in labels] for a in labels])
    if np.count_nonzero(alike) == len(order):
        return out
    rows = [int(np.searchsorted(surface.markers, shown[c])) for c in order]
    frames = surface.kinematics.forward(claim.poses.R, claim.poses.t, claim.poses.q)
    of_each = [(surface.patches[shown[c]].inside, surface.contour[r]) for c, r in zip(order, rows, strict=True)]
    points = np.concatenate([part for both in of_each for part in both])
    n = INSIDE_POINTS + surface.contour.shape[1]
    pixels = project(claim.frame.camera, surface.place(frames, points, np.repeat(order, n)))[0].reshape(-1, n, 2)
    inside, outline = pixels[:, :INSIDE_POINTS], pixels[:, INSIDE_POINTS:]
    low, high = outline.min(axis=1), outline.max(axis=1)
    for i, c in enumerate(order):
        before = alike[i, :i] & (low[:i] < high[i]).all(axis=1) & (high[:i] > low[i]).all(axis=1)
        covered = np.zeros(INSIDE_POINTS, bool)
        for j in np.flatnonzero(before):
            covered |= contains(outline[j], inside[i])
        out[c] = float(1 - covered.mean())
    return out
