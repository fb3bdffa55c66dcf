"""Which claims are objects: a probability from what the labels confirm, and a reason where it is too low.

The probability is that of an additive logistic model: each kind of evidence adds what its curve says, a line through a
few points that never falls. Claims of which no other component should be in view, of which none is confirmed, and of
which some are, have a model each. The curves are fitted on objects made up at random, and how well the probability is
calibrated is measured on others (`benchmarks/acceptance.py`).
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..pose.surface_model import PatchScores
from . import acceptance_curves, facing_curves
from .acceptance_curves import Model
from .claims import Claim

_Scores = tuple[list[float], list[float], list[float]]  # of each patch


class Evidence(NamedTuple):
    """What speaks for a claim; the more of each, the likelier it is an object.

    :param size: logarithm of all its votes: much is seldom alike by chance.
    :param edge: how well the required marker's outline parts its class from others: 1 all around, 0 or less nowhere.
    :param bare: 1 where no body of the required component that has a class is in view: none can speak for it.
    :param body: mean vote of the required component's bodies in view, which are around its marker; -2 where it is bare.
    :param shown: other components that something shows, be it too little to confirm them.
    :param colour: mean vote of the pixels of all markers that should be in view.
    :param others: the same of the other components' alone.
    :param edges: `edge` of the confirmed other components, the longer outlines counting more; 0 without.
    :param faces: the same of all components' bodies.
    :param facing: cosine of the angle under which the required marker is seen: squeezed, much looks like it.
    :param missing: less the logarithm of the pixels of markers that should be in view and are not confirmed.
    :param lacking: less the share of the pixels of all markers that should be in view whose components are not
        confirmed.
    """

    size: float
    edge: float
    bare: float
    body: float
    shown: float
    colour: float
    others: float
    edges: float
    faces: float
    facing: float
    missing: float
    lacking: float


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
        curves = facing_curves if self.claim.finder.facing else acceptance_curves
        return logistic(curves.CURVES[self.case], self.evidence)

    @property
    def case(self) -> str:
        """The model that holds for it: 'borne out' where other components are confirmed, 'deserted' where none is that
        should be in view, 'alone' where none should be."""
        if self.others:
            return "borne out"
        (_, area_px, _), least_px = self._scores, self.claim.finder.config.min_blob_px
        seen = any(area_px[p] > least_px for _, mine in self._others_markers() for p in mine)
        return "deserted" if seen else "alone"

    @cached_property
    def evidence(self) -> Evidence:
        """What speaks for it."""
        finder, (votes, area_px, _) = self.claim.finder, self._scores
        surface, root = finder.surface, self.shown[finder.root]
        faces = [p for p in surface.classed_faces if area_px[p]]
        body = [p for p in faces if surface.patches[p].component == finder.root]
        others = [p for _, mine in self._others_markers() for p in mine]
        all_markers = [*surface.markers_of[finder.root], *others]
        missing_px = sum(area_px[p] for c, mine in self._others_markers() if not self.confirmed[c] for p in mine)
        outlines = [self.outline(self.shown[c]) for c in self.others]

        def mean_vote(patches: list[int]) -> float:
            return sum(votes[p] for p in patches) / max(sum(area_px[p] for p in patches), 1.0)

        def mean_face(patches: list[int]) -> float:
            return mean_vote(patches) if patches else surface.votes.body[2]

        return Evidence(
            size=math.log(max(self.claim.votes, 1.0)),
            edge=self.outline(root)[0],
            bare=float(not body),
            body=mean_face(body),
            shown=float(sum(patch >= 0 for patch in self.shown) - 1),
            colour=mean_vote(all_markers),
            others=mean_vote(others),
            edges=sum(fit * px for fit, px in outlines) / max(sum(px for _, px in outlines), 1e-9),
            faces=mean_face(faces),
            facing=self._facing(),
            missing=-math.log1p(missing_px),
            lacking=-missing_px / max(sum(area_px[p] for p in all_markers), 1.0),
        )

    @cached_property
    def _scores(self) -> _Scores:
        """Of each patch its votes, pixels and the share of them with its label."""
        return _lists(self.claim.scores)

    def _others_markers(self) -> Iterator[tuple[int, list[int]]]:
        """Components besides the required one, each with its markers' patches."""
        finder = self.claim.finder
        return ((c, mine) for c, mine in enumerate(finder.surface.markers_of) if c != finder.root)

    def outline(self, patch: int) -> tuple[float, float]:
        """How well a marker's outline parts its class from others, 1 all around, 0 or less nowhere; its length, px."""
        (votes, area_px, agree), marker = self._scores, self.claim.finder.surface.patches[patch].marker
        assert marker is not None  # what shows a component is a marker
        perimeter_px = marker.perimeter * math.sqrt(max(area_px[patch], 1e-9) / marker.area)
        v = self.claim.finder.surface.votes
        inside = v.inside[0] * agree[patch] * area_px[patch]
        around = (v.rim[0] + v.ring[2]) * v.ring_width_px * perimeter_px
        return (votes[patch] - inside) / max(around, 1e-12), perimeter_px  # nothing, where outlines do not vote

    def _facing(self) -> float:
        finder, poses = self.claim.finder, self.claim.poses
        surface, patch = finder.surface, self.shown[finder.root]
        frames = surface.kinematics.forward(poses.R, poses.t, poses.q)
        R, t = frames.R[0, finder.root], frames.t[0, finder.root]
        centre = R @ surface.centre[patch] + t
        return float(-(R @ surface.normal[patch]) @ centre / max(float(np.linalg.norm(centre)), 1e-9))

    @property
    def doubt(self) -> str:
        """What speaks against a claim: what is not confirmed of it."""
        if self.case == "alone":
            return f"its outline fits by {self.evidence.edge:.2f}, and no other component should be in view"
        root, names = self.claim.finder.root, [c.name for c in self.claim.finder.surface.model.components]
        seen = [names[c] for c in self.others]
        missing = (c for c in range(len(names)) if c not in self.others and c != root)
        nearest = max(missing, key=lambda c: self.marker_votes[c], default=None)
        text = f"confirmed {', '.join(seen)}" if seen else "no other component confirmed"
        if nearest is not None:
            text += f"; nearest to it {names[nearest]} with {self.marker_votes[nearest]:.0f} votes"
        return text


def logistic(model: Model, evidence: NamedTuple) -> float:
    """The probability from what each kind of evidence adds."""
    bias, curves = model
    logit = bias + sum(_at(getattr(evidence, name), *curve) for name, curve in curves.items())
    return 1 / (1 + math.exp(min(-logit, 700.0)))


def _lists(scores: PatchScores) -> _Scores:
    """A handful of numbers: plain Python is faster than arrays."""
    votes, area_px, agree = (values[0].tolist() for values in scores.arrays)
    return votes, area_px, agree


def _at(x: float, xs: Sequence[float], ys: Sequence[float]) -> float:
    """A line through points at x, level beyond its ends."""
    i = bisect_right(xs, x)
    if i in (0, len(xs)):
        return ys[0 if i == 0 else -1]
    return ys[i - 1] + (ys[i] - ys[i - 1]) * (x - xs[i - 1]) / (xs[i] - xs[i - 1])


def verdict_of(claim: Claim) -> Verdict:
    """Which components the labels confirm, and by which marker."""
    surface, config = claim.finder.surface, claim.finder.config
    supported = set(surface.markers[claim.finder.supported(claim.scores)[0]].tolist())
    patch_votes, area_px, agree = _lists(claim.scores)
    thin_px = 2 * (surface.votes.ring_px + surface.votes.ring_width_px)
    votes, shown, confirmed = [], [], []
    for c, mine in enumerate(surface.markers_of):
        votes.append(sum(patch_votes[p] for p in mine))
        best = max(mine, key=lambda p: area_px[p] * ((p in supported) + 1e-3))
        confirmed.append(best in supported)
        sure = best in supported or c == claim.finder.root
        told = votes[c] > 0 and agree[best] > config.verdict.told_agree and area_px[best] > config.min_blob_px
        # a wider one has room for what would confirm it between the seams on its two sides
        shown.append(best if sure or (told and claim.width_px(best) < thin_px) else -1)
    return Verdict(claim, tuple(shown), tuple(confirmed), tuple(votes))
