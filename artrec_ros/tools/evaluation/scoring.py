"""One run against a truth: the outcome of every object of every frame, and the counts over any part of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache, cached_property, partial

from ...core.base.errors import SourceError
from ...core.geometry.camera import Camera
from ...core.model.found import Detection
from ...core.model.objects import ObjectModel
from ...io.base.yaml_files import nearest
from ...io.results.results import FrameRecord
from ...io.truth.records import FrameKey, Told, TrueObject, Truth
from .assignment import Choice, choose_objects, match_frames, repeated_frames, strangers
from .completion import undirected, with_components, with_own_names
from .metrics import Counts, judge_frame, shows_others
from .outcomes import FrameOutcome, Outcome
from .runs import Run
from .same_looks import SameLooks, siblings, turned_alike
from .slips import slips


@dataclass(frozen=True)
class ScoredFrame:
    """A frame of the truth. :param index: its place among the run's records, None: it has no result.
    :param by_name: object name -> outcome."""

    key: FrameKey
    index: int | None
    record: FrameRecord | None
    by_name: Mapping[str, FrameOutcome]


@dataclass(frozen=True)
class Evaluation:
    """A run and what became of each frame of the truth, in the truth's order.

    :param choices: the run's object names that are scored, and what the truth calls them.
    :param sliding: object name -> its prismatic joints.
    """

    run: Run
    truth: Truth
    frames: tuple[ScoredFrame, ...]
    choices: Mapping[str, Choice]
    notes: tuple[str, ...] = ()
    sliding: Mapping[str, frozenset[str]] = field(default_factory=dict)

    @property
    def names(self) -> list[str]:
        return list(self.choices)

    def outcomes(self, names: Sequence[str] | None = None) -> Iterator[tuple[str, Outcome]]:
        """Object name and outcome of every true object of these names, or of all."""
        for frame in self.frames:
            for name in self.names if names is None else names:
                yield from ((name, outcome) for outcome in frame.by_name[name].outcomes)

    def false(self, names: Sequence[str] | None = None) -> Iterator[Detection]:
        for frame in self.frames:
            for name in self.names if names is None else names:
                yield from frame.by_name[name].false

    def counts(self, name: str | None = None) -> Counts:
        """Of one object name, or of all: the frames count once."""
        names = [name] if name else self.names
        without = sum(f.index is None for f in self.frames)
        found = self.counts_of(list(self.outcomes(names)), sum(1 for _ in self.false(names)))
        return found + Counts(frames=len(self.frames), frames_without_result=without)

    def counts_of(self, outcomes: Sequence[tuple[str, Outcome]], false: int) -> Counts:
        """Of some true objects (object name, outcome) and so many false detections; without frames."""
        parts = [Counts.of([o for n, o in outcomes if n == name], self.sliding.get(name, ())) for name in self.names]
        return sum(parts, Counts(false=false))

    @cached_property
    def scores(self) -> list[tuple[float, bool]]:
        """Score and correctness of each detection, but of those that lie on an object which does not count."""
        met = [(o.detection.score, True) for _, o in self.outcomes() if o.counted and o.detection is not None]
        return met + [(d.score, False) for d in self.false()]

    @cached_property
    def used_records(self) -> list[FrameRecord]:
        """Of the frames that were looked at without an error."""
        return [f.record for f in self.frames if f.record is not None and f.record.error is None]


@dataclass(frozen=True)
class Options:
    """How runs are scored.

    :param names: the run's object name -> the truth's name or label; None: as both say.
    :param max_gap_ns: how far stamps of one frame may lie apart.
    :param common: only frames for which all runs have a result.
    :param camera: the calibration, where the truth brings none.
    """

    names: Mapping[str, str] | None = None
    max_gap_ns: int = 0
    common: bool = False
    camera: Camera | None = None


def evaluate_runs(runs: Sequence[Run], truth: Truth, options: Options) -> list[Evaluation]:
    """Every run against the truth. :raises SourceError: they have nothing in common, or something is missing."""
    matches = [match_frames(truth, run, options.max_gap_ns) for run in runs]
    kept = set(truth.frames)
    if options.common:
        kept = {key for key in truth.frames if all(key in found for found in matches)}
        if not kept:
            raise SourceError("--common: the runs have no frame of the truth in common")
    part = replace(truth, frames={key: objects for key, objects in truth.frames.items() if key in kept})
    return [_evaluate(run, part, found, options) for run, found in zip(runs, matches, strict=True)]


def _evaluate(run: Run, truth: Truth, found: Mapping[FrameKey, int], options: Options) -> Evaluation:
    choices = choose_objects(truth, run, options.names)
    camera = options.camera or truth.camera
    complete = {name: _completer(run, name, truth, camera) for name in choices}
    looks = {name: cache(partial(SameLooks.of, run.models[name])) for name in choices if name in run.models}
    others = {name: cache(partial(siblings, run.models[name])) for name in choices if name in run.models}
    frames = []
    for key, objects in truth.frames.items():
        record = run.records[found[key]] if key in found else None
        by_name = {
            name: _alike(
                _judge(choice.of(objects), name, record, run, complete[name], others.get(name)), looks.get(name)
            ).but_in(truth.crowds.get(key, ()))
            for name, choice in choices.items()
        }
        frames.append(ScoredFrame(key, found.get(key), record, by_name))
    sliding = {name: _sliding(run.models[name]) for name in choices if name in run.models}
    scored = Evaluation(run, truth, tuple(frames), choices, tuple(_notes(run, truth, found, choices)), sliding)
    outcomes = list(scored.outcomes())
    noted = (
        *_turned_away(scored), *_undirected(scored), *slips(outcomes, sliding), *turned_alike(outcomes)
    )  # fmt: skip
    return replace(scored, notes=(*scored.notes, *noted))


def _turned_away(scored: Evaluation) -> Iterable[str]:
    """What is plainly in view and does not count."""
    for name in scored.names:
        others = [o for _, o in scored.outcomes([name]) if not o.counted and shows_others(o.truth)]
        if others:
            found = sum(o.detection is not None for o in others)
            yield (
                f"{len(others)} more of the truth's '{name}' show other components, but too little of the required "
                f"one, '{scored.run.objects[name].required}': they do not count; {found} of them are found"
            )


def _undirected(scored: Evaluation) -> Iterable[str]:
    """Why no direction is told where axes are annotated."""
    turns = [rad for _, o in scored.outcomes() for _, rad in o.image_errors]
    if turns and all(rad is None for rad in turns):
        yield (
            "no direction is judged: all markers that are annotated look the same in any turn, as discs do, and no two "
            "of one object are found whose places would tell it"
        )


def _judge(
    objects: Sequence[TrueObject],
    name: str,
    record: FrameRecord | None,
    run: Run,
    complete: Callable[[TrueObject], TrueObject],
    siblings_of: Callable[[], Sequence[Mapping[str, str]]] | None,
) -> FrameOutcome:
    """:param siblings_of: of the object, asked where something is wrong: they take a while to find."""
    detections = [d for d in record.detections if d.object == name and not d.predicted] if record else []
    true, required = [complete(o) for o in objects], run.objects[name].required
    outcome = judge_frame(true, detections, required)
    if siblings_of is None or not (true and detections) or outcome.all_well:
        return outcome
    return judge_frame(true, detections, required, siblings_of())


def _alike(frame: FrameOutcome, looks: Callable[[], SameLooks] | None) -> FrameOutcome:
    """The same with the turns after which the object looks the same, where that matters: they take a while to find."""
    if looks is None or not any(o.turn_told_rad for o in frame.outcomes):
        return frame
    return replace(frame, outcomes=tuple(replace(o, looks=looks()) for o in frame.outcomes))


def _completer(run: Run, name: str, truth: Truth, camera: Camera | None) -> Callable[[TrueObject], TrueObject]:
    """What adds components to the true objects of a name, where the truth does not bring them."""
    kinds, model = {o.told for o in truth.objects()}, run.models.get(name)
    if kinds <= {Told.ALL}:
        return (lambda o: with_own_names(o, model)) if model is not None else (lambda o: o)
    if model is None:
        reason = run.problem or "the run's parameters name none"
        raise SourceError(f"{run.folder}: this truth needs the object file of '{name}': {reason}")
    if Told.REQUIRED in kinds:
        if camera is None:
            raise SourceError(
                f"{truth.source}: no calibration beside these poses; give one with --camera-info FILE.yaml"
            )
        if all(m.T_component_marker is None for m in model.required.markers):
            raise SourceError(
                f"'{name}': poses are no truth for it: its file tells no marker's pose on '{model.required.name}'"
            )
    round_ones = undirected(model)
    return lambda o: replace(with_components(o, model, camera), undirected=round_ones & o.axes.keys())


def _sliding(model: ObjectModel) -> frozenset[str]:
    return frozenset(name for name, joint in model.joints.items() if joint.kind == "prismatic")


def _unknown(objects: Sequence[TrueObject], name: str, model: ObjectModel) -> Iterable[str]:
    """What the truth tells of components and joints that the object does not have: slips of names, mostly."""
    mine = [c.name for c in model.components]
    parts = {part.partition("@")[0] for o in objects for part in o.components}
    strange = [p for p in sorted(parts) if not any(p == c or p.startswith(f"{c}_") for c in mine)]
    joints = sorted({joint for o in objects for joint in o.joints} - {*model.joint_names})
    for what, names, known in (("component", strange, mine), ("joint", joints, model.joint_names)):
        for other in names if known else ():
            yield f"the truth's {what} '{other}' is none of '{name}'{nearest(other, known)}"


def _notes(run: Run, truth: Truth, found: Mapping[FrameKey, int], choices: Mapping[str, Choice]) -> Iterable[str]:
    yield from run.notes
    yield from truth.problems
    if truth.left_out:
        yield f"{truth.left_out} images whose annotations the recogniser made are left out: they are no truth"
    told = {o.told for o in truth.objects()}
    if Told.REQUIRED in told:
        yield "the truth tells poses alone: hidden objects count as in view, and configurations are not judged"
    if Told.LABELLED in told:
        yield "the truth tells annotated markers alone: components that are found without an annotation are not judged"
    if missing := sum(key not in found for key in truth.frames):
        yield (
            f"{missing} of {len(truth.frames)} frames of the truth have no result; their objects count as missed, and "
            "they among the frames without a false one"
        )
    if unjudged := len(run.records) - len(set(found.values())) - repeated_frames(truth, run):
        yield f"{unjudged} of {len(run.records)} results are of frames that the truth does not have: not judged"
    if repeated := repeated_frames(truth, run):
        yield f"{repeated} results have the stamp or name of a later one, which counts in their place"
    for name, count in strangers(truth, choices).items():
        yield f"{count} objects '{name}' of the truth were not looked for: not scored"
    for name, choice in choices.items():
        if name in run.models:
            yield from _unknown(choice.of(list(truth.objects())), name, run.models[name])
    if truth.frame_id and run.frame_id and truth.frame_id != run.frame_id:
        yield f"the truth's poses are in frame '{truth.frame_id}', the results' in '{run.frame_id}': are they the same?"
