"""The reference colours that tell classes best, chosen one after the other from candidates.

A candidate is a colour of a class, or of the background, with a range of light. Of all of them the one is taken that
lowers the loss most, till none does so by enough. The loss is the cross-entropy: the mean over samples of minus the
logarithm of their own class' probability, by the same likelihoods that recognition goes by. So a dull red is red's
where red is likelier there, and the floor's where the floor is, and a class gets as many references as tell it from the
others, no more. A class' samples are also counted as they would look in more and in less light; the background's are
not: brightened wood is white, and would take what glares from every class.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import cv2
import numpy as np
from numpy.typing import NDArray

from ..base.config import ClassConfig, ImageConfig, LearningConfig
from ..geometry.transforms import Array
from ..image.colour_table import Colours, as_grey, cost_of

_LEARNING = LearningConfig()
_LIGHTS = ((0.35, 1.8), (0.6, 1.3), (0.7, 1.1))  # ranges of light that a reference may have: the usual one first
_OTHER_LIGHT = (0.5, 0.7, 1.4)  # light in which samples are looked at besides their own
_WORST = 6.0  # loss of a sample at most: wrong samples decide nothing
_TINY = 1e-300  # has a logarithm
_TOO_FAR = 200.0  # -2 log likelihood that stands for any greater


@dataclass(frozen=True)
class Reference:
    """A reference colour (3,) BGR 0..1 of a class, by its name; None: the background's. `light`: as `ClassConfig`'s."""

    owner: str | None
    colour: Colours
    light: tuple[float, float]


def clusters(colours: Colours, count: int, least_share: float) -> list[Colours]:
    """The medians of the clusters (k-means) that hold at least this share of colours (n, 3)."""
    count = min(count, len(colours))
    cv2.setRNGSeed(0)
    start = np.zeros((0, 1), np.int32)
    how = (cv2.TERM_CRITERIA_EPS + cv2.TERM_CRITERIA_MAX_ITER, 20, 1e-3)
    member = cv2.kmeans(colours, count, start, how, 1, cv2.KMEANS_PP_CENTERS)[1].ravel()
    sizes = np.bincount(member, minlength=count)
    kept = np.flatnonzero(sizes >= max(least_share * len(colours), 1))
    return [np.median(colours[member == k], axis=0).astype(np.float32) for k in kept[np.argsort(-sizes[kept])]]


def candidates(samples: Mapping[str | None, Sequence[Colours]]) -> list[Reference]:
    """Per owner the centres of its samples' clusters, each in every range of light: a white sheet is background without
    taking what is grey and nearly a class' own."""
    found = []
    for owner, groups in samples.items():
        for colours in groups:
            count = _LEARNING.clusters_background if owner is None else _LEARNING.clusters
            for centre in clusters(colours, count, _LEARNING.least_share):
                found += [Reference(owner, centre, light) for light in _LIGHTS]
    return found


@dataclass(frozen=True)
class Offer:
    """Candidates and what they make of samples, whatever these weigh.

    :param owners: classes, in the order of rows; the background's row is the one after theirs.
    :param references: the candidates. :param likelihood: (candidates, samples) of samples under each.
    :param true: (samples,) the row of each one's owner, in rising order.
    :param divisor: (samples,) groups of the owner, times samples of the group: each group weighs the same.
    """

    owners: Sequence[str]
    references: Sequence[Reference]
    likelihood: Array
    true: NDArray[np.intp]
    divisor: Array

    @classmethod
    def of(cls, samples: Mapping[str | None, Sequence[Colours]], image: ImageConfig) -> Offer:
        """:param samples: class -> groups of its colours (n, 3) BGR 0..1; None: the background's, last. Every class has
        samples. :param image: noise and the like.
        """
        owners, references = [name for name in samples if name is not None], candidates(samples)
        colours, true, divisor = _shown(samples, [*owners, None])
        return cls(owners, references, np.exp(-_costs(colours, references, image).astype(float) / 2), true, divisor)


def choose(offer: Offer, image: ImageConfig, background: float) -> list[Reference]:
    """The references that together tell best which class a colour is of.

    :param image: noise and the like. :param background: weight of its groups, in those of a class.
    """
    choice = _Choice(offer, image, background)
    while (best := choice.next()) is not None:
        choice.take(best)
    choice.drop()
    return [offer.references[n] for n in choice.taken]


class _Choice:
    """What has been chosen so far, and what a further candidate would bring."""

    def __init__(self, offer: Offer, image: ImageConfig, background: float) -> None:
        self._rest = len(offer.owners)  # the background's row; unknown has the one after it
        rows = {name: n for n, name in enumerate(offer.owners)}
        self._owner = np.array([rows.get(r.owner or "", self._rest) for r in offer.references])
        self._true, self._likelihood = offer.true, offer.likelihood
        weight = np.where(offer.true == self._rest, background, 1.0) / offer.divisor
        self._weight = weight / weight.sum()
        self._unknown = np.exp(-(image.max_deviation**2) / 2)
        self._take([])

    def next(self) -> int | None:
        """The candidate that brings most; None: none brings enough. Each class, and the background where it is shown,
        gets one before any gets a second."""
        counts = np.bincount(self._owner[self.taken], minlength=self._rest + 1)
        without = np.setdiff1d(self._owner, self._owner[self.taken])
        most = np.append(np.full(self._rest, _LEARNING.most_colours), _LEARNING.most_background)
        open_rows = without if len(without) else np.flatnonzero(counts < most)
        losses = np.full(len(self._owner), np.inf)
        for row in open_rows.tolist():
            mine = slice(*np.searchsorted(self._owner, (row, row + 1)))
            losses[mine] = self._with(row, self._likelihood[mine])
        best = int(np.argmin(losses))
        enough = losses[best] < self._loss - _LEARNING.least_gain
        return best if np.isfinite(losses[best]) and (len(without) or enough) else None

    def take(self, candidate: int) -> None:
        self._take([*self.taken, candidate])

    def _take(self, taken: list[int]) -> None:
        self.taken = taken
        self._now = self._rows(taken)
        self._own_now, self._every_now = self._own(self._now), self._now.sum(axis=0)
        self._loss = float(self._weight @ _loss(self._own_now, self._every_now))

    def drop(self) -> None:
        """Leaves out what later ones have made superfluous; nobody's last."""
        for candidate in list(self.taken):
            rest = [n for n in self.taken if n != candidate]
            if self._owner[candidate] not in self._owner[rest]:
                continue
            loss = self._total(self._rows(rest))
            if loss < self._loss + _LEARNING.least_gain:
                self.taken, self._loss = rest, loss

    def _rows(self, taken: Sequence[int]) -> Array:
        """(classes + 2, samples) likelihood under each class, the background, unknown."""
        rows = np.zeros((self._rest + 2, len(self._true)))
        rows[-1] = self._unknown
        for n in taken:
            np.maximum(rows[self._owner[n]], self._likelihood[n], out=rows[self._owner[n]])
        return rows

    def _own(self, rows: Array) -> Array:
        """(samples,) likelihood of what each sample is; of the background's, unknown is half right."""
        own = rows[self._true, np.arange(len(self._true))]
        return np.asarray(own + np.where(self._true == self._rest, rows[-1] / 2, 0.0))

    def _total(self, rows: Array) -> float:
        return float(self._weight @ _loss(self._own(rows), rows.sum(axis=0)))

    def _with(self, row: int, likelihood: Array) -> Array:
        """(n,) losses with one of these candidates (n, samples) of a row added. Only the row's own samples get likelier
        by them, and few others are like them: logarithms are what takes the time, and the rest's stay."""
        gained = np.maximum(likelihood - self._now[row], 0.0)
        every = self._every_now + gained
        loss = np.repeat(np.log(self._every_now)[None], len(likelihood), axis=0)
        changed = np.flatnonzero(every != self._every_now)
        loss.ravel()[changed] = np.log(every.ravel()[changed])
        begin, end = np.searchsorted(self._true, (row, row + 1))
        own = np.log(self._own_now + _TINY)
        loss[:, :begin] -= own[:begin]
        loss[:, begin:end] -= np.log(self._own_now[begin:end] + gained[:, begin:end] + _TINY)
        loss[:, end:] -= own[end:]
        return np.asarray(np.minimum(loss, _WORST, out=loss) @ self._weight)


def _loss(own: Array, every: Array) -> Array:
    return np.asarray(np.minimum(np.log(every) - np.log(own + _TINY), _WORST))


def _shown(
    samples: Mapping[str | None, Sequence[Colours]], owners: Sequence[str | None]
) -> tuple[Colours, NDArray[np.intp], Array]:
    """Colours (n, 3), some of them in other light as well, the row of each one's owner, its `Offer.divisor`."""
    colours, rows, divisors = list[Colours](), list[NDArray[np.intp]](), list[Array]()
    for row, owner in enumerate(owners):
        groups = samples.get(owner, ())
        for group in groups:
            count = int(np.ceil(_LEARNING.share_other_light * len(group)))
            shown = [group]
            for n, light in enumerate(() if owner is None else _OTHER_LIGHT):
                shown.append(np.minimum(np.roll(group, -n * count, axis=0)[:count] * np.float32(light), 1.0))
            colours += shown
            number = sum(map(len, shown))
            rows.append(np.full(number, row))
            divisors.append(np.full(number, float(len(groups) * number)))
    return np.concatenate(colours), np.concatenate(rows), np.concatenate(divisors)


def _costs(colours: Colours, references: Sequence[Reference], image: ImageConfig) -> Colours:
    """(references, n) -2 log likelihood of colours (n, 3); more, under one that is no grey, of what is like a grey."""
    usual = ClassConfig()
    grey = as_grey(colours, usual.spread, image.noise)
    costs = [cost_of(colours, r.colour, replace(usual, light=r.light), image, grey)[0] for r in references]
    return np.minimum(np.stack(costs), np.float32(_TOO_FAR))
