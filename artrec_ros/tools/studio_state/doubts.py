"""Which frames teach most if somebody marks them: where the recogniser is least sure, where objects jump, and where
markers are seen together as the examples hardly show them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ...core.base.errors import ImageError
from ...core.model.found import Detection
from ...core.model.frame_result import FrameResult
from .examples import Examples
from .jumps import jumps
from .rare_pairs import rare_pairs, shown_by
from .session import Session

_NARROW = 0.5  # margins below it are doubtful
_JUMP = 0.5  # what a jump is worth at the least

Worth = tuple[float, str]  # and why


@dataclass(frozen=True)
class Doubt:
    """What makes a frame worth marking. :param worth: 0: nothing to learn there. :param why: for the user."""

    number: int
    worth: float
    why: str


def recognised(
    session: Session, numbers: Iterable[int], told: Callable[[float], None], stop: Callable[[], bool] = lambda: False
) -> dict[int, FrameResult]:
    """What is found in these frames, damaged ones left out; ends early where `stop` says so.

    :param told: called with the share that is done.
    """
    results: dict[int, FrameResult] = {}
    wanted = list(numbers)
    for i, number in enumerate(wanted):
        if stop():
            break
        try:
            results[number] = session.recognise(number)
        except ImageError:
            continue  # a damaged file teaches nothing
        finally:
            told((i + 1) / len(wanted))
    return results


def ranked(session: Session, examples: Examples, results: Mapping[int, FrameResult]) -> list[Doubt]:
    """The frames that nobody has marked, what teaches most first. :param results: what is found in all frames."""
    usual = round(float(np.median([len(r.detections) for r in results.values()]))) if results else 0
    parts = _usual_parts([d for r in results.values() for d in r.detections])
    known = shown_by(examples, session.setup.targets)
    more: dict[int, list[Worth]] = {n: list(rare_pairs(r, known)) for n, r in results.items()}
    stamps = session.stills.stamps_ns
    for jump in jumps([(stamps[n], n, r) for n, r in results.items()]):
        more[jump.number].append((1 - _JUMP / jump.off, jump.why))
    doubts = [doubt_of(n, r, usual, parts, more[n]) for n, r in results.items() if not examples.is_marked(n)]
    return sorted(doubts, key=lambda d: (-d.worth, d.number))


def _usual_parts(detections: Sequence[Detection]) -> dict[str, int]:
    """Object -> how many of its components are mostly found: of one seen from the side, others are hidden."""
    names = {d.object for d in detections}
    return {name: round(float(np.median([_parts(d) for d in detections if d.object == name]))) for name in names}


def _parts(detection: Detection) -> int:
    return len({c.component for c in detection.components})


def doubt_of(number: int, result: FrameResult, usual: int, parts: dict[str, int], more: Iterable[Worth] = ()) -> Doubt:
    """:param usual: how many objects other frames show. :param parts: object -> how many components, mostly.
    :param more: what other frames and the examples say of this one."""
    known = [*_doubts(result, usual, parts), *more]
    worth, why = max(known, default=(0.0, "nothing doubtful"))
    return Doubt(number, worth, why)


def _doubts(result: FrameResult, usual: int, parts: dict[str, int]) -> Iterator[Worth]:
    lacking = usual - len(result.detections)
    if lacking > 0:
        yield 1.0 + lacking / usual, f"{lacking} of the usual {usual} objects missing"
    for d in result.detections:
        yield 1 - d.score, f"{d.name}: score {d.score:.2f}"
        if d.margin is not None and d.margin < _NARROW:
            yield 1 - d.margin, f"{d.name}: margin {d.margin:.2f}"
        usual_parts = parts.get(d.object, 0)
        if _parts(d) < usual_parts:
            yield 1 - _parts(d) / usual_parts, f"{d.name}: {_parts(d)} of the usual {usual_parts} components"
        weakest = min(d.components, key=lambda c: c.score, default=None)
        if weakest is not None:
            yield 1 - weakest.score, f"{d.name}: {weakest.component} {weakest.score:.2f}"
    if not result.detections and result.rejected:
        best = max(result.rejected, key=lambda r: r.score)
        yield 0.5 + best.score / 2, f"nothing found; {best.object} turned down: {best.reason}"
