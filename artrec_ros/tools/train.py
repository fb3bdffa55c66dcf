"""`artrec train`: learns an object's constraints from annotated images, and says how far they can be trusted."""

from __future__ import annotations

import argparse
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path

from ..core.constraints import ConstraintSet
from ..core.errors import ConfigError
from ..core.intervals import Interval, examples_for_coverage, expected_coverage, margin_for_coverage
from ..core.learning import Example, learn
from ..core.objects import ObjectModel
from ..core.pairs import Key, PairConstraint
from ..io.annotations import Annotations, load_coco
from ..io.constraints import save_constraints
from ..io.objects import load_object

_LEAST_EXAMPLES = 2
_UNITS = {"_m": ("m", 1.0), "_rad": ("deg", 180 / math.pi), "_px": ("px", 1.0)}


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser("train", help="learn an object's constraints", description=__doc__)
    parser.add_argument("--object", required=True, type=Path, metavar="OBJECT.yaml", help="what the object is")
    parser.add_argument(
        "--annotations", required=True, type=Path, nargs="+", action="extend", metavar="COCO.json",
        help="COCO keypoints named COMPONENT/MARKER.tail and COMPONENT/MARKER.head",
    )  # fmt: skip
    parser.add_argument(
        "--category", nargs="+", action="extend", default=[], metavar="NAME", help="annotations to use (default: all)"
    )
    parser.add_argument("-o", "--output", required=True, type=Path, metavar="CONSTRAINTS.yaml", help="file to write")
    parser.add_argument(
        "--coverage", type=float, default=0.95, metavar="SHARE",
        help="share of new examples that each pair's box shall hold, 0 (the bare box) to 0.999 (default %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--max-scale-ratio", type=float, default=2.0, metavar="RATIO",
        help="leave out markers whose scale is below their object's largest by more than this: they are seen too "
        "obliquely to be found by their shape (default %(default)s: 60 degrees)",
    )  # fmt: skip


def run(args: argparse.Namespace) -> int:
    """Learns, writes the constraint file, prints the report."""
    if not 0 <= args.coverage <= 0.999:
        raise ConfigError(f"--coverage: {args.coverage} is not within 0 .. 0.999")
    if not args.max_scale_ratio >= 1:
        raise ConfigError(f"--max-scale-ratio: {args.max_scale_ratio} is below 1")
    model = load_object(args.object)
    annotations = load_coco(args.annotations).of(args.category)
    training = train(model, annotations, args.coverage, args.max_scale_ratio)
    constraints = training.constraints
    save_constraints(args.output, constraints)
    print("\n".join(report(model, training.examples, constraints)))
    if half := annotations.half_labelled():
        print(f"{half} markers have only one end of their axis labelled and were left out.")
    if training.oblique:
        print(f"{training.oblique} markers are seen too obliquely (--max-scale-ratio) and were left out.")
    print(f"Wrote {args.output}: {len(constraints.pairs)} pairs of object '{model.name}'.")
    return 0


@dataclass(frozen=True)
class Training:
    """What was learned, from which examples; `oblique` counts markers that were left out."""

    constraints: ConstraintSet
    examples: list[Example]
    oblique: int


def train(model: ObjectModel, annotations: Annotations, coverage: float, max_scale_ratio: float) -> Training:
    """Constraints from annotations.

    :param coverage: share of new examples that each pair's box shall hold.
    :param max_scale_ratio: markers of smaller scale than their object's largest by more than this are left out.
    """
    everything = [e for e in annotations.examples(model) if e]
    examples: list[Example] = []
    for e in everything:
        least = max(i.scale for i in e.values()) / max_scale_ratio
        examples.append({key: i for key, i in e.items() if i.scale >= least})
    constraints = learn(model, examples, coverage, _LEAST_EXAMPLES)
    if not constraints.pairs and len(model.components) > 1:
        raise ConfigError(
            f"of {len(annotations.objects)} annotations, {len(examples)} show a marker of object '{model.name}' and no "
            f"pair of its components is seen together in {_LEAST_EXAMPLES} or more; annotate both ends of both axes"
        )
    return Training(constraints, examples, sum(map(len, everything)) - sum(map(len, examples)))


@dataclass(frozen=True)
class Wanting:
    """A pair of components' markers whose bare box covers less than is aimed for."""

    first: Key
    second: Key
    examples: int
    more: int


def wanting(model: ObjectModel, examples: Iterable[Example], constraints: ConstraintSet) -> Iterator[Wanting]:
    """Pairs that want more examples: seen together at all, and too seldom for the coverage without a margin."""
    seen = Counter(pair for e in examples for pair in combinations([k for k in _keys(model) if k in e], 2))
    learned = {frozenset((p.first, p.second)): p for p in constraints.pairs}
    for (first, second), count in seen.items():
        if first[0] == second[0]:
            continue
        pair = learned.get(frozenset((first, second)))
        dimensions = len(pair.allowed) if pair else 4
        needed = examples_for_coverage(constraints.coverage ** (1 / dimensions))
        if count < needed:
            yield Wanting(first, second, count, needed - count)


def report(model: ObjectModel, examples: Sequence[Example], constraints: ConstraintSet) -> Iterator[str]:
    """The lines that `artrec train` prints: a table of pairs, then what more examples would help."""
    more = {frozenset((w.first, w.second)): w for w in wanting(model, examples, constraints)}
    yield f"{len(examples)} examples of '{model.name}'. Box: what was seen. Covers: share of new examples expected"
    yield "inside that box, and inside the box with its margin, which is what the recogniser checks."
    width = max((len(_name(p)) for p in constraints.pairs), default=4)
    yield f"{'pair':{width}}  examples  covers         box"
    for p in constraints.pairs:
        box = "  ".join(_side(name, interval) for name, interval in p.seen.items() if name in p.allowed)
        widened = max(p.coverage_seen, _reached(p, constraints.coverage))
        yield f"{_name(p):{width}}  {p.examples:8d}  {p.coverage_seen:4.2f} -> {widened:4.2f}   {box}"
    if more:
        yield f"{len(more)} pairs want more examples before the bare box covers {constraints.coverage:g}; till then the"
        yield "margin must do:"
        for w in sorted(more.values(), key=lambda w: -w.more):
            yield f"  {'/'.join(w.first)} - {'/'.join(w.second)}: {w.more} more ({w.examples} seen)"


def _reached(pair: PairConstraint, aimed: float) -> float:
    """The coverage of the widened box; the margin is bounded, so that few examples may not reach what is aimed."""
    n = len(pair.allowed)
    return expected_coverage(pair.examples, margin_for_coverage(pair.examples, aimed ** (1 / n))) ** n


def _keys(model: ObjectModel) -> list[Key]:
    return [(c.name, m.name) for c in model.components for m in c.markers]


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
