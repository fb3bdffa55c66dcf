"""Which claims are objects: a probability from what the labels confirm, and a reason where it is too low."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .claims import Claim

# Logistic weights: constant; other components confirmed (at most two); their votes; the body's mean vote; all votes;
# how well the required marker's outline fits. Fitted to claims in rendered scenes of two kinds of objects, labels of
# two segmenters, each set with the same weight; then all were brought to scale (Platt 1999) on claims whose required
# component is confirmed.
_WEIGHTS = (-2.55, 1.2, 1.75, 3.3, 0.35, 1.4)
_COMPONENT_VOTES = 30.0  # about eight pixels of a marker
_OBJECT_VOTES = 300.0
_LEAST_PX = 8.0  # of a marker that could be recognised
# By hand, such claims are too few to learn from:
_LONE = 5.2  # what a lone marker's outline adds or takes, at ten times _OBJECT_VOTES, where nothing else could be seen
_LONE_EDGE = (0.0, 0.2, 0.6)  # fits of an outline that take all of it, say nothing, add all of it
_OUTGROWN = 3.5  # weight of an outline that does not end where its class does
_MISSING, _MISSING_PX = -0.26, 10.0  # weight of other markers that should be seen and are not confirmed
# A component of a found object is told where so much of its marker bears its label and the votes are not clearly
# against it; seen nearly edge-on it may be too thin to count as confirmed.
_TOLD_AGREE, _TOLD_VOTES = 0.2, -0.5  # share; votes per pixel


@dataclass(frozen=True, eq=False)
class Verdict:
    """What is confirmed of a claim.

    :param shown: per component the index into the surface's patches of the marker that shows it, -1 where none does.
    :param confirmed: per component whether its labels say clearly that it is there.
    :param marker_votes: votes of each component's markers.
    """

    claim: Claim
    shown: tuple[int, ...]
    confirmed: tuple[bool, ...]
    marker_votes: tuple[float, ...]

    @property
    def others(self) -> list[int]:
        """Confirmed components besides the required one."""
        return [c for c, yes in enumerate(self.confirmed) if yes and c != self.claim.finder.root]

    @cached_property
    def probability(self) -> float:
        """That the claim is an object, 0 to 1."""
        surface, scores = self.claim.finder.surface, self.claim.scores
        other_votes = sum(max(self.marker_votes[c], 0.0) for c in self.others)
        body_px = float(scores.area_px[0, surface.faces].sum())
        body = float(scores.votes[0, surface.faces].sum()) / max(body_px, 1.0)
        edge, size = self._edge_fit(), math.log(max(self.claim.votes, 1.0) / _OBJECT_VOTES)
        features = (
            1.0,
            min(len(self.others), 2),
            math.log1p(other_votes / _COMPONENT_VOTES),
            body,
            size,
            min(max(edge, -1.0), 1.0),
        )
        logit = sum(weight * feature for weight, feature in zip(_WEIGHTS, features, strict=True))
        logit += _OUTGROWN * min(max(edge, -1.0), 0.0)
        logit += _MISSING * math.log1p(self._missing_px() / _MISSING_PX)
        if not self._could_be_seen():
            large = min(max(size / math.log(10), 0.0), 1.0)
            logit += _LONE * float(np.interp(edge, _LONE_EDGE, (-1, 0, 1))) * large
        return 1 / (1 + math.exp(min(-logit, 700.0)))

    def _missing_px(self) -> float:
        """Pixels of other components' markers that should be in view and are not confirmed."""
        area_px = self.claim.scores.area_px[0].tolist()
        return sum(area_px[p] for c, mine in self._others_markers() if not self.confirmed[c] for p in mine)

    def _could_be_seen(self) -> bool:
        """Whether the marker of any other component should be in view."""
        area_px = self.claim.scores.area_px[0].tolist()
        return any(area_px[p] > _LEAST_PX for _, mine in self._others_markers() for p in mine)

    def _others_markers(self) -> Iterator[tuple[int, list[int]]]:
        """Components besides the required one, each with its markers' patches."""
        finder = self.claim.finder
        return ((c, mine) for c, mine in enumerate(finder.surface.markers_of) if c != finder.root)

    def _edge_fit(self) -> float:
        """How well the required marker's outline parts its class from others: 1 all around, 0 or less nowhere."""
        finder, scores = self.claim.finder, self.claim.scores
        shown = self.shown[finder.root]
        area_px, marker = float(scores.area_px[0, shown]), finder.surface.patches[shown].marker
        assert marker is not None  # what shows a component is a marker
        perimeter_px = marker.perimeter * math.sqrt(max(area_px, 1e-9) / marker.area)
        votes = finder.surface.votes
        inside = votes.inside[0] * scores.agree[0, shown] * area_px
        around = (votes.rim[0] + votes.ring[2]) * votes.ring_width_px * perimeter_px
        return float((scores.votes[0, shown] - inside) / max(around, 1e-12))  # nothing, where outlines do not vote

    @property
    def doubt(self) -> str:
        """What speaks against a claim: what is not confirmed of it."""
        if not self._could_be_seen():
            return f"its outline fits by {self._edge_fit():.2f}, and no other component should be in view"
        root, names = self.claim.finder.root, [c.name for c in self.claim.finder.surface.model.components]
        seen = [names[c] for c in self.others]
        missing = (c for c in range(len(names)) if c not in self.others and c != root)
        nearest = max(missing, key=lambda c: self.marker_votes[c], default=None)
        text = f"confirmed {', '.join(seen)}" if seen else "no other component confirmed"
        if nearest is not None:
            text += f"; nearest to it {names[nearest]} with {self.marker_votes[nearest]:.0f} votes"
        return text


def verdict_of(claim: Claim) -> Verdict:
    """Which components the labels confirm, and by which marker."""
    surface = claim.finder.surface
    # a handful of numbers: plain Python is faster than arrays
    supported = set(surface.markers[claim.finder.supported(claim.scores)[0]].tolist())
    patch_votes, area_px, agree = (values[0].tolist() for values in claim.scores.arrays)
    votes, shown, confirmed = [], [], []
    for c, mine in enumerate(surface.markers_of):
        votes.append(sum(patch_votes[p] for p in mine))
        best = max(mine, key=lambda p: area_px[p] * ((p in supported) + 1e-3))
        confirmed.append(best in supported)
        told = area_px[best] > _LEAST_PX and agree[best] > _TOLD_AGREE and votes[c] > _TOLD_VOTES * area_px[best]
        shown.append(best if best in supported or told or c == claim.finder.root else -1)
    return Verdict(claim, tuple(shown), tuple(confirmed), tuple(votes))
