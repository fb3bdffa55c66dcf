"""Pairs of markers of which the examples show little: what a frame with one of them would teach."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations

from ...core.constraints.pairs import ANGLES, Key, PairConstraint, configuration
from ...core.learning.pair_learning import Example, learn
from ...core.model.found import Detection, Instance
from ...core.model.frame_result import FrameResult
from ...core.model.target import Target
from ...io.learned.annotations import Annotations
from .examples import Examples

_ENOUGH = 3  # examples of a pair: fewer are seldom
_NEVER = 0.8  # what a pair is worth that was never seen
_ANOTHER = 0.6  # what another configuration is worth, the farther off the more
_NOISE = 0.1  # radians, or share of the pair's reach: what is off by less may be how exactly somebody drew
_SCALE = ("scale_ratio",)  # tells how markers are seen, not how they stand


@dataclass(frozen=True)
class Shown:
    """What the examples show of one object. :param counts: pair of markers -> how many examples show both.
    :param pairs: what was learned of those that two or more do."""

    counts: Mapping[frozenset[Key], int]
    pairs: Mapping[frozenset[Key], PairConstraint]


def shown_by(examples: Examples, targets: Sequence[Target]) -> dict[str, Shown]:
    """Object -> what its examples show; objects without examples are left out: all of them would be rare."""
    known = {}
    for target in targets:
        own = tuple(o for o in list(examples.objects) if examples.target(o).model.name == target.model.name)
        if own:
            known[target.name] = _shown(target, Annotations(examples.categories, own).examples(target.model))
    return known


def _shown(target: Target, examples: Sequence[Example]) -> Shown:
    counts: dict[frozenset[Key], int] = {}
    for example in examples:
        for pair in _pairs(example):
            counts[frozenset(pair)] = counts.get(frozenset(pair), 0) + 1
    learned = learn(target.model, examples).pairs
    return Shown(counts, {frozenset((p.first, p.second)): p for p in learned})


def rare_pairs(result: FrameResult, known: Mapping[str, Shown]) -> Iterator[tuple[float, str]]:
    """What each rare pair in a frame is worth, and why."""
    for d in result.detections:
        if d.object in known:
            yield from _rare(d, known[d.object])


def _rare(d: Detection, shown: Shown) -> Iterator[tuple[float, str]]:
    places = {(c.component, c.marker): c for c in d.components}
    for first, second in _pairs(places):
        named = f"{d.name}: {_named(first, second)}"
        count = shown.counts.get(frozenset((first, second)), 0)
        if count < _ENOUGH:
            times = f"{count} example{'s' * (count != 1)}" if count else "no example"
            yield _NEVER * (1 - count / _ENOUGH), f"{named} together in {times}"
        elif pair := shown.pairs.get(frozenset((first, second))):
            yield from ((worth, f"{named}: {told}") for worth, told in _another(pair, places))


def _another(pair: PairConstraint, places: Mapping[Key, Instance]) -> Iterator[tuple[float, str]]:
    """Where the two stand to each other as no example has them."""
    values = configuration(places[pair.first], places[pair.second])
    for name, allowed in pair.allowed.items():
        if name in _SCALE:
            continue
        noise = _NOISE * (1.0 if name in ANGLES else pair.reach_m)
        beyond = float(allowed.excess(values[name])) - noise
        if beyond > 0:
            known = f"{allowed.low:.2g}..{allowed.high:.2g} in {pair.examples} examples"
            worth = _ANOTHER * beyond / (beyond + max(allowed.width, noise))
            yield worth, f"{name} {float(values[name]):.2g}, {known}"


def _pairs(places: Mapping[Key, object]) -> Iterator[tuple[Key, Key]]:
    """Markers of two components, each two once."""
    return ((a, b) for a, b in combinations(sorted(places), 2) if a[0] != b[0])


def _named(first: Key, second: Key) -> str:
    return f"{'/'.join(first)} and {'/'.join(second)}"
