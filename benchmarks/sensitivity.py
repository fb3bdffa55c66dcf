"""What each of the method's numbers matters: every one changed by a third either way, on small fixed sets.

    python benchmarks/sensitivity.py --set config/vss.yaml FRAMES - --set config/aibo.yaml BAG TRUTH.jsonl [--flat]

A set is a parameter file, a bag or folder of images, and its truth ('-': none). Frames are decoded once, and recognised
in this process with each value; whole numbers change by one at least. Of a list of a fixed length each number changes
by itself, any other list changes as a whole. Told is what changes against the sets' own values, over all of them: in
how many frames anything is found otherwise, objects recognised, right and false, the medians of the errors of places,
turns and joints in per cent (of sets with truth), and the time a frame. 'nothing' marks a number whose change changes
nothing: one too many, unless it bounds the time of frames that are worse than these.
"""

from __future__ import annotations

import argparse
import dataclasses
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from tqdm import tqdm

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.parameters.parameter_file import Setup, load_parameters
from artrec_ros.io.parameters.specs import Spec, all_specs
from artrec_ros.io.parameters.unread import ways_taken
from artrec_ros.io.results.journal import Recognised
from artrec_ros.io.sources.frames import Frame
from artrec_ros.io.sources.opening import SourceOptions, open_sources
from artrec_ros.io.truth.reading import read_truth
from artrec_ros.tools.evaluation.assignment import match_frames
from artrec_ros.tools.evaluation.runs import Run
from artrec_ros.tools.evaluation.scoring import Options, evaluate_runs

FACTORS = (2 / 3, 4 / 3)
_ELSEWHERE = (
    "recognizer.time_budget_ms", "expert.time.",  # end searches; here none is ended
    "expert.sightings.",  # names from frame to frame
    "expert.existence.",  # and what is carried on of whether they are there
)  # fmt: skip
_UNHURRIED_MS = 600000.0


@dataclass(frozen=True)
class Outcome:
    """What was found in each frame, and what of it was right."""

    found: tuple[tuple[Any, ...], ...]
    recognised: int
    right: int
    false: int
    ms: float
    errors: tuple[tuple[float, ...], ...] = ()  # of places, turns and joints; of places and directions in the image


@dataclass(frozen=True)
class Material:
    """A set of frames. :param truth: what `evaluate_runs` takes; frames are known by their stamps."""

    name: str
    setup: Setup
    frames: tuple[Frame, ...]
    truth: Any

    @classmethod
    def load(cls, params: str, source: str, truth: str, count: int, flat: bool, topic: str | None) -> Material:
        """:param count: so many frames, evenly spread. :param flat: without calibration."""
        setup = load_parameters(params).changed({"recognizer.time_budget_ms": _UNHURRIED_MS})
        options = SourceOptions(topic=topic, image_kind=setup.image.kind, rectified=setup.image.rectified)
        with open_sources([Path(source)], options, lambda line: print(line, file=sys.stderr)) as sources:
            every = set(np.linspace(0, sources.count - 1, min(count, sources.count)).astype(int).tolist())
            frames = [frame for n, frame in enumerate(sources) if n in every and frame.image is not None]
        frames = [dataclasses.replace(f, camera=None) if flat else f for f in frames]
        material = cls(f"{Path(params).stem}, {Path(source).name}", setup, tuple(frames), None)
        return dataclasses.replace(material, truth=None if truth == "-" else material._restricted(Path(truth)))

    def _restricted(self, path: Path) -> Any:
        truth = read_truth(path)
        run = self._run(self.setup, [Recognised(f.stamp_ns, f.name) for f in self.frames])
        places = match_frames(truth, run, 0)
        return dataclasses.replace(truth, frames={key: truth.frames[key] for key in places})

    def _run(self, setup: Setup, seen: Sequence[Recognised]) -> Run:
        return Run.of(self.name, Path(self.name), setup, (s.record() for s in seen))

    def measured(self, setup: Setup) -> Outcome:
        recognizer, seen, begun = setup.build(), [], time.process_time()
        for frame in self.frames:
            assert frame.image is not None
            seen.append(Recognised(frame.stamp_ns, frame.name, recognizer.recognize(frame.image, frame.camera)))
        ms = 1e3 * (time.process_time() - begun) / len(self.frames)
        found = tuple(tuple(_told(d) for d in s.result.detections) for s in seen if s.result)
        if self.truth is None:
            return Outcome(found, 0, 0, 0, ms)
        (evaluation,) = evaluate_runs([self._run(setup, seen)], self.truth, Options())
        counts = evaluation.counts()
        places = counts.position_errors or counts.image_errors_px
        turns = counts.rotation_errors_rad or counts.direction_errors_rad
        errors = places, turns, counts.joint_errors_rad
        return Outcome(found, counts.recognised, counts.right, counts.false, ms, errors)


def _told(d: Any) -> tuple[Any, ...]:
    """A detection as far as a user can tell: a tenth of a pixel, a hundredth of a probability."""
    parts = tuple((c.component, c.marker, round(c.x, 1), round(c.y, 1), round(c.theta, 2)) for c in d.components)
    return d.object, round(d.score, 2), parts


def values_of(spec: Spec, default: Any) -> Iterator[tuple[str, Any]]:
    """A name (of an element, where it is a list of a fixed length) and a value, for each factor."""
    if not spec.length:
        for factor in FACTORS:
            every = [_scaled(spec, v, factor) for v in (default if spec.is_list else [default])]
            yield spec.name, every if spec.is_list else every[0]
        return
    items = list(default)
    for n, item in enumerate(items):
        for factor in FACTORS if item else ():
            yield f"{spec.name}[{n}]", [*items[:n], _scaled(spec, item, factor), *items[n + 1 :]]


def _scaled(spec: Spec, item: Any, factor: float) -> Any:
    value = factor * item
    if spec.type is int:
        value = min(round(value), item - 1) if factor < 1 else max(round(value), item + 1)
    low, high = (-np.inf if spec.low is None else spec.low), (np.inf if spec.high is None else spec.high)
    return spec.type(min(max(value, low), high))


def searched(sets: Sequence[Material]) -> list[Spec]:
    """The method's numbers that some set's ways of recognition read."""
    found: dict[str, Spec] = {}
    for s in sets:
        calibrated, bare = ways_taken(s.setup)
        ways = calibrated if any(f.camera for f in s.frames) else bare
        for spec in all_specs([t.name for t in s.setup.targets], s.setup.image.classes).values():
            value = s.setup.value(spec.name)
            is_number = spec.type in (int, float) and not (value is False or value in (0, [], ()))
            is_methods = spec.name.startswith(("recognizer.", "expert.")) and not spec.name.startswith(_ELSEWHERE)
            if is_methods and is_number and ways & set(spec.paths):
                found[spec.name] = spec
    return list(found.values())


@dataclass(frozen=True)
class Row:
    name: str
    value: Any
    changed: int
    recognised: int
    right: int
    false: int
    errors: tuple[float, ...]  # factors on their medians
    ms: float

    @property
    def shown(self) -> str:
        return ", ".join(f"{v:.4g}" for v in (self.value if isinstance(self.value, list) else [self.value]))

    def text(self) -> str:
        return (
            f"{self.name:44} {self.shown:>18} {self.changed:7d} {self.recognised:+11d} {self.right:+6d} "
            f"{self.false:+6d} {' '.join(f'{100 * (e - 1):+6.1f}' for e in self.errors)} {self.ms:+8.2f}"
        )


def row_of(name: str, value: Any, pairs: Sequence[tuple[Outcome, Outcome]]) -> Row:
    """:param pairs: per set, with the default and with the value."""
    changed = sum(a != b for before, after in pairs for a, b in zip(before.found, after.found, strict=True))
    recognised, right, false = (
        sum(getattr(b, f) - getattr(a, f) for a, b in pairs) for f in ("recognised", "right", "false")
    )
    errors = tuple(_factor([(a.errors[n], b.errors[n]) for a, b in pairs if a.errors]) for n in range(3))
    slower_ms = float(np.mean([b.ms - a.ms for a, b in pairs]))
    return Row(name, value, changed, recognised, right, false, errors, slower_ms)


def _factor(pairs: Sequence[tuple[Sequence[float], Sequence[float]]]) -> float:
    """By what the medians of errors grow: the geometric mean over the sets, each by its number of errors."""
    told = [(before, after) for before, after in pairs if before and after]
    logs = [np.log((np.median(after) + 1e-12) / (np.median(before) + 1e-12)) for before, after in told]
    return float(np.exp(np.average(logs, weights=[len(before) for before, _ in told]))) if told else 1.0


def _summary(outcome: Outcome) -> str:
    counts = f"{outcome.recognised} recognised, {outcome.right} right, {outcome.false} false, {outcome.ms:.1f} ms"
    return f"{sum(map(len, outcome.found))} objects told, {counts}"


def rows(sets: Sequence[Material], specs: Sequence[Spec]) -> Iterator[list[Row]]:
    """Both ways of each number."""
    for s in sets:
        s.measured(s.setup)  # compiles
    before = [s.measured(s.setup) for s in sets]
    for s, outcome in zip(sets, before, strict=True):
        print(f"{s.name}: {len(s.frames)} frames, {_summary(outcome)}")
    heads = f"{'frames':>7} {'recognised':>11} {'right':>6} {'false':>6}  place   turn  joint {'ms':>8}"
    print(f"\n{'parameter':44} {'value':>18} {heads}")
    for spec in tqdm(specs, disable=not sys.stderr.isatty()):
        mine: dict[str, list[Row]] = {}
        for same in zip(*(values_of(spec, s.setup.value(spec.name)) for s in sets), strict=True):
            name, value = same[0]
            try:
                setups = [s.setup.changed({spec.name: v}) for s, (_, v) in zip(sets, same, strict=True)]
            except ConfigError as error:
                print(f"{name} {value}: {error}")
                continue
            pairs = [(b, s.measured(setup)) for b, s, setup in zip(before, sets, setups, strict=True)]
            mine.setdefault(name, []).append(row_of(name, value, pairs))
        yield from mine.values()


def main() -> None:
    p = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    p.add_argument("--set", nargs=3, action="append", required=True, metavar=("PARAMS", "SOURCE", "TRUTH"))
    p.add_argument("--frames", type=int, default=20, help="of each set (20)")
    p.add_argument("--flat", action="store_true", help="without calibration: in the image plane")
    p.add_argument("--topic", help="the image topic of bags that have several")
    p.add_argument("--only", nargs="+", default=[""], help="parameters whose names contain one of these")
    args = p.parse_args()
    sets = [Material.load(p, s, t, args.frames, args.flat, args.topic) for p, s, t in args.set]
    idle = []
    for both in rows(sets, [s for s in searched(sets) if any(part in s.name for part in args.only)]):
        nothing = not any(row.changed for row in both)
        for row in both:
            print(row.text() + ("  nothing" if nothing else ""), flush=True)
        idle += [both[0].name] * nothing
    print(f"\nchange nothing by a third either way: {', '.join(idle) or 'none'}")


if __name__ == "__main__":
    main()
