"""What is learned from examples: constraints and what changed in them, colours, limits of the scale."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...core.base.errors import ConfigError
from ...core.constraints.constraint_set import ConstraintSet
from ...core.constraints.pairs import PairConstraint
from ...core.model.target import Target
from ...core.ways import FACING, SPACE, way_of
from ...io.learned.annotations import load_coco
from ...io.learned.constraints import save_constraints
from ...io.learned.marked_scales import beyond_marks_px, marked_scales
from ..colour_report import are_few, scale_limits, scale_line
from ..colour_report import report as report_colours
from ..train import Training, train
from ..training.train_report import report
from .colour_marks import ColourMarks
from .examples import Examples
from .session import Session

_COVERAGE, _MAX_SCALE_RATIO = 0.95, 2.0  # artrec train's defaults
_TOLD_SHARE = 0.02  # of a range: smaller changes are not worth a line
_TOLD_RIGHT = 0.01  # the same of pixels


@dataclass(frozen=True)
class Change:
    """What is different. :param moved: by how much of a range; inf: it is new or gone, 0: no range changed."""

    line: str
    moved: float = 0.0


@dataclass(frozen=True)
class Trained:
    """:param written: the constraint files. :param changes: what is different now. :param lines: as the command's."""

    written: tuple[Path, ...]
    changes: tuple[Change, ...]
    lines: tuple[str, ...]

    @property
    def headline(self) -> str:
        """What changed, the most of it, in one line."""
        moved = sorted((c for c in self.changes if c.moved), key=lambda c: -c.moved)
        rest = f"; {len(moved) - 1} more ranges changed" if len(moved) > 1 else ""
        return f"{moved[0].line}{rest}" if moved else "; ".join(c.line for c in self.changes)


@dataclass(frozen=True)
class LearnedColours:
    """:param right: class -> share of its marked pixels that are told as it. :param lines: as the command's."""

    right: Mapping[str, float]
    lines: tuple[str, ...]

    def headline(self, before: LearnedColours | None) -> str:
        """How well classes are told now, in one line, against what was learned before."""
        if before is None:
            told = ", ".join(f"{name} {share:.0%}" for name, share in self.right.items())
            return f"colours: {told} of the marked pixels told right"
        moved = [(name, before.right.get(name, 0.0), share) for name, share in self.right.items()]
        told = ", ".join(f"{n} {old:.0%} -> {new:.0%}" for n, old, new in moved if abs(new - old) >= _TOLD_RIGHT)
        return f"colours: {told} told right" if told else "colours: told as well as before"


def train_examples(session: Session, examples: Examples, wanted: Callable[[], bool] = lambda: True) -> Trained | None:
    """Learns the constraints of each object that has examples, and names the files in the parameters.

    :param wanted: asked before anything is written; None is returned where it no longer is.
    :raises ConfigError: no examples, or too few.
    """
    annotations = load_coco([examples.path]) if examples.objects else None
    if annotations is None or not annotations.objects:
        raise ConfigError("no example is marked yet: draw the axes of some objects, or accept proposals")
    by_model: dict[str, list[str]] = {}
    for name in annotations.categories:
        own = [o for o in annotations.objects if o.category == name]
        if own:
            by_model.setdefault(examples.target(own[0]).model.name, []).append(name)
    learned = [
        (targets, train(targets[0].model, annotations.of(categories), _COVERAGE, _MAX_SCALE_RATIO))
        for name, categories in by_model.items()
        if (targets := [t for t in session.setup.targets if t.model.name == name])
    ]
    return _written(session, learned) if wanted() else None


def _written(session: Session, learned: Sequence[tuple[Sequence[Target], Training]]) -> Trained:
    """Writes the files. :param learned: the targets of one object file, and what was learned of it."""
    written: list[Path] = []
    changes: list[Change] = []
    lines: list[str] = []
    parameters: dict[str, str] = {}
    for targets, training in learned:
        model = targets[0].model
        path = session.folder / f"{model.name}_constraints.yaml"
        save_constraints(path, training.constraints)
        written.append(path)
        parameters |= {f"{t.name}.constraint_file": path.name for t in targets}
        changes += changes_of(targets[0], training.constraints)
        changes += [Change(line) for t in targets if (line := unread(session, t))]
        lines += report(model, training.examples, training.constraints)
    session.keep(parameters)
    return Trained(tuple(written), tuple(changes), tuple(lines))


def learn_colours(
    session: Session, examples: Examples, wanted: Callable[[], bool] = lambda: True
) -> LearnedColours | None:
    """Colours from the marked outlines, as `artrec learn-colours --params-file` learns them, written.

    :param wanted: asked before anything is written; None is returned where it no longer is.
    :raises ConfigError: an example does not tell which class its markers have, or a class is marked nowhere.
    """
    if not examples.objects:
        raise ConfigError("no example is marked yet: draw the axes of all objects of some frames")
    marks = ColourMarks(session)
    learned = marks.learn_from_axes(examples.path)
    if not wanted():
        return None
    marks.keep(learned)
    scales = marked_scales([examples.path], session.setup.targets)
    beyond = beyond_marks_px([examples.path], session.setup.targets)
    lines = [*report_colours(learned, scales=scales, beyond_px=beyond), scale_line(scales)]
    right = {name: learned.confusion[name].get(name, 0.0) for name in learned.image.classes}
    return LearnedColours(right, tuple(lines))


@dataclass(frozen=True)
class KeptScales:
    """:param low, high: the limits, px/m. :param few: how many objects they rest on, where these are few; else 0."""

    low: float
    high: float
    few: int = 0

    def __str__(self) -> str:
        rest = f"; they rest on {self.few} alone: mark nearer and farther ones, and press again" if self.few else ""
        return f"recognizer.min_scale {self.low} and max_scale {self.high} px/m are kept{rest}"


def keep_scale_limits(session: Session, examples: Examples) -> KeptScales:
    """The limits of the scale that the examples suggest, written. :raises ConfigError: no example is marked."""
    if not examples.objects:
        raise ConfigError("no example is marked yet: draw the axes of some objects")
    scales = marked_scales([examples.path], session.setup.targets)
    low, high = (float(f"{limit:.4g}") for limit in scale_limits(scales))
    session.keep({"recognizer.min_scale": low, "recognizer.max_scale": high})
    return KeptScales(low, high, len(scales) if are_few(scales) else 0)


def unread(session: Session, target: Target) -> str:
    """That the way in which an object is found reads no constraints; empty: it does."""
    way = way_of(target, session.setup.recognizer, calibrated=session.stills.camera is not None)
    whole = "is found as a whole here, from its file's geometry: constraints change nothing"
    return f"{target.name} {whole}" if way in (FACING, SPACE) else ""


def changes_of(target: Target, after: ConstraintSet) -> Iterator[Change]:
    """What differs from the constraints that the object had before."""
    before = target.constraints if isinstance(target.constraints, ConstraintSet) else None
    if before is None:
        yield Change(f"{target.model.name}: {len(after.pairs)} pairs, the first constraints")
        return
    told = 0
    for pair in after.pairs:
        old = before.pair(pair.first, pair.second)
        name = f"{'/'.join(pair.first)} - {'/'.join(pair.second)}"
        changes = [Change("new", np.inf)] if old is None else list(_sides(old, pair))
        told += len(changes)
        yield from (Change(f"{name}: {c.line}", c.moved) for c in changes)
    gone = [p for p in before.pairs if after.pair(p.first, p.second) is None]
    yield from (Change(f"{'/'.join(p.first)} - {'/'.join(p.second)}: no longer seen together", np.inf) for p in gone)
    if not (told or gone):
        yield Change(f"{target.model.name}: no range changed by more than {_TOLD_SHARE:.0%}")


def _sides(before: PairConstraint, after: PairConstraint) -> Iterator[Change]:
    """`distance_m 0.081..0.092 -> 0.079..0.095 (21 -> 24 examples)`"""
    for name, new in after.allowed.items():
        old = before.allowed.get(name)
        if old is None:
            yield Change(f"{name} is checked now", np.inf)
            continue
        width = max(old.width, new.width, after.least_width(name))
        share = max(abs(new.low - old.low), abs(new.high - old.high)) / width
        if share > _TOLD_SHARE:
            counted = f"{before.examples} -> {after.examples} examples"
            ends = f"{old.low:.3g}..{old.high:.3g} -> {new.low:.3g}..{new.high:.3g}"
            yield Change(f"{name} {ends} ({counted})", share)
