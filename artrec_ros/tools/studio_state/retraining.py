"""Learning anew in a thread while somebody marks: soon after each change, and what it changed."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ...core.base.errors import ArtrecError, one_line
from ...core.model.frame_result import FrameResult
from ...io.learned.annotations import AnnotatedObject
from .doubts import Doubt, ranked, recognised
from .examples import Examples, is_same
from .session import Session
from .training import LearnedColours, learn_colours, train_examples, unread

SETTLE_S = 1.0  # after the last mark, until is learned
_TURN_S = 0.005  # between frames, so that what a person asks for comes first
_COMPARED = 10  # frames, those that wait first, whose proposals are told to have changed before all are sorted anew
_MOVED_PX = 2.0  # what lies farther from where it was is another proposal
_PATIENCE_S = 5.0


@dataclass(frozen=True)
class Told:
    """What there is to be shown.

    :param at_work: what is being done; empty: nothing. :param line: what changed, or why nothing could be learned.
    :param learned: how often something was learned so far, by which pages see that the recogniser is another one.
    """

    at_work: str = ""
    line: str = ""
    learned: int = 0


class Retraining:
    """Learns what is switched on when examples have changed and nobody has marked for a moment. A mark that comes
    meanwhile, and `stop`, end what is under way; it leaves whole files and an order that is as old or as new.

    :ivar constraints, colours: what is learned. :ivar queue: the frames, what teaches most first; sorted anew after
        learning where it is there. :ivar told: what there is to be shown.
    """

    def __init__(self, session: Session, examples: Examples, settle_s: float = SETTLE_S) -> None:
        self._session, self._examples, self._settle_s = session, examples, settle_s
        self.constraints, self.colours = True, False
        self.queue: list[Doubt] = []
        self.told = Told()
        self._before: LearnedColours | None = None
        self._found: dict[int, FrameResult] = {}  # what was found last in each frame, by which changes are told
        self._due_s: float | None = None
        self._open = True
        self._stop = threading.Event()
        self._change = threading.Condition()
        self._thread = threading.Thread(target=self._run, name="retraining", daemon=True)
        self._thread.start()
        examples.on_change = self.changed

    @property
    def is_idle(self) -> bool:
        """Whether nothing is under way, and nothing waits."""
        with self._change:
            return self._due_s is None and not self.told.at_work

    def changed(self) -> None:
        """Examples are others now: what is being learned of the old ones ends. Returns at once."""
        with self._change:
            self._stop.set()
            self._due_s = time.monotonic() + self._settle_s if self.constraints or self.colours else None
            self._change.notify()

    def stop(self) -> None:
        """Learn nothing until the next change. Returns at once."""
        with self._change:
            if not self.is_idle:
                self._tell(line="stopped; the next mark, or Train, learns again")
            self._stop.set()
            self._due_s = None
            self._change.notify()

    def close(self) -> None:
        """Ends the thread."""
        with self._change:
            self._open = False
        self.stop()
        self._thread.join(_PATIENCE_S)

    def _run(self) -> None:
        while (stop := self._wait()) is not None:
            try:
                self._learn(stop)
            except ArtrecError as error:  # such as of a file that cannot be written
                self._tell(line=str(error))
            except Exception as error:  # a fault of this package: it costs this time, not those to come
                self._tell(line=one_line(error))
            finally:
                self._tell(at_work="")

    def _wait(self) -> threading.Event | None:
        """Until marks have settled; None: it is the end."""
        with self._change:
            while self._open:
                left_s = None if self._due_s is None else self._due_s - time.monotonic()
                if left_s is not None and left_s <= 0:
                    self._due_s, self._stop = None, threading.Event()
                    self.told = replace(self.told, at_work="learning")
                    return self._stop
                self._change.wait(left_s)
            return None

    def _tell(self, **what: object) -> None:
        with self._change:
            self.told = replace(self.told, **what)  # type: ignore[arg-type]

    def _learn(self, stop: threading.Event) -> None:
        waiting = [d.number for d in self.waiting[:_COMPARED]]
        self._found |= self._session.known(waiting)
        lines, learned = self._learn_what_is_on(lambda: not stop.is_set())
        if learned or not stop.is_set():
            self._tell(line="; ".join(lines), learned=self.told.learned + learned)
        if self.queue and not stop.is_set():
            known = {n: self._found[n] for n in waiting if learned and n in self._found}
            self._sort_queue(lambda: stop.wait(_TURN_S), known, lines)

    def _learn_what_is_on(self, wanted: Callable[[], bool]) -> tuple[list[str], bool]:
        """What changed, in lines, and whether anything was learned."""
        whole = [line for t in self._session.setup.targets if (line := unread(self._session, t))]
        reads = len(whole) < len(self._session.setup.targets)
        lines = [] if reads or self.colours or not self.constraints else [whole[0]]
        learned = False
        for on, step in ((self.constraints and reads, self._learn_constraints), (self.colours, self._learn_colours)):
            if not (on and wanted()):
                continue
            try:
                line = step(wanted)
            except ArtrecError as error:
                lines.append(f"nothing learned: {error}")
            else:
                lines += [line] if line else []
                learned |= bool(line)
        return lines, learned

    def _learn_constraints(self, wanted: Callable[[], bool]) -> str:
        self._tell(at_work="learning constraints")
        trained = train_examples(self._session, self._examples, wanted)
        return trained.headline if trained else ""

    def _learn_colours(self, wanted: Callable[[], bool]) -> str:
        self._tell(at_work="learning colours")
        colours = learn_colours(self._session, self._examples, wanted)
        if colours is None:
            return ""
        line, self._before = colours.headline(self._before), colours
        return line

    @property
    def waiting(self) -> list[Doubt]:
        """The frames of the queue that nobody has marked."""
        return [d for d in self.queue if not self._examples.is_marked(d.number)]

    def _sort_queue(self, stop: Callable[[], bool], known: Mapping[int, FrameResult], lines: Sequence[str]) -> None:
        """First the frames that wait first, to tell what has changed there; then all."""
        count = len(self._session.stills)

        def told(share: float) -> None:
            self._tell(at_work=f"looking at all frames {share:.0%}")

        first = recognised(self._session, known, lambda share: told(share * len(known) / count), stop)
        if len(first) == len(known) > 0:
            self._tell(line="; ".join([*lines, compared(self._examples, known, first)]))
        found = recognised(self._session, range(count), told, stop)
        if not stop():
            self.queue = ranked(self._session, self._examples, found)


def compared(examples: Examples, before: Mapping[int, FrameResult], after: Mapping[int, FrameResult]) -> str:
    """How many proposals of frames are others than before, in a line."""
    counts = np.zeros(4, int)
    for number, result in before.items():
        if number in after:
            old, new = (examples.proposals(number, r) for r in (result, after[number]))
            counts += _differences(examples, old, new)
    total, *changed = counts.tolist()
    what = ", ".join(f"{n} {word}" for n, word in zip(changed, ("new", "gone", "moved"), strict=True) if n)
    return f"of {total} proposals in the {len(before)} frames that wait first, {what or 'none changed'}"


def _differences(
    examples: Examples, before: Sequence[AnnotatedObject], after: Sequence[AnnotatedObject]
) -> tuple[int, int, int, int]:
    """How many there are after, and of these new, gone of those before, with other markers or places."""
    of = examples.target
    same = [(a, b) for a in after for b in before if a.category == b.category and is_same(a, b, of(a), of(b))]
    kept_after, kept_before = {id(a) for a, _ in same}, {id(b) for _, b in same}
    moved = {id(a) for a, b in same if not _alike(a, b)} - {id(a) for a, b in same if _alike(a, b)}
    return len(after), len(after) - len(kept_after), len(before) - len(kept_before), len(moved)


def _alike(a: AnnotatedObject, b: AnnotatedObject) -> bool:
    return a.points.keys() == b.points.keys() and all(
        np.linalg.norm(a.points[name] - b.points[name]) <= _MOVED_PX for name in a.points
    )
