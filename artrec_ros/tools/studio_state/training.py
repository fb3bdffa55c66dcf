"""What is learned from examples: constraints and what changed in them, colours, limits of the scale."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from ...core.base.errors import ConfigError
from ...core.constraints.constraint_set import ConstraintSet
from ...core.constraints.pairs import PairConstraint
from ...core.model.target import Target
from ...core.ways import FACING, SPACE, way_of
from ...io.learned.annotations import load_coco
from ...io.learned.constraints import save_constraints
from ...io.learned.marked_objects import marked_scales
from ..colour_report import report as report_colours
from ..colour_report import scale_limits, scale_line
from ..train import train
from ..training.train_report import report
from .colour_marks import ColourMarks
from .examples import Examples
from .session import Session

_COVERAGE, _MAX_SCALE_RATIO = 0.95, 2.0  # artrec train's defaults
_TOLD_SHARE = 0.02  # of a side of a box: smaller changes are not worth a line


@dataclass(frozen=True)
class Trained:
    """:param written: the constraint files. :param changes: what is different now. :param lines: as the command's."""

    written: tuple[Path, ...]
    changes: tuple[str, ...]
    lines: tuple[str, ...]


def train_examples(session: Session, examples: Examples) -> Trained:
    """Learns the constraints of each object that has examples, and names the files in the parameters.

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
    written: list[Path] = []
    changes: list[str] = []
    lines: list[str] = []
    parameters: dict[str, str] = {}
    for model_name, categories in by_model.items():
        targets = [t for t in session.setup.targets if t.model.name == model_name]
        training = train(targets[0].model, annotations.of(categories), _COVERAGE, _MAX_SCALE_RATIO)
        path = session.folder / f"{model_name}_constraints.yaml"
        save_constraints(path, training.constraints)
        written.append(path)
        parameters |= {f"{t.name}.constraint_file": path.name for t in targets}
        changes += changed_lines(targets[0], training.constraints)
        changes += [line for t in targets if (line := _unread(session, t))]
        lines += report(targets[0].model, training.examples, training.constraints)
    session.keep(parameters)
    return Trained(tuple(written), tuple(changes), tuple(lines))


def learn_colours(session: Session, examples: Examples) -> list[str]:
    """Colours from the marked outlines, as `artrec learn-colours --params-file` learns them, written; its lines.

    :raises ConfigError: an example does not tell which class its markers have, or a class is marked nowhere.
    """
    if not examples.objects:
        raise ConfigError("no example is marked yet: draw the axes of all objects of some frames")
    marks = ColourMarks(session)
    learned = marks.learn_from_axes(examples.path)
    marks.keep(learned)
    return [*report_colours(learned), scale_line(marked_scales([examples.path], session.setup.targets))]


def keep_scale_limits(session: Session, examples: Examples) -> tuple[float, float]:
    """The limits of the scale that the examples suggest, px/m, written. :raises ConfigError: no example is marked."""
    if not examples.objects:
        raise ConfigError("no example is marked yet: draw the axes of some objects")
    low, high = scale_limits(marked_scales([examples.path], session.setup.targets))
    limits = float(f"{low:.4g}"), float(f"{high:.4g}")
    session.keep({"recognizer.min_scale": limits[0], "recognizer.max_scale": limits[1]})
    return limits


def _unread(session: Session, target: Target) -> str:
    way = way_of(target, session.setup.recognizer, calibrated=session.stills.camera is not None)
    whole = "is found as a whole here, from its file's geometry: constraints change nothing"
    return f"{target.name} {whole}" if way in (FACING, SPACE) else ""


def changed_lines(target: Target, after: ConstraintSet) -> Iterator[str]:
    """What differs from the constraints that the object had before."""
    before = target.constraints if isinstance(target.constraints, ConstraintSet) else None
    if before is None:
        yield f"{target.model.name}: {len(after.pairs)} pairs, the first constraints"
        return
    told = 0
    for pair in after.pairs:
        old = before.pair(pair.first, pair.second)
        name = f"{'/'.join(pair.first)} - {'/'.join(pair.second)}"
        lines = [f"{name}: new"] if old is None else [f"{name}: {line}" for line in _sides(old, pair)]
        told += len(lines)
        yield from lines
    gone = [p for p in before.pairs if after.pair(p.first, p.second) is None]
    yield from (f"{'/'.join(p.first)} - {'/'.join(p.second)}: no longer seen together" for p in gone)
    if not (told or gone):
        yield f"{target.model.name}: no box changed by more than {_TOLD_SHARE:.0%}"


def _sides(before: PairConstraint, after: PairConstraint) -> Iterator[str]:
    """`distance_m 0.081..0.092 -> 0.079..0.095 (21 -> 24 examples)`"""
    for name, new in after.allowed.items():
        old = before.allowed.get(name)
        if old is None:
            yield f"{name} is checked now"
        elif max(abs(new.low - old.low), abs(new.high - old.high)) > _TOLD_SHARE * max(old.width, new.width, 1e-9):
            counted = f"{before.examples} -> {after.examples} examples"
            yield f"{name} {old.low:.3g}..{old.high:.3g} -> {new.low:.3g}..{new.high:.3g} ({counted})"
