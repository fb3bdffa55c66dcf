"""What objects may be instead: when targets that look like them were looked for in their places, and what came of it.

Who may be there instead is followed as what is told is. A look that takes more waits its turn, as blobs do: what was
found there is looked for anew as often as all that is known, what was not ever later, and sooner where the object shows
less than it did.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from ..base.config import RecallConfig
from ..geometry.transforms import Array
from ..pose.finder import WholeObjectFinder
from ..pose.surface_kernels import LEAST_DEPTH_M
from ..verdict.like_targets import Before
from ..verdict.other_objects import Rival
from ..verdict.verdicts import Verdict
from .memory import Instead, Known
from .turns import due

Pair = tuple[Verdict, WholeObjectFinder]  # an object, and what may be there instead


class _Place(NamedTuple):
    """What was told in an object's place last; empty: nothing. :ivar instead: of other targets' there."""

    told: str = ""
    instead: Mapping[str, Instead] = {}


class Likes:
    """In one frame."""

    def __init__(
        self,
        known: Mapping[str, Sequence[Known]],
        now_s: float,
        passed_s: float,
        refresh_s: float,
        config: RecallConfig,
    ) -> None:
        """:param known: objects of the frames before, by name. :param now_s, passed_s, refresh_s: as of `Turns`."""
        self._known = [(name, k) for name, mine in known.items() for k in mine]
        self._now_s, self._passed_s, self._refresh_s, self._config = now_s, passed_s, refresh_s, config
        self._looked, self._left_out = list[Pair](), list[Pair]()
        self._places = dict[Verdict, _Place]()

    def known(self, pair: Pair) -> Known | None:
        """What may be there instead, as it was; None: it was not."""
        one = self._of(pair)
        return None if one is None else one.known

    def due(self, pairs: Sequence[Pair], lost: Sequence[bool]) -> list[int]:
        """Which of these are to be looked at in full, the one that has waited longest first.

        :param lost: of which what was known is not there as it was.
        """
        ones = [self._of(pair) for pair in pairs]
        age_s = np.array([np.inf if one is None else self._now_s - one.looked_s for one in ones])
        wait_s = np.array([self._wait_s(*of) for of in zip(pairs, ones, lost, strict=True)])
        new = set(np.flatnonzero(np.isinf(age_s)).tolist())
        return sorted(new | due(age_s, wait_s, self._passed_s), key=lambda n: (-age_s[n], n))

    def look(self, pairs: Sequence[Pair]) -> None:
        """They are looked at now."""
        self._looked += pairs

    def leave_out(self, pairs: Sequence[Pair]) -> None:
        """There is no time to look at them."""
        self._left_out += pairs

    def cut_short(self) -> None:
        """There is no time to see what came of looks."""
        self._left_out, self._looked = [*self._left_out, *self._looked], []

    def before(self, verdict: Verdict) -> Before:
        """What is known of an object's place."""
        told, instead = self._place(verdict)
        log_odds = {name: one.log_odds if one.known else -np.inf for name, one in instead.items()}
        return Before(told, log_odds, self._config.steadiness)

    def left_out(self, verdict: Verdict) -> Sequence[WholeObjectFinder]:
        """As of `Past`."""
        return _near(verdict, self._left_out)

    def left(self, verdict: Verdict, rivals: Sequence[Rival]) -> Mapping[str, Instead]:
        """For the next frame, of an object that is told. :param rivals: what it may be instead."""
        rivals = [r for r in rivals if r.finder is not verdict.finder]
        if not rivals and not self._looked and not any(k.instead for _, k in self._known):
            return {}
        out, shown = dict(self._place(verdict).instead), sum(verdict.confirmed)
        out.pop(verdict.finder.target.name, None)
        looked = [f.target.name for f in _near(verdict, self._looked)]
        may_be = {r.finder.target.name: r for r in rivals}
        for name in dict.fromkeys([*out, *looked, *may_be]):
            old, rival = out.get(name), may_be.get(name)
            at = (old.looked_s, old.shown) if old and name not in looked else (self._now_s, shown)
            if rival is not None and rival.verdict is not None:
                known = self._followed(old.known if old else None, rival.finder, rival.verdict)
                out[name] = Instead(known, rival.log_odds, at[0], self._refresh_s, at[1])
            elif rival is None and (name in looked or (old is not None and old.known)):
                wait_s = self._vain_s if old is None or old.known else min(2 * old.wait_s, self._refresh_s)
                out[name] = Instead(None, 0.0, at[0], wait_s, at[1])
        return out

    @property
    def _vain_s(self) -> float:
        return min(self._config.retry_s, self._refresh_s)

    def _wait_s(self, pair: Pair, one: Instead | None, lost: bool) -> float:
        if one is None:
            return self._refresh_s
        less = sum(pair[0].confirmed) < one.shown
        return min(one.wait_s, self._vain_s) if lost or less else one.wait_s

    def _followed(self, known: Known | None, finder: WholeObjectFinder, verdict: Verdict) -> Known:
        seen = verdict.poses, self._now_s, verdict.votes
        if known is None:
            return Known.first(*seen)
        return known.then(*seen, self._now_s, finder.surface.kinematics.endless, self._config.steadiness)

    def _of(self, pair: Pair) -> Instead | None:
        return self._place(pair[0]).instead.get(pair[1].target.name)

    def _place(self, verdict: Verdict) -> _Place:
        """As of `_expected`."""
        if verdict not in self._places:
            self._places[verdict] = self._expected(verdict)
        return self._places[verdict]

    def _expected(self, verdict: Verdict) -> _Place:
        """Where an object of a target is expected, be it that it was told there, or that it might have been: of what
        was told last the nearest one."""
        name, near = verdict.finder.target.name, list[tuple[float, float, str, Known]]()
        for told, k in self._known:
            mine = k if told == name else one.known if (one := k.instead.get(name)) else None
            if mine is not None and (off := self._off(verdict, mine)) < verdict.finder.surface.extent:
                near.append((-k.seen_s, off, told, k))
        if not near:
            return _Place()
        _, _, told, k = min(near, key=lambda of: of[:2])
        if told == name:
            return _Place(told, k.instead)
        own = k.instead[name]
        others = {n: replace(one, log_odds=one.log_odds - own.log_odds) for n, one in k.instead.items() if n != name}
        # what that one may have been instead is among the others: told and not told in turn it would hold all of before
        return _Place(told, others | {told: replace(own, known=replace(k, instead={}), log_odds=-own.log_odds)})

    def _off(self, verdict: Verdict, known: Known) -> float:
        """How far from where it is expected, seen from the camera: how far away it is is known least."""
        return float(min(_apart(place, verdict) for place in known.places(self._now_s)))


def _near(verdict: Verdict, pairs: Sequence[Pair]) -> list[WholeObjectFinder]:
    """What of some pairs is about an object's place."""
    extent = verdict.finder.surface.extent
    return [f for v, f in pairs if f is not verdict.finder and _apart(v.poses.t[0], verdict) < extent]


def _apart(place: Array, verdict: Verdict) -> float:
    at = verdict.poses.t[0]
    return float(np.linalg.norm(place * (at[2] / max(place[2], LEAST_DEPTH_M)) - at))
