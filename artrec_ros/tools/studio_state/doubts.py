"""Which frames teach most if somebody marks them: those in which the recogniser is least sure."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from ...core.base.errors import ImageError
from ...core.model.found import FrameResult
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
    parts = {t.name: len(t.model.components) for t in session.setup.targets}
    doubts = [doubt_of(n, r, usual, parts) for n, r in results.items() if not examples.is_marked(n)]
    return sorted(doubts, key=lambda d: (-d.worth, d.number))


def doubt_of(number: int, result: FrameResult, usual: int, parts: dict[str, int]) -> Doubt:
    """:param usual: how many objects other frames show. :param parts: object -> number of its components."""
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
        found = len({c.component for c in d.components})
        if found < parts[d.object]:
            yield 1 - found / parts[d.object], f"{d.name}: {found} of {parts[d.object]} components"
        weakest = min(d.components, key=lambda c: c.score, default=None)
        if weakest is not None:
            yield 1 - weakest.score, f"{d.name}: {weakest.component} {weakest.score:.2f}"
    if not result.detections and result.rejected:
        best = max(result.rejected, key=lambda r: r.score)
        yield 0.5 + best.score / 2, f"nothing found; {best.object} turned down: {best.reason}"
