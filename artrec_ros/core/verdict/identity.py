"""Which one of several like objects each found object is, by the colours of its components, all objects at once.

The place, turn and joints of an object are found with alternatives open: a pixel of any of a component's classes
speaks for it. Of rivals at one place that are found that one comes first which shows an identity that exists. Then is
asked which it is: each identity is as likely as the pixels on its components are under it. Where each identity occurs
once, objects are named together (assignment), and an object's probability is that of the best naming of all against
the best one in which it has another name. Who is given a name against what its pixels show has it only as far as it is
likelier that these were misread than that it is none of these objects.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment
from scipy.special import expit, logit, logsumexp

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from ..model.found import SURE, Detection, IdentityFit
from ..model.frame_result import Rejection
from ..model.identities import identities_of
from ..model.objects import ObjectModel
from ..pose.finder import WholeObjectFinder
from ..pose.other_layouts import Layouts
from ..pose.poses import Poses

_LEAST = 1e-9  # nothing is surer than that
NONE_LEFT = "it occurs once, or its identities do (unique), and others are likelier"
# one that is told may have a smaller score, which counts how it lies, too
NOT_FIRST = (
    "it occurs once, or its identities do (unique); by how surely they are there, and how large, others come first"
)
_NOT_KNOWN = -1e9  # instead of a forbidden pair: linear_sum_assignment wants numbers


class Identifier:
    """Names the objects of one target."""

    def __init__(self, finder: WholeObjectFinder) -> None:
        self._finder, self._alternatives, self._config = finder, finder.alternatives, finder.config
        self.identities, self._unique = self._alternatives.identities, self._alternatives.unique

    def identify(
        self, frame: ImageFrame, poses: Poses, told: Sequence[Collection[int]], layouts: Layouts | None = None
    ) -> list[IdentityFit | None]:
        """What each of H objects is; None for all where the model has no identities.

        :param layouts: of the poses, where they are known.
        :param told: of each its components that are told. Who shows none that tells identities has no name: what lies
            where they would be is something else.
        """
        if not self.identities or not len(poses):
            return [None] * len(poses)
        names, least = [i.name for i in self.identities], self._config.min_identity_probability
        layouts = layouts or Layouts.around(self._finder, frame, poses)
        shows, evidence = self._shown(layouts, told)
        fits = named(evidence, names, self._unique, least, layouts.one_of_them().tolist())
        none = IdentityFit(None, 0.0, None, self._unique, least)
        return [fit if shown else none for fit, shown in zip(fits, shows.tolist(), strict=True)]

    def _shown(self, layouts: Layouts, told: Sequence[Collection[int]]) -> tuple[NDArray[np.bool_], Array]:
        """(H,) which objects show a component that tells identities, and (H, N) the `evidence`, 0 of those that do
        not."""
        shows = np.array([not self._alternatives.components.isdisjoint(of) for of in told], bool)
        return shows, np.where(shows[:, None], layouts.evidence(), 0.0)

    def numbers(self, fits: Sequence[IdentityFit | None]) -> list[int | None]:
        """Which of `identities` objects are; None of those without a name."""
        names = [identity.name for identity in self.identities]
        return [None if fit is None or fit.name is None else names.index(fit.name) for fit in fits]

    def may_be_surplus(self, objects: int) -> bool:
        """Whether so many are more than there are."""
        return self._unique and objects > max(len(self.identities), 1)

    def surplus(
        self, frame: ImageFrame, poses: Poses, told: Sequence[Collection[int]], probability: Array, votes: Array
    ) -> tuple[NDArray[np.bool_], Array]:
        """(H,) which objects there is no identity left for, where each occurs once, without identities all but one; and
        (H, H) as of `surplus`.

        Of more objects than `may_be_surplus` allows.

        :param told: as of `identify`. :param probability, votes: (H,) of each object, as if it were the only one. There
            is the more clutter the smaller it is: of rivals who explains more is likelier, as far as that goes.
        """
        by_size = np.log(np.maximum(votes, 1.0) / max(votes.max(), 1.0))
        odds = logit(np.clip(probability, _LEAST, 1 - _LEAST)) + np.maximum(by_size, -self._config.verdict.most_by_size)
        evidence = np.zeros((len(poses), 1))
        if self.identities:
            evidence = self._shown(Layouts.around(self._finder, frame, poses), told)[1]
        return surplus(evidence, odds, 1 - self._config.min_identity_probability)


def one_of_each(
    detections: Sequence[Detection], models: Mapping[str, ObjectModel]
) -> tuple[tuple[Detection, ...], tuple[Rejection, ...]]:
    """Detections, of objects that occur once and have no identities the likeliest one alone; and the others.

    :param models: by the objects' names.
    """
    best: dict[str, Detection] = {}
    for d in detections:
        if models[d.object].unique and not identities_of(models[d.object]):
            best[d.object] = max(best.get(d.object, d), d, key=lambda one: one.score)
    told = tuple(d for d in detections if best.get(d.object, d) is d)
    others = (d for d in detections if best.get(d.object, d) is not d)
    return told, tuple(Rejection(d.object, NONE_LEFT, d.score, d.image.x, d.image.y) for d in others)


def named(
    evidence: Array, names: Sequence[str], unique: bool, least: float, listed: Sequence[float] = ()
) -> list[IdentityFit]:
    """The best naming of H objects with `evidence` (H, N), and each one's runner-up.

    :param unique: whether a name may be given once only. Of more objects than names some have none: those of which the
        pixels tell least, for one without a name is worth the mean of what it would be with each.
    :param least: probability below which no name is told. :param listed: (H,) as of `IdentityFit`; not given: surely.
    """
    choose, spare = (_together, max(len(evidence) - len(names), 0)) if unique else (_each, 0)
    evidence = np.hstack([evidence, np.tile(evidence.mean(axis=1, keepdims=True), spare)])
    best = choose(evidence)
    value = _value(evidence, best)
    known = listed or [SURE] * len(best)
    return [_fit(evidence, names, unique, least, choose, best, value, i, known[i]) for i in range(len(best))]


def doubted(fits: Sequence[IdentityFit | None], there: Sequence[float], misread: float) -> list[IdentityFit | None]:
    """The same; names that are told against what pixels show are less probable, for what is there may be none of these
    objects, or another of their kind, whose combination is not declared.

    Pixels that are misread show any name, and so does what has none. What others leave over tells no name by itself.

    :param there: (H,) how probable each object is. :param misread: how often all of an object's pixels are.
    """
    return [
        fit if fit is None or fit.name is None or not fit.evidence else _doubted(fit, fit.name, probability, misread)
        for fit, probability in zip(fits, there, strict=True)
    ]


def _doubted(fit: IdentityFit, name: str, there: float, misread: float) -> IdentityFit:
    own, evidence = fit.evidence[name], fit.evidence.values()
    share = 1 / sum(math.exp(min(value - own, SURE)) for value in evidence)
    # against pixels that show any name
    shows = min((1 - misread) * share * len(evidence) + misread, 1.0)
    probability = fit.probability * shows / (1 - there * (1 - shows)) * float(expit(fit.listed))
    return replace(fit, name=name if probability >= fit.least else None, probability=probability)


def one_of_these(there: float, fit: IdentityFit | None) -> float:
    """How probable an object is where its components show which one it is: less as far as the classes that they show
    speak against all combinations that are declared. That they show one of these is what chance was reckoned by.

    :param there: how probable it is whichever it is.
    """
    if fit is None or not fit.evidence or fit.listed >= 0:
        return there
    return float(expit(logit(np.clip(there, _LEAST, 1 - _LEAST)) + fit.listed))


def surplus(evidence: Array, odds: Array, wrong: float) -> tuple[NDArray[np.bool_], Array]:
    """(H,) which of H objects, more than there are names, are none: those whose absence is likeliest, all in all; and
    (H, H) log odds that in place of one that is there another one is, which then is none.

    :param evidence: (H, N) of names that occur once each. :param odds: (H,) logarithms of those that each is there.
    :param wrong: probability that pixels tell another name than it is: what is there is not gone for that.
    """
    objects, names = evidence.shape
    share = np.exp(evidence - logsumexp(evidence, axis=1, keepdims=True))
    told = np.log((1 - wrong) * share + wrong / names)
    worth = np.hstack([odds[:, None] + told, np.zeros((objects, objects - names))])
    naming = _together(worth)
    gone, instead = np.array(naming) >= names, np.full((objects, objects), -np.inf)
    for here, other in product(np.flatnonzero(~gone).tolist(), np.flatnonzero(gone).tolist()):
        exchanged = worth.copy()
        exchanged[here, :names] = exchanged[other, names:] = _NOT_KNOWN
        instead[here, other] = _value(exchanged, _together(exchanged)) - _value(worth, naming)
    return gone, instead


def _fit(
    evidence: Array,
    names: Sequence[str],
    unique: bool,
    least: float,
    choose: Callable[[Array], list[int]],
    best: Sequence[int],
    value: float,
    i: int,
    listed: float,
) -> IdentityFit:
    """Object `i` under the best naming of all, against the best in which it has another name.

    :param value: of the best naming.
    """
    known = dict(zip(names, evidence[i].tolist(), strict=False))  # what is beyond them is no name
    if best[i] >= len(names):
        return IdentityFit(None, 0.0, None, unique, least, known, listed)
    other = evidence.copy()
    other[i, best[i]] = _NOT_KNOWN
    rival = choose(other)
    if rival[i] == best[i]:  # there is no other name for it
        return IdentityFit(names[best[i]], 1.0, None, unique, least, known, listed)
    margin = value - _value(evidence, rival)
    probability = float(1 / (1 + np.exp(-min(margin, SURE))))
    told = names[best[i]] if probability >= least else None
    runner_up = names[rival[i]] if rival[i] < len(names) else None
    return IdentityFit(told, probability, runner_up, unique, least, known, listed)


def _each(evidence: Array) -> list[int]:
    return [int(n) for n in evidence.argmax(axis=1)]


def _together(evidence: Array) -> list[int]:
    """Index of each object's name, by the assignment of most evidence."""
    return [int(n) for n in linear_sum_assignment(evidence, maximize=True)[1]]


def _value(evidence: Array, naming: Sequence[int]) -> float:
    return float(evidence[np.arange(len(naming)), naming].sum())
