"""Which frames teach most if somebody marks them: those in which the recogniser is least sure."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ...core.base.errors import ImageError
from ...core.model.found import Detection, FrameResult
from .examples import Examples
from .session import Session

_NARROW = 0.5  # margins below it are doubtful


@dataclass(frozen=True)
class Doubt:
    """What makes a frame worth marking. :param worth: 0: nothing to learn there. :param why: for the user."""

    number: int
    worth: float
    why: str


def ranked(session: Session, examples: Examples, told: Callable[[float], None]) -> list[Doubt]:
    """The frames that nobody has marked, what teaches most first. :param told: called with the share that is done."""
    results: dict[int, FrameResult] = {}
    for number in range(len(session.stills)):
        try:
            results[number] = session.recognise(number)
        except ImageError:
            continue  # a damaged file teaches nothing
        finally:
            told((number + 1) / len(session.stills))
    usual = round(float(np.median([len(r.detections) for r in results.values()]))) if results else 0
    parts = _usual_parts([d for r in results.values() for d in r.detections])
    doubts = [doubt_of(n, r, usual, parts) for n, r in results.items() if not examples.is_marked(n)]
    return sorted(doubts, key=lambda d: (-d.worth, d.number))


def _usual_parts(detections: Sequence[Detection]) -> dict[str, int]:
    """Object -> how many of its components are mostly found: of one seen from the side, others are hidden."""
    names = {d.object for d in detections}
    return {name: round(float(np.median([_parts(d) for d in detections if d.object == name]))) for name in names}


def _parts(detection: Detection) -> int:
    return len({c.component for c in detection.components})


def doubt_of(number: int, result: FrameResult, usual: int, parts: dict[str, int]) -> Doubt:
    """:param usual: how many objects other frames show. :param parts: object -> how many components, mostly."""
    known = list(_doubts(result, usual, parts))
    worth, why = max(known, default=(0.0, "nothing doubtful"))
    return Doubt(number, worth, why)


def _doubts(result: FrameResult, usual: int, parts: dict[str, int]) -> Iterator[tuple[float, str]]:
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
