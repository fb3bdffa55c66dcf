"""Numbers that tell like objects apart, and what is known of which one each is."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import replace
from itertools import count

import numpy as np

from ..geometry.transforms import Array
from ..model.found import IdentityFit
from ..verdict.identity import doubted, named
from .motion import Flags


class Numbers:
    """Who has which number. Small ones: a newcomer has the lowest that nobody else has, or had within a while."""

    def __init__(self) -> None:
        self._unseen_s: dict[tuple[str, int], float] = {}  # who had which number: since when not seen; not for ever
        self._in_company: set[str] = set()  # names of which two were seen at once

    def pass_time(self, dt_s: float, most_s: float) -> None:
        self._unseen_s = {k: s + dt_s for k, s in self._unseen_s.items() if s + dt_s <= most_s}

    def meet(self, names: Iterable[str]) -> None:
        """All that are told of in a frame."""
        self._in_company |= {name for name, n in Counter(names).items() if n > 1}

    def keep(self, name: str, number: int) -> None:
        self._unseen_s[name, number] = 0.0

    def new(self, name: str) -> int:
        """An object of whose name never two were seen at once is number 0: there is nobody whom it could be."""
        number = next(i for i in count() if (name, i) not in self._unseen_s) if name in self._in_company else 0
        self.keep(name, number)
        return number


def same_name(mine: Sequence[IdentityFit | None], its: Sequence[IdentityFit | None], misnamed: float) -> Array:
    """(D, T) how much likelier what is told of identities is if each is each than if they have nothing to do with one
    another.

    Only where there is one of each name does it tell anything. A wrong name speaks only so much against it.
    """
    ratio = np.ones((len(mine), len(its)))
    rows, columns = (
        {n: f for n, f in enumerate(fits) if f is not None and f.unique and f.evidence} for fits in (mine, its)
    )
    for d, fit in rows.items():
        likely = _shares(fit, list(fit.evidence))
        for t, known in columns.items():
            if known.evidence.keys() == fit.evidence.keys():
                alike = float(likely @ _shares(known, list(fit.evidence))) * len(likely)
                ratio[d, t] = (1 - misnamed) * alike + misnamed
    return ratio


def _shares(fit: IdentityFit, names: Sequence[str]) -> Array:
    evidence = np.array([fit.evidence[name] for name in names])
    likely = np.exp(evidence - evidence.max())
    return np.asarray(likely / likely.sum())


def remembered(now: IdentityFit | None, before: IdentityFit | None, memory: float) -> IdentityFit | None:
    """With the evidence of earlier sightings. :param memory: what it counts, of one frame's."""
    if now is None or before is None:
        return now
    told = now.evidence or dict.fromkeys(before.evidence, 0.0)  # who shows nothing now is who it was
    evidence = {k: v + memory * before.evidence.get(k, 0.0) for k, v in told.items()}
    seen = now.listed if now.evidence else 0.0
    return replace(now, evidence=evidence, listed=seen + memory * before.listed)


def same_by_name(
    objects: Sequence[str],
    fits: Sequence[IdentityFit | None],
    there: Array,
    new: Sequence[int],
    lost: Sequence[int],
) -> Array:
    """(n, l) the probability that newcomers are objects that are not seen, by what is known of identities that occur
    but once: that both have one and the same name. A newcomer has none of those that are told of objects that are seen
    where they should be.

    :param there: (T,) probability that each is there. :param new, lost: rows of T.
    """
    gone = {*new, *lost}
    held = {(objects[row], fit.name) for row, fit in enumerate(fits) if fit is not None and row not in gone}
    same = np.zeros((len(new), len(lost)))
    for n, row in enumerate(new):
        for k, before in enumerate(lost):
            mine, its = fits[row], fits[before]
            if objects[row] != objects[before] or mine is None or its is None or not mine.unique:
                continue
            free = [name for name in mine.evidence if name in its.evidence and (objects[row], name) not in held]
            if free:
                same[n, k] = there[row] * (_shares(mine, free) @ _shares(its, free))
    return same


def identified(
    names: Sequence[str], fits: Sequence[IdentityFit | None], likely: Flags, there: Array, misnamed: float
) -> tuple[IdentityFit | None, ...]:
    """The same, told which one each is by what has been seen of it so far; all of an object's together that are
    `likely` (T,) to be there.

    :param there, misnamed: as of `doubted`.
    """
    out = list(fits)
    mine: dict[str, list[int]] = {}
    for n, fit in enumerate(fits):
        if likely[n] and fit is not None and fit.evidence:
            mine.setdefault(names[n], []).append(n)
    for rows in mine.values():
        known = [fit for fit in (fits[n] for n in rows) if fit is not None]
        each = list(known[0].evidence)
        evidence = np.array([[fit.evidence[k] for k in each] for fit in known])
        told = named(evidence, each, known[0].unique, known[0].least)
        told = [replace(one, listed=fit.listed) for one, fit in zip(told, known, strict=True)]
        for n, fit in zip(rows, doubted(told, there[rows].tolist(), misnamed), strict=True):
            out[n] = fit
    return tuple(out)
