"""The lines that `artrec train` prints: what was learned, how far it can be trusted, what more examples would help."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations

from ...core.constraints.constraint_set import ConstraintSet
from ...core.constraints.intervals import Interval
from ...core.constraints.pairs import Key, PairConstraint
from ...core.learning.conformal import examples_wanted
from ...core.learning.pair_learning import Example
from ...core.model.objects import ObjectModel

_UNITS = {"_m": ("m", 1.0), "_rad": ("deg", 180 / math.pi), "_px": ("px", 1.0)}


@dataclass(frozen=True)
class Wanting:
    """A pair of components' markers that too few examples show together to tell how far its box must be widened."""

    first: Key
    second: Key
    examples: int
    more: int


def wanting(model: ObjectModel, examples: Iterable[Example], constraints: ConstraintSet) -> Iterator[Wanting]:
    """Pairs that want more examples: seen together at all, and too seldom to show the coverage that is aimed at."""
    seen = Counter(pair for e in examples for pair in combinations([k for k in model.markers if k in e], 2))
    needed = examples_wanted(constraints.coverage)
    for (first, second), count in seen.items():
        if first[0] != second[0] and count < needed:
            yield Wanting(first, second, count, needed - count)


def report(
    model: ObjectModel,
    examples: Sequence[Example],
    constraints: ConstraintSet,
    *,
    made_up: bool = False,
    detailed: bool = False,
) -> Iterator[str]:
    """The lines that `artrec train` prints: whether all this is asked, a table of pairs, classes, axes, then what more
    examples would help.

    :param made_up: examples were made, so that nobody has more of them, nor wrong clicks to find in the table.
    :param detailed: the table in any case, be it asked or not.
    """
    yield from _use(model)
    if made_up and model.is_spatial and not detailed:
        yield f"{len(examples)} examples of '{model.name}', {len(constraints.pairs)} pairs: --debug lists them."
    else:
        yield from _table(examples, constraints)
    more = [] if made_up else sorted(wanting(model, examples, constraints), key=lambda w: -w.more)
    if more:
        needed = examples_wanted(constraints.coverage)
        yield f"{len(more)} pairs want more examples: fewer than {needed} cannot show that {constraints.coverage:g} is"
        yield "covered, and their margin supposes an even spread:"
        for w in more:
            yield f"  {'/'.join(w.first)} - {'/'.join(w.second)}: {w.more} more ({w.examples} seen)"
    yield from _class_lines(constraints)
    yield from _axis_lines(constraints)


def _table(examples: Sequence[Example], constraints: ConstraintSet) -> Iterator[str]:
    name = constraints.object
    yield f"{len(examples)} examples of '{name}'. Box: what was seen. Covers: share of new examples expected"
    yield "inside that box, and inside the box with its margin, which is what the recogniser checks. By chance: share"
    yield "of unrelated markers nearby that pass the check all the same."
    width = max((len(_name(p)) for p in constraints.pairs), default=4)
    yield f"{'pair':{width}}  examples  covers        by chance  box"
    for p in constraints.pairs:
        box = "  ".join(_side(name, interval) for name, interval in p.seen.items() if name in p.allowed)
        covers = f"{p.coverage_seen:4.2f} -> {_shown_coverage(p.examples, constraints.coverage):4.2f}"
        yield f"{_name(p):{width}}  {p.examples:8d}  {covers}  {p.chance(constraints.reach_m):9.2g}  {box}"


def _use(model: ObjectModel) -> Iterator[str]:
    """Where pairs are not asked, however well they are learned."""
    if model.is_spatial:
        images = "images with calibration" if not model.is_flat else "images"
        yield f"Every marker of '{model.name}' has a pose: in {images} it is found by these, and no pair is asked"
        yield "(unless recognizer.whole_object is false, or recognizer.profile is paper)."


def _shown_coverage(examples: int, aimed: float) -> float:
    """The coverage of a box with its margin, as far as the examples show it."""
    return aimed if examples >= examples_wanted(aimed) else min(aimed, examples / (examples + 1))


def _class_lines(constraints: ConstraintSet) -> Iterator[str]:
    needed = examples_wanted(constraints.coverage)
    for c in constraints.classes:
        covers = _shown_coverage(c.examples, constraints.coverage)
        more = f"; {needed - c.examples} more examples are wanted" if c.examples < needed else ""
        yield f"class '{c.name}': {c.examples} examples; its region covers {covers:4.2f} of new ones{more}"
        for name, joint in c.joints.items():
            ends = " to ".join(f"{end:.3f}" for end in (joint.seen.low, joint.seen.high))
            yield f"  {name}: {ends}, allowed {joint.allowed.low:.3f} to {joint.allowed.high:.3f}"


def _axis_lines(constraints: ConstraintSet) -> Iterator[str]:
    for a in constraints.axes:
        x, y = (1e3 * v for v in a.shift_m)
        yield (
            f"axis of {'/'.join(a.key)}: annotated as if its head lay {x:.2f}, {y:.2f} mm off and it were turned by "
            f"{math.degrees(a.turn_rad):.2f} deg; median error {a.before_deg:.2f} -> {a.after_deg:.2f} deg "
            f"in {a.examples} examples"
        )


def _name(pair: PairConstraint) -> str:
    return f"{'/'.join(pair.first)} - {'/'.join(pair.second)}"


def _side(name: str, interval: Interval) -> str:
    """One side of a box: `distance 0.053..0.121 m`."""
    stem, (unit, factor) = next(
        ((name.removesuffix(s), u) for s, u in _UNITS.items() if name.endswith(s)), (name, ("", 1.0))
    )
    digits = 1 if unit in ("deg", "px") else 3
    ends = f"{interval.low * factor:.{digits}f}..{interval.high * factor:.{digits}f}"
    return f"{stem.replace('_', ' ')} {ends} {unit}".rstrip()
