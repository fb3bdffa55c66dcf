"""What a claim must have to be an object, and how far it is trusted."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..image.label_field import LabelField
from ..pose.finder import WholeObjectFinder
from ..pose.poses import Poses
from .acceptance import verdicts_of
from .claims import Claim, Seen, claims_of, swollen
from .reach import Reach
from .verdicts import CASES, Verdict, Verdicts

_LEAST = 1e-3  # who shows no identity comes last, but may be there
NO_DIRECTION = "nothing but one component is seen, a disc, which tells no direction"
_WITHOUT_REQUIRED = np.array([case.startswith(("unseen", "faded")) for case in CASES])


@dataclass(frozen=True)
class Judge:
    """The thresholds of `RecognizerConfig`.

    :param min_votes: least votes of a claim. :param min_probability: least probability of an object.
    :param min_components: least components that the labels confirm; no more than there are.
    :param reach: where objects are looked for.
    :param least_known: the same of one that is known from frames before.
    :param unseen: whether an object whose required component cannot be seen is told. Its pixels it owns in any case:
        they are no other's.
    :param little: `Evidence.missing` of what lacks no more than a small blob.
    :param asked: what `trust_and_place` was asked before, of one frame; None: it does not note it.
    """

    min_votes: float
    min_probability: float
    min_components: int = 0
    reach: Reach = Reach()
    unseen: bool = False
    least_known: float = 0.0
    little: float = 0.0
    asked: dict[tuple[int, int, bytes], tuple[LabelField, tuple[float, bool]]] | None = None

    @classmethod
    def of(cls, config: RecognizerConfig) -> Judge:
        return cls(
            config.verdict.min_votes,
            config.min_probability,
            config.min_components,
            Reach.of(config),
            config.required == "visible",
            min(config.verdict.least_known, config.min_probability),
            math.log1p(config.guesses.small_px),
        )

    @property
    def lenient(self) -> Judge:
        """The same of candidates for what is known from frames before."""
        return replace(self, min_probability=self.least_known, asked=None)

    @property
    def seeking(self) -> Judge:
        """The same before all is known: a second look may find components that an object lacks at first."""
        return replace(self, min_components=0)

    def wanted(self, components: int) -> int:
        """Of so many components how many are to be there."""
        return min(self.min_components, components)

    def is_complete(self, verdict: Verdict) -> bool:
        """Whether an object lacks nothing to speak of: what does may be another one, which has it."""
        return -verdict.evidence.missing <= self.little

    def verdicts(
        self, finder: WholeObjectFinder, poses: Poses, frame: ImageFrame, seen: Seen | None = None
    ) -> Verdicts:
        """What the labels confirm of each hypothesis. :param seen: what is known of them."""
        return verdicts_of(claims_of(finder, poses, frame, seen))

    def worth(self, verdicts: Verdicts) -> Array:
        """(H,) trusted votes of each claim; 0: it is no object. -inf: it has not votes enough to stand at all."""
        out, objects = np.where(self.may_stand(verdicts), 0.0, -np.inf), np.flatnonzero(self.accepts(verdicts))
        if len(objects):
            out[objects] = _trust(verdicts, objects) * verdicts.claims.votes[objects]
        return out

    def swollen(self, verdicts: Verdicts) -> Iterator[tuple[Verdicts, Array, float]]:
        """Verdicts on the same claims with markers that look larger than they are, their trusted votes (H,) so, and how
        much larger, pixels: for each of `WholeObjectFinder.swollen`. 0 where the scale is known: there nothing is
        mistaken. Chance bears out as many times as easily what may be of one of several sizes."""
        claims = verdicts.claims
        finder = claims.finder
        unknown = claims.known > math.log(finder.config.facing.scale_ratio)
        may_be = unknown & self.may_stand(verdicts)
        for larger in finder.swollen if may_be.any() else ():
            again = verdicts_of(swollen(claims, larger), 1 + len(finder.swollen))
            again = replace(again, claims=replace(again.claims, finder=finder))
            worth = np.where(may_be, np.maximum(self.worth(again), 0.0), 0.0)
            yield again, worth, larger.surface.limits.swollen_px

    def may_stand(self, verdicts: Verdicts) -> NDArray[np.bool_]:
        """(H,) whether each claim has votes enough."""
        return np.asarray(verdicts.claims.votes >= self.min_votes)

    def accepts(self, verdicts: Verdicts) -> NDArray[np.bool_]:
        """(H,) whether each claim is an object, be it one that is not told (`tells`)."""
        claims, confirmed = verdicts.claims, verdicts.confirmed
        wanted = self.wanted(confirmed.shape[1])
        enough = self.may_stand(verdicts) & (verdicts.probability >= self.min_probability)
        # or it cannot be seen: that is no matter here
        shown = (verdicts.required_shown | _WITHOUT_REQUIRED[verdicts.case]) & (confirmed.sum(axis=1) >= wanted)
        held = self.reach.holds(claims.depth_m, claims.scale) & np.array([m is None for m in claims.misplaced], bool)
        return np.asarray(enough & shown & held & verdicts.has_direction & verdicts.is_free)

    def lacks_components(self, verdict: Verdict) -> bool:
        """Whether fewer of its components are confirmed than are wanted."""
        return sum(verdict.confirmed) < self.wanted(len(verdict.confirmed))

    def shows_required(self, verdict: Verdict) -> bool:
        """Whether a claim's required component is confirmed, or cannot be seen where that is no matter."""
        return verdict.required_shown or bool(self.unseen and _WITHOUT_REQUIRED[verdict.among.case[verdict.row]])

    def tells(self, verdict: Verdict) -> bool:
        """Whether an object is told, and does not only own its pixels: its required component is seen, and what is
        taken for it is none of the others."""
        return self.shows_required(verdict) and verdict.stand_in is None

    def trust_in(self, finder: WholeObjectFinder, poses: Poses, frame: ImageFrame) -> float:
        """What the first one's votes count, 0 to 1; 0: there is none, or it is no object."""
        return self.trust_and_place(finder, poses, frame)[0]

    def trust_and_place(self, finder: WholeObjectFinder, poses: Poses, frame: ImageFrame) -> tuple[float, bool]:
        """The same, and whether its required component has a place: where it is seen and the labels speak against its
        outline, it may lie across other ones, of an object whose own is elsewhere."""
        if not len(poses):
            return 0.0, False
        one, asked = poses[:1], {} if self.asked is None else self.asked
        key = id(finder), id(frame.field), b"".join(values.tobytes() for values in (one.R, one.t, one.q))
        if key not in asked:
            verdict = self.verdicts(finder, one, frame)[0]
            placed = not verdict.confirmed[finder.root] or verdict.evidence.rim >= 0
            asked[key] = frame.field, (self.trust(verdict), placed)  # while the field is there none else has its number
        return asked[key][1]

    def in_one_frame(self) -> Judge:
        """The same, that knows what it was asked before: a hypothesis is, where it is found, and where it is taken."""
        return replace(self, asked={})

    def trust(self, verdict: Verdict) -> float:
        """What a claim's votes count, 0 to 1; 0: it is no object."""
        return float(_trust(verdict.among, np.array([verdict.row]))[0]) if self._objection(verdict) is None else 0.0

    def reason(self, verdict: Verdict) -> str | None:
        """Why a claim is not told as an object; None where it is."""
        objection = self._objection(verdict)
        if objection is None and verdict.stand_in is not None:
            return f"what would be its required component looks more like {verdict.stand_in}"
        return objection

    def is_but_improbable(self, verdict: Verdict) -> bool:
        """Whether a claim is told as an object, or would be but for its probability."""
        return replace(self, min_probability=0.0, asked=None).reason(verdict) is None

    def doubts(self, verdict: Verdict) -> bool:
        """Whether an object is not told for it is not probable enough, and for nothing else, but may be one that is
        known from frames before."""
        return self.is_low(verdict.probability) and self.lenient.reason(verdict) is None

    def is_low(self, probability: float) -> bool:
        """Whether a probability is enough for what is known from frames before, but not alone."""
        return self.least_known <= probability < self.min_probability

    def _objection(self, verdict: Verdict) -> str | None:
        """Why a claim is no object, as far as that is known at once; None where it is one."""
        if verdict.claim.votes < self.min_votes:
            return f"{verdict.claim.votes:.0f} votes of the labels, {self.min_votes:.0f} are wanted"
        if not verdict.among.is_free[verdict.row]:
            return "almost all of it lies where others are found"
        if not self.shows_required(verdict):
            model, lack = verdict.claim.finder.surface.model, verdict.without_required
            if len(model.components) == 1 and not lack:
                return _too_little(verdict.claim)
            required = model.required.name
            return f"where it would be, its required component {required} {lack or 'is not confirmed'}"
        out_of_reach = self.reach.reason(verdict.claim.depth_m, verdict.claim.scale)
        if out_of_reach is not None:
            return out_of_reach
        if verdict.claim.misplaced is not None:
            return verdict.claim.misplaced
        confirmed, wanted = sum(verdict.confirmed), self.wanted(len(verdict.confirmed))
        if confirmed < wanted:
            return f"{confirmed} of its components confirmed, {wanted} are wanted"
        if not verdict.among.has_direction[verdict.row]:
            return NO_DIRECTION
        if verdict.probability < self.min_probability:
            return too_low(verdict.probability, self.min_probability, verdict.doubt)
        return None


def _too_little(claim: Claim) -> str:
    """Why an object of one component is none of which nothing else is to be said."""
    markers = claim.finder.surface.markers
    area_px, agree = claim.scores.area_px[0, markers], claim.scores.agree[0, markers]
    best = int(np.argmax(area_px * agree))
    return f"too little of its marker shows: {area_px[best]:.0f} pixels in the image, {agree[best]:.0%} of its class"


def too_low(probability: float, least: float, doubt: str, by: str = "") -> str:
    """Why what is less probable than an object must be is none. :param doubt: what speaks against it, or what may yet
    speak for it. :param by: what the probability is told by, where it is not the image alone."""
    told = math.floor(100 * probability) / 100  # rounded up it might be what is wanted
    return f"probability {told:.2f}{by} is below {least:g}: {doubt}"


def _trust(verdicts: Verdicts, rows: NDArray[np.int64]) -> Array:
    """(n,) what the votes of some count if these are objects: less where their components show no identity that
    exists."""
    claims = verdicts.claims
    shown = 1 - claims.contradicted(rows) / np.maximum(claims.votes[rows], 1.0)
    return np.asarray(verdicts.probability[rows] * np.minimum(np.maximum(shown, _LEAST), 1.0))
