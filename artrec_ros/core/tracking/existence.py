"""The probability that an object is there, carried on from frame to frame.

A recursive Bayes filter after the integrated probabilistic data association (Musicki, Evans and Stankovic, 1994, with
their object that exists and cannot be seen; Ristic et al., A tutorial on Bernoulli filters, 2013): an object is
there and can be seen, is there and cannot be seen, or is not there. What one frame says of it, `Detection.score`, is
alike in the next ones, light and clutter being the same: so what frames before say fades as more is said, and what
stands still is not believed more than one frame would have it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..base.config import ExistenceConfig
from ..geometry.transforms import Array
from .motion import Flags, Rows

_SUREST = 0.999  # what a probability is taken for at most, and 1 less it at least


@dataclass(frozen=True)
class Existence:
    """Of T objects. :param seen: (T,) probability that it is there and can be seen. :param hidden: there and cannot."""

    seen: Array
    hidden: Array

    def __getitem__(self, rows: Rows) -> Existence:
        return Existence(self.seen[rows], self.hidden[rows])

    @classmethod
    def of(cls, probability: Array) -> Existence:
        """In view, with these probabilities."""
        return cls(probability, np.zeros(len(probability)))

    @property
    def probability(self) -> Array:
        return self.seen + self.hidden

    def replaced(self, rows: Rows, probability: Array) -> Existence:
        """With some in view, with these probabilities."""
        seen, hidden = self.seen.copy(), self.hidden.copy()
        seen[rows], hidden[rows] = probability, 0.0
        return Existence(seen, hidden)

    @classmethod
    def joined(cls, parts: Sequence[Existence]) -> Existence:
        return cls(np.concatenate([p.seen for p in parts]), np.concatenate([p.hidden for p in parts]))

    def after(self, dt_s: float, config: ExistenceConfig) -> Existence:
        """A time later."""
        stay, hide, show = np.exp(-dt_s / np.array([config.stay_s, config.hide_s, config.show_s]))
        seen = stay * (hide * self.seen + (1 - show) * self.hidden)
        return Existence(seen, stay * self.probability - seen)

    def missed(self, could_be_seen: Array, config: ExistenceConfig) -> Existence:
        """Once a frame did not show them. :param could_be_seen: (T,) share of each that nothing known hides."""
        unseen = self.seen * (1 - config.detected * could_be_seen)
        total = unseen + self.hidden + 1 - self.probability
        return Existence(unseen / total, self.hidden / total)

    def times(self, share: float) -> Existence:
        return Existence(self.seen * share, self.hidden * share)

    def found(
        self, scores: Array, new: Array, age_s: Array, config: ExistenceConfig, elsewhere: Flags | None = None
    ) -> Existence:
        """Once a frame has said of each with what probability it is there.

        :param new: (T,) how far it says that as if it were the first to do so, 0 to 1: what stands still shows what it
            did, and all frames of it together say what one does in the mean.
        :param age_s: (T,) since each was seen: it is no less likely than one that has come since then.
        :param elsewhere: (T,) whether scores are less for what is seen may be other parts of it, laid elsewhere. Frames
            in a row see the same parts and err alike: they add nothing to one that does, and what is known from
            others, which saw more, stands.
        """
        before, elsewhere = log_odds(self.probability), np.zeros(len(new), bool) if elsewhere is None else elsewhere
        new = np.where(elsewhere, 0.0, new)
        said, still = log_odds(scores), 1 - config.memory
        again = (still + config.memory * new) * (said + config.found_again * new)
        # what says little says no less of what moves: it may be all that such an object ever shows
        known = config.memory * before + np.maximum(again, still * said)
        known = np.where(elsewhere, np.maximum(known, before), known)
        return Existence.of(np.maximum(_probability(known), newcomers(scores, 1.0, age_s, config)))


def newcomers(scores: Array, continuous: float, dt_s: Array | float, config: ExistenceConfig) -> Array:
    """Probabilities of objects that nobody has seen before.

    Alone, a frame is to be believed. In a sequence that goes on, an object that was not there a moment ago is less
    likely.

    :param continuous: probability that the frame goes on from the one before. :param dt_s: time since that.
    """
    share = continuous * _has_come(dt_s, config) + 1 - continuous
    return _probability(log_odds(scores) + np.log(share)) if continuous else scores


def _has_come(dt_s: Array | float, config: ExistenceConfig) -> Array:
    """How much less likely a newcomer is than an object of a single frame, so long after one that did not show it."""
    return np.maximum(-np.expm1(-((np.asarray(dt_s) / config.newcomer_s) ** 2)), 1e-12)


def log_odds(probability: Array) -> Array:
    """Natural logarithm of p / (1 - p), finite for certainties, too."""
    p = np.clip(probability, 1 - _SUREST, _SUREST)
    return np.asarray(np.log(p / (1 - p)))


def _probability(odds: Array) -> Array:
    return np.asarray(1 / (1 + np.exp(-odds)))


@dataclass(frozen=True)
class Continuity:
    """Whether frames go on from one another, or begin anew: at a cut, or where they were never a sequence.

    :param on, cut: how many frames did, of late.
    """

    on: float
    cut: float

    @classmethod
    def expected(cls, config: ExistenceConfig) -> Continuity:
        return cls((1 - config.cut) * config.cut_frames, config.cut * config.cut_frames)

    @property
    def share(self) -> float:
        return self.on / (self.on + self.cut)

    def judged(
        self, known: Array, just_seen: Flags, odds: Array, new: Array, dt_s: float, config: ExistenceConfig
    ) -> float:
        """The probability that a frame goes on from the one before.

        :param known: (T,) probabilities with which objects were to be seen.
        :param just_seen: (T,) whether the frame before showed them.
        :param odds: (T,) how well what was found continues each; 0: nothing was found.
        :param new: scores of what continues none. :param dt_s: time since the frame before.
        """
        missed = np.where(just_seen, 1 - config.detected * known, 1.0)
        goes_on = np.where(odds > 0, config.detected * known * np.minimum(odds, config.most_odds), missed)
        has_come = new * _has_come(dt_s, config) + 1 - new
        evidence = np.log(np.maximum(np.append(goes_on, has_come), 1e-9)).sum()
        ratio = float(np.exp(np.clip(evidence, -50, 50)))
        return self.share * ratio / (self.share * ratio + 1 - self.share)

    def after(self, went_on: float, config: ExistenceConfig) -> Continuity:
        """Once a frame did, with this probability."""
        left, new = 1 - 1 / config.cut_frames, Continuity.expected(config)
        on, cut = (left * old + fresh / config.cut_frames**2 for old, fresh in ((self.on, new.on), (self.cut, new.cut)))
        return Continuity(on + went_on, cut + 1 - went_on)
