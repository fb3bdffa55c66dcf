"""What is confirmed of claims, how probable that makes each an object, and what speaks against it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..pose.at_scale import OffScale
from ..pose.finder import WholeObjectFinder
from ..pose.poses import Poses
from .claims import Claim, Claims
from .evidence import Evidence

# as evidence_kernels.py numbers them; then the same in images with colours, as far as these have curves of their own
SHOWN = "alone", "deserted", "borne out"
_OF_LABELS = *SHOWN, "unseen", "faded", *(f"{why}, {case}" for why in ("unseen", "faded") for case in SHOWN)
CASES = (*_OF_LABELS, *(f"{case} in colour" for case in _OF_LABELS))
_BORNE_OUT = np.array([case.startswith("borne out") for case in CASES])
# nothing but one component of a rigid body is seen: each of them could be taken for it by chance
ONE_OF_ITS_BODY = np.array([", alone" in case or ", deserted" in case for case in CASES])
_TIMES = 2.0  # as easily borne out by chance: half of the odds are gone then


@dataclass(frozen=True, eq=False)
class Verdicts:
    """What is confirmed of H claims, and how probable each is.

    :param shown, confirmed, marker_votes, outline, parted: (H, C), as of `Verdict`.
    :param case: (H,) index into `CASES`.
    :param evidence: (H, columns) `Evidence`. :param times: (H,) how many times as easily chance bears it out because
        its components look alike. :param probability: (H,)
    :param off_scale: what their sizes say of those that may be objects.
    """

    claims: Claims
    shown: Array
    confirmed: Array
    marker_votes: Array
    outline: Array
    parted: Array
    case: Array
    evidence: Array
    times: Array
    probability: Array
    off_scale: OffScale

    def __len__(self) -> int:
        return len(self.probability)

    @cached_property
    def has_direction(self) -> NDArray[np.bool_]:
        """(H,) whether something tells a direction of what faces the camera: where its required component is a disc two
        components must be confirmed, or one that is none; or beside the required one all others together speak for it,
        as dots of few pixels do."""
        claims = self.claims
        finder, surface = claims.finder, claims.finder.surface
        if not (finder.facing and finder.target.model.needs_another):
            return np.ones(len(claims), bool)
        confirmed = np.asarray(self.confirmed, bool)
        discs = np.array([c.is_disc for c in finder.target.model.components])
        told = (confirmed & ~discs).any(axis=1) | (confirmed.sum(axis=1) > 1)
        around = surface.markers[surface.component[surface.markers] != finder.root]
        return np.asarray(told | (confirmed[:, finder.root] & (claims.scores.votes[:, around].sum(axis=1) > 0)))

    @cached_property
    def is_free(self) -> NDArray[np.bool_]:
        """(H,) whether enough of each is nobody else's: what others leave of their rims is no object."""
        claims, m = self.claims, self.claims.finder.surface.marker_columns
        free_px, full_px = (px[:, m].sum(axis=1) for px in (claims.scores.area_px, claims.seen.full_px))
        return np.asarray(free_px >= claims.finder.config.verdict.least_free * full_px)

    @cached_property
    def required_shown(self) -> NDArray[np.bool_]:
        """(H,) whether the required component is confirmed, or others are, and it shows too little to be so, as where
        something unknown lies over part of it, but what it shows speaks for it."""
        finder, root = self.claims.finder, self.claims.finder.root
        agree = self.claims.scores.agree[np.arange(len(self)), np.maximum(self.shown[:, root], 0)]
        speaks = (self.marker_votes[:, root] > 0) & (agree > finder.config.verdict.told_agree)
        return np.asarray(self.confirmed[:, root].astype(bool) | (speaks & _BORNE_OUT[self.case]))

    def __getitem__(self, row: int) -> Verdict:
        return Verdict(self, range(len(self))[row])

    def __iter__(self) -> Iterator[Verdict]:
        return (self[row] for row in range(len(self)))


@dataclass(frozen=True, eq=False)
class Verdict:
    """What is confirmed of one of them.

    :param owners: objects whose pixels said nothing of it. :param alone: its probability if nobody owned any.
    :param wider_px: how much larger than they are its markers look, pixels.
    """

    among: Verdicts
    row: int
    owners: tuple[Verdict, ...] = field(default=(), repr=False)
    alone: float = 1.0
    wider_px: float = 0.0

    @cached_property
    def claim(self) -> Claim:
        """What it is about."""
        return self.among.claims[self.row]

    @property
    def finder(self) -> WholeObjectFinder:
        """The claim's."""
        return self.among.claims.finder

    @property
    def poses(self) -> Poses:
        """The claim's one hypothesis."""
        return self.among.claims.poses[self.row : self.row + 1]

    @property
    def votes(self) -> float:
        """The claim's."""
        return float(self.among.claims.votes[self.row])

    @cached_property
    def shown(self) -> tuple[int, ...]:
        """Per component the index into the surface's patches of the marker that shows it, -1 where none does."""
        return tuple(self.among.shown[self.row].tolist())

    @cached_property
    def confirmed(self) -> tuple[bool, ...]:
        """Per component whether its labels say clearly that it is there."""
        return tuple(self.among.confirmed[self.row].tolist())

    @property
    def required_shown(self) -> bool:
        """Whether its required component is confirmed, or shows enough beside others that are."""
        return bool(self.among.required_shown[self.row])

    @property
    def marker_votes(self) -> tuple[float, ...]:
        """Votes of each component's markers."""
        return tuple(self.among.marker_votes[self.row].tolist())

    @property
    def outline(self) -> tuple[float, ...]:
        """Per component how well the outline of what shows it parts its class from others, 1 all around, 0 or less
        nowhere."""
        return tuple(self.among.outline[self.row].tolist())

    @property
    def parted(self) -> tuple[float, ...]:
        """Per component the share of that outline that does not lie amid the class that it shows."""
        return tuple(self.among.parted[self.row].tolist())

    @property
    def others(self) -> list[int]:
        """Confirmed components besides the required one."""
        return [c for c, yes in enumerate(self.confirmed) if yes and c != self.claim.finder.root]

    @cached_property
    def stand_in(self) -> str | None:
        """The component that explains better what is taken for the required one, where the object has one to spare:
        whatever the clock says."""
        claim, finder = self.claim, self.claim.finder
        patch, components = self.shown[finder.root], finder.surface.model.components
        if not self.confirmed[finder.root] or len(self.others) + 1 == len(components):
            return None
        scores = claim.scores.votes[0, patch], claim.scores.area_px[0, patch]
        found = finder.stand_ins.better(claim.frame.unhurried(), claim.poses, patch, *map(float, scores))
        return None if found is None else components[found].name

    @property
    def probability(self) -> float:
        """That the claim is an object, 0 to 1."""
        return float(self.among.probability[self.row])

    @property
    def case(self) -> str:
        """The model that holds for it: 'borne out' where other components are confirmed, 'deserted' where none is that
        should be in view, 'alone' where none should be, 'unseen' where others are confirmed and the required one is
        turned away, hidden or out of the image, 'faded' where it bears no labels though it should be seen, each also
        'unseen, alone' and so on, where another component of its rigid body is judged in its place; of what faces the
        camera each 'in colour', too, and in space 'alone': soft codes vote less clearly than labels."""
        return CASES[self.among.case[self.row]]

    @property
    def evidence(self) -> Evidence:
        """What speaks for it."""
        return Evidence(*self.among.evidence[self.row].tolist())

    @property
    def doubt(self) -> str:
        """What speaks against a claim: what is not confirmed of it."""
        fits = f"fits by {self.evidence.edge:.2f} (1: all around; below 0: its class goes on, or ends within)"
        if self.case.startswith("alone"):
            several = len(self.claim.finder.surface.model.components) > 1
            text = [f"its outline {fits}{', and no other component should be in view' if several else ''}"]
            return "; ".join([*text, *self._off_scale])
        root, names = self.claim.finder.root, [c.name for c in self.claim.finder.surface.model.components]
        seen = [names[c] for c in self.others]
        text = [f"confirmed {', '.join(seen)}" if seen else "no other component confirmed"]
        if self.without_required:
            text.append(f"its required component {names[root]} {self.without_required}")
        votes, scores, markers_of = self.marker_votes, self.claim.scores, self.claim.finder.surface.markers_of
        area_px = [float(scores.area_px[0, mine].sum()) for mine in markers_of]
        missing = (c for c in range(len(names)) if c not in self.others and c != root and area_px[c] > 0)
        nearest = max(missing, key=lambda c: votes[c], default=None)
        if nearest is not None:
            agree = float((scores.agree * scores.area_px)[0, markers_of[nearest]].sum()) / area_px[nearest]
            said = (
                f"{votes[nearest]:.0f} votes" if votes[nearest] <= -0.5 else f"its class on {agree:.0%} of its pixels"
            )
            text.append(f"nearest to it {names[nearest]} with {said}")
            if self.claim.finder.facing and not seen:  # of what one outline tells all is as wrong as that is
                text.append(f"limits of the scale, or the outline of {names[root]}, may be off")
        elif not self.without_required:
            text.append(f"the outline of {names[root]} {fits}")
        if self.among.times[self.row] > _TIMES:
            ways = np.exp(-self.evidence.distinct)
            text.append(f"what is confirmed looks like others of its components: some {ways:.2g} ways to lay it there")
        text += self._off_scale
        return "; ".join(text)

    @property
    def _off_scale(self) -> list[str]:
        """That it looks too large or too small, where that takes half of its odds and more."""
        odds, scale, limit = (float(column[self.row]) for column in self.among.off_scale)
        if odds <= math.log(_TIMES):
            return []
        bound = "most" if scale > limit else "least"
        return [f"its edges are those of an object of {scale:.3g} px/m, which may have {limit:.3g} at {bound} there"]

    @property
    def without_required(self) -> str:
        """Why its required component shows no labels, as far as that is known."""
        case = self.case
        return "is out of sight" if case.startswith("unseen") else "bears no labels" if case.startswith("faded") else ""
