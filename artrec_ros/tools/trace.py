"""`artrec trace`: measures the outlines of an object's flat markers by images in which the object is found."""

from __future__ import annotations

import argparse
import dataclasses
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from ..core.base.errors import ConfigError, ImageError, SourceError
from ..core.geometry.transforms import Array
from ..core.model.found import Detection
from ..core.model.frame_result import FrameResult
from ..core.model.marker import Marker
from ..core.model.objects import ObjectModel
from ..core.model.target import Target
from ..io.base.bars import bar, say
from ..io.images.writing import save_drawing
from ..io.objects.object_writer import Labels, save_object
from ..io.parameters.parameter_file import Setup, load_parameters
from ..io.sources.frames import Frame, once
from ..io.sources.opening import Sources, open_sources
from .getting_ready import get_setup_ready
from .options.outputs import OF_OBJECT, check_drawing, check_output
from .options.paths import path
from .options.work_options import add_source_options, add_sources, source_options
from .training.outline_map import LEAST_IMAGES, LEAST_PX, Traced
from .training.outlines_picture import outlines_picture
from .training.seen_outlines import SeenOutlines, with_outlines

_EPILOG = """\
Where a marker's outline was drawn by eye, its object is told with too low a probability, or turned by half where it is
nearly its own mirror image. One run of the recogniser over images in which the object shows tells where the outlines
really are. Half of the images measure, the other half are recognised with both outlines, and judge.
"""
_TOLD = 0.5  # from this probability on an object counts as told in the comparison
_BETTER = 0.95  # of what differs from outlines that are drawn: what is less may be chance
_LESS = 0.75  # of the probabilities with outlines that are drawn: with less those that are measured lead astray
_BOTH = 0, 1
_BEYOND = 0.1  # of an axis outside of its outline: what marks of its ends miss is told in the scale
_PATIENCE_MS = 60000.0  # for an image: outlines are not to depend on what else the machine does
_PART = 64  # frames that are read at a time


def add_parser(subparsers: Any) -> None:
    p = subparsers.add_parser("trace", help="measure markers' outlines", description=__doc__, epilog=_EPILOG)
    add_sources(p)
    p.add_argument(
        "--params-file", required=True, type=path, action="append",
        help="the node's ROS parameter file, which names the object file; may be given again: later ones go before",
    )  # fmt: skip
    p.add_argument("--object", metavar="NAME", help="which of its objects (default: the only one)")
    p.add_argument("-o", "--output", required=True, type=path, metavar="OBJECT.yaml", help="object file to write")
    p.add_argument("--overwrite", action="store_true", help="replace OBJECT.yaml if it is there already")
    p.add_argument(
        "--picture", type=path, metavar="FILE.png", help="draw what was seen of each marker, as drawn and as measured"
    )
    add_source_options(p)
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Measures, compares, writes."""
    setup = _unhurried(load_parameters(*args.params_file))
    file, names = _object_of(setup, args.object)
    inputs = [*args.sources, *args.params_file, file]
    check_output(args.output, inputs, OF_OBJECT, overwrite=args.overwrite)
    if args.picture:
        check_drawing("--picture", args.picture, inputs)
    model = next(t.model for t in setup.targets if t.name == names[0])
    if not len(SeenOutlines(model)):
        raise ConfigError(f"{file}: it has no flat marker but discs: the shape of these is known")
    with open_sources(args.sources, source_options(args, setup), once(say)) as sources:
        get_setup_ready(setup, sources.calibrated)
        drawn = _look(setup, sources, names, _BOTH)
        if not drawn.images:
            raise SourceError(f"{', '.join(map(str, args.sources))}: holds no image that can be used")
        traced = drawn.of(_BOTH).traced()
        for line in _lines(model, traced):
            print(line)
        if not traced:
            raise SourceError(f"{file}: nothing is measured, and nothing is written")
        helps = _helps(setup, sources, names, drawn)
    _write(args, file, with_outlines(model, traced.values()) if helps else model, helps)
    if helps and any(setup.objects[name].constraint_file for name in names):
        print("Learned constraints go by outlines: artrec train anew.")
    if args.picture:
        save_drawing(args.picture, outlines_picture(list(traced.values())))
        print(f"Drew {args.picture}: blue as drawn, red as measured.")
    return 0


def _unhurried(setup: Setup) -> Setup:
    """The same with all the time that images take, whatever a live camera leaves."""
    budget_ms = max(_PATIENCE_MS, setup.recognizer.time_budget_ms)
    return dataclasses.replace(setup, recognizer=dataclasses.replace(setup.recognizer, time_budget_ms=budget_ms))


def _helps(setup: Setup, sources: Sources, names: Sequence[str], drawn: _Look) -> bool:
    """Whether outlines that half of the images measure, or where that is too few all of them, do better in the rest."""
    judging = (1,) if drawn.seen[0].images >= LEAST_IMAGES else _BOTH
    every = drawn.of(_BOTH).traced().values()
    by_others = drawn.seen[0].traced().values() if judging == (1,) else every
    if not all(any(t.differs for t in traced) for traced in (every, by_others)):
        return False
    model = next(t.model for t in setup.targets if t.name == names[0])
    tried = _with(setup, names, with_outlines(model, by_others))
    return _is_better(drawn, _look(tried, sources, names, judging, tell=lambda _: None), judging)


def _write(args: argparse.Namespace, file: Path, model: ObjectModel, helps: bool) -> None:
    if not helps:
        print("The object file holds as it is: nothing is found better, and it is copied.")
    sources = ", ".join(s.name for s in args.sources)
    comments = (f"Outlines of {file.name} as measured by `artrec trace` from {sources}.",) if helps else ()
    save_object(args.output, model, comments, Labels.as_in(file))
    print(f"Wrote {args.output}.")


def _is_better(drawn: _Look, measured: _Look, judging: Sequence[int]) -> bool:
    """Whether the class fills measured outlines better than those drawn; tells how both do."""
    before, after = (look.of(judging) for look in (drawn, measured))
    told = [sum(s >= _TOLD for half in judging for s in look.scores[half]) for look in (drawn, measured)]
    whose = "that did not measure" if len(judging) == 1 else f"that measured, too, for {2 * LEAST_IMAGES} are too few"
    print(
        f"In {sum(len(drawn.scores[half]) for half in judging)} finds in images {whose}: what shows the "
        f"class differs from the markers by {before.misfit:.1%} of their area as drawn, {after.misfit:.1%} as "
        f"measured; told at {_TOLD:g} and more {told[0]} as drawn, {told[1]} as measured."
    )
    likely = [sum(s for half in judging for s in look.scores[half]) for look in (drawn, measured)]
    return after.misfit < _BETTER * before.misfit and likely[1] >= _LESS * likely[0]


def _object_of(setup: Setup, name: str | None) -> tuple[Path, list[str]]:
    """An object's file, and the names of all objects that are described by it."""
    if name is not None and name not in setup.objects:
        raise ConfigError(f"--object: '{name}' is none of the parameters' objects ({', '.join(setup.objects)})")
    files = {n: o.object_file for n, o in setup.objects.items()}
    if name is None and len(set(files.values())) > 1:
        raise ConfigError(f"--object: the parameters have several ({', '.join(files)}); which one?")
    file = files[name or next(iter(files))]
    return Path(file), [n for n, other in files.items() if other == file]


def _with(setup: Setup, names: Sequence[str], model: ObjectModel) -> Setup:
    targets = (dataclasses.replace(t, model=model) if t.name in names else t for t in setup.targets)
    return dataclasses.replace(setup, targets=tuple(targets))


class _Look(NamedTuple):
    """What was seen in the images of even and of odd numbers: outlines, probabilities of the objects, how many."""

    seen: tuple[SeenOutlines, SeenOutlines]
    scores: tuple[list[float], list[float]]
    images: int

    def of(self, halves: Sequence[int]) -> SeenOutlines:
        return self.seen[halves[0]] if len(halves) == 1 else self.seen[0].joined(self.seen[1])


def _look(
    setup: Setup, sources: Sources, names: Sequence[str], halves: Sequence[int], tell: Callable[[str], None] = say
) -> _Look:
    """Recognises the images, each by itself."""
    targets = {t.name: t for t in setup.targets if t.name in names}
    model = next(iter(targets.values())).model
    seen, scores = (SeenOutlines(model), SeenOutlines(model)), (list[float](), list[float]())
    recognizer, images, problems = setup.build(), 0, Counter[str]()
    for number, frame in enumerate(_frames(sources)):
        half = number % 2
        if half not in halves:
            continue
        try:
            if frame.image is None:
                raise ImageError(frame.error or "no image")
            result = recognizer.recognize(frame.image, frame.camera)
        except ImageError as error:
            problems[str(error)] += 1
            if problems[str(error)] == 1:
                tell(f"{frame.name}: passed over: {error}")
            continue
        images += 1
        assert result.labels is not None  # of a frame that was recognised
        for detection in _best(result, targets):
            seen[half].add(number, result.labels, frame.camera, targets[detection.object], detection, result.detections)
            scores[half].append(detection.there)
    for problem, count in problems.items():
        if count > 1:
            tell(f"{count} images in all are passed over: {problem}")
    return _Look(seen, scores, images)


def _frames(sources: Sources) -> Iterator[Frame]:
    pieces = [(source, part) for source in sources.parts for part in source.parts(_PART)]
    with bar(total=sum(part.count for _, part in pieces), desc="recognising", unit="frame") as shown:
        for source, part in pieces:
            for frame in source.read(part):
                yield frame
                shown.update()


def _best(result: FrameResult, targets: dict[str, Target]) -> list[Detection]:
    """The objects; where there are none what comes nearest to one: an outline that is badly drawn is doubted."""
    told = [d for d in result.detections if d.object in targets]
    return told or sorted((d for d in result.doubtful if d.object in targets), key=lambda d: -d.score)[:1]


def _lines(model: ObjectModel, traced: dict[bytes, Traced]) -> Iterator[str]:
    """How each of the markers is seen."""
    shapes: dict[bytes, list[str]] = {}
    for (component, marker), m in model.markers.items():
        shapes.setdefault(m.outline.tobytes(), []).append(f"{component}/{marker}")
    for shape, markers in shapes.items():
        seen, named = traced.get(shape), ", ".join(markers)
        if seen is None:
            yield (
                f"{named}: not measured; {LEAST_IMAGES} images or more are wanted that show it, {LEAST_PX:g} pixels "
                "wide and more (discs and sides of solids stay as they are)"
            )
            continue
        holds = "" if seen.differs else f"; up to {1e3 * seen.least_m:.1f} mm may be noise: it holds"
        yield f"{named}: in {seen.images} images up to {1e3 * seen.off_m:.1f} mm off, at {_place(seen.at)}{holds}"
        if seen.hole is not None:
            yield f"note: {named}: has a hole at {_place(seen.hole)}, which an outline cannot have"
        beyond = _beyond(seen.drawn, seen.outline)
        if beyond > max(_BEYOND, _beyond(seen.drawn, seen.drawn.outline)):
            yield (
                f"warning: {named}: an end of its axis lies {1e3 * beyond * seen.drawn.axis_length:.0f} mm outside of "
                "what is measured: move it onto the rim, where it is marked, or see whether all of the marker shows"
            )
        if seen.in_one_place:
            yield f"warning: {named}: lies in one place in all images: glare or a shadow there is taken for its outline"


def _beyond(marker: Marker, outline: Array) -> float:
    """How far the ends of a marker's axis lie outside of an outline at most, as a share of the axis."""
    polygon = outline.astype(np.float32)[:, None]
    ends = (marker.tail, marker.head)
    return max(-cv2.pointPolygonTest(polygon, (float(x), float(y)), True) for x, y in ends) / marker.axis_length


def _place(at: NDArray[np.float64]) -> str:
    return "x {:.0f}, y {:.0f} mm".format(*(1e3 * at))
