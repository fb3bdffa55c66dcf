"""The frames that are tuned on: recognised under any parameters, compared with their truth."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...core.base.errors import SourceError
from ...core.geometry.transforms import Array
from ...io.parameters.parameter_file import Setup
from ...io.results.journal import Recognised
from ...io.sources.frames import Part, Source
from ...io.truth.records import FrameKey, TrueObject, Truth
from ..evaluation.assignment import match_frames
from ..evaluation.runs import Run
from ..evaluation.scoring import Evaluation, Options, evaluate_runs
from ..replaying.engines import Engine, Job
from ..replaying.work import Order, work

PART_FRAMES = 8


@dataclass(frozen=True)
class Piece:
    """A part of a source. :param first: the number of its first frame among the frames of all sources."""

    name: str
    source: int
    first: int
    part: Part


def pieces_of(sources: Sequence[tuple[str, Source]]) -> list[Piece]:
    """All frames of some sources, in order, `PART_FRAMES` a piece. :param sources: with their names."""
    pieces, first = [], 0
    for number, (name, source) in enumerate(sources):
        for part in source.parts(PART_FRAMES):
            pieces.append(Piece(name, number, first, part))
            first += part.count
    return pieces


def recognise(
    engine: Engine,
    order: Order,
    pieces: Sequence[Piece],
    numbers: Collection[int],
    take: Callable[[int, Recognised], None],
    note: Callable[[str], None],
) -> None:
    """Frames of these numbers go to `take`, in any order; some are missing if the engine was stopped."""
    packed, left = order.packed(), iter(pieces)
    piece, mine = next(left, None), set()
    while True:
        while engine.free and piece is not None:
            places = [i for i in range(piece.part.count) if piece.first + i in numbers]
            if places:
                name = f"{piece.name}, frames {piece.part.first} to {piece.part.first + piece.part.count - 1}"
                arguments = (packed, "recognise", piece.source, piece.part, places)
                job = Job(name, piece, work, arguments)
                mine.add(job)
                engine.submit(job)
            piece = next(left, None)
        if not engine.busy:
            return
        for done in engine.wait():
            if done.job not in mine:  # of an earlier run, which an error ended
                continue
            for seen in done.items:
                take(done.job.tag.first + seen.place, seen.frame)
                for line in seen.notes:
                    note(line)


@dataclass(frozen=True)
class Material:
    """Frames with truth, by their numbers among the frames of all sources."""

    frames: Mapping[FrameKey, tuple[TrueObject, ...]]
    truth: Truth  # what all frames have in common; its own frames are not used
    options: Options

    @property
    def numbers(self) -> list[int]:
        return [n for n in self.frames if isinstance(n, int)]

    def evaluated(
        self, setup: Setup, seen: Mapping[int, Recognised], numbers: Collection[int], name: str
    ) -> Evaluation:
        """How these frames, recognised with this set-up, compare with their truth."""
        records = [dataclasses.replace(frame.record(), stamp_ns=n) for n, frame in sorted(seen.items())]
        run = Run.of(name, Path(name), setup, records)
        truth = dataclasses.replace(self.truth, frames=dict(self.frames))
        (whole,) = evaluate_runs([run], truth, self.options)
        chosen = set(numbers)
        return dataclasses.replace(whole, frames=tuple(f for f in whole.frames if f.key in chosen))


def material_of(
    pieces: Sequence[Piece], seen: Mapping[int, Recognised], truths: Sequence[Truth], options: Options
) -> Material:
    """The frames of which a truth speaks.

    :param seen: all frames. :param truths: one for each source, or one for all.
    :raises SourceError: a source and its truth have no frame in common.
    """
    frames: dict[int, tuple[TrueObject, ...]] = {}
    crowds: dict[FrameKey, tuple[Array, ...]] = {}
    sources = sorted({p.source for p in pieces})
    for source in sources:
        own = [p for p in pieces if p.source == source]
        numbers = [p.first + i for p in own for i in range(p.part.count)]
        truth = truths[source if len(truths) > 1 else 0]
        run = Run(own[0].name, Path(own[0].name), tuple(seen[n].record() for n in numbers), {}, {})
        found = match_frames(truth, run, options.max_gap_ns)
        frames.update({numbers[place]: truth.frames[key] for key, place in found.items()})
        crowds.update({numbers[place]: truth.crowds[key] for key, place in found.items() if key in truth.crowds})
    camera = options.camera or truths[0].camera
    common = Truth({}, ", ".join(t.source for t in truths), camera, truths[0].frame_id, crowds=crowds)
    ordered: dict[FrameKey, tuple[TrueObject, ...]] = {n: frames[n] for n in sorted(frames)}
    return Material(ordered, common, dataclasses.replace(options, max_gap_ns=0))


@dataclass(frozen=True)
class Split:
    """Which frames are tuned on, and which are held out."""

    tuned_on: tuple[int, ...]
    held_out: tuple[int, ...]


def split(numbers: Sequence[int], share: float, block: int, seed: int) -> Split:
    """A random share of the frames is held out, in blocks of frames that follow each other.

    :raises SourceError: either part would be empty.
    """
    blocks = [list(numbers[i : i + block]) for i in range(0, len(numbers), block)]
    count = round(share * len(blocks))
    if not 0 < count < len(blocks):
        raise SourceError(
            f"--held-out {share:g} of {len(numbers)} frames with truth in blocks of {block} leaves {count} of "
            f"{len(blocks)} blocks held out: both parts need one or more"
        )
    held = set(np.random.default_rng(seed).permutation(len(blocks))[:count].tolist())
    parts: tuple[list[int], list[int]] = ([], [])
    for i, frames in enumerate(blocks):
        parts[i in held].extend(frames)
    return Split(tuple(parts[0]), tuple(parts[1]))
