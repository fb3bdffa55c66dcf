"""Tab Examples: axes are drawn tail to head; the recogniser proposes, a person accepts, mends or rejects."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from ...core.drawing import object_colour
from ...core.model.frame_result import FrameResult
from ...io.learned.annotations import IDENTITY, AnnotatedObject
from ..studio_state.doubts import Doubt, ranked, recognised
from ..studio_state.examples import Examples, axes_of, identities
from ..studio_state.marking import Marking
from ..studio_state.retraining import Retraining, Told
from ..studio_state.training import LearnedColours, Trained, keep_scale_limits, learn_colours, train_examples
from .board import Board
from .kit import Point, Viewer, arrow, css, guarded, text, ui

_LISTED = 10  # frames of the queue that are shown
_FOLLOWED_S = 0.3  # between looks at what was learned meanwhile
_HELP = (
    "Drag from tail to head: the marker that is named. Click an object to choose it, drag one of its ends to mend it. "
    "Keys: p propose, a accept, A accept all, x reject or remove, s skip a marker, Enter object done, n next frame of "
    "the queue, o other object, 1 to 9 which identity."
)


class ExamplesPage:
    """One page's part. Every change is written at once."""

    def __init__(self, board: Board, examples: Examples, retraining: Retraining) -> None:
        """:param retraining: what learns of the examples, for all windows together."""
        self._board, self._session = board, board.session
        self._examples, self._retraining = examples, retraining
        self._marking = Marking(board.session, self._examples)
        self._waiting: list[Doubt] = []  # what is shown of the queue
        self._seen = Told()
        self._build()
        ui.timer(_FOLLOWED_S, self._follow)
        board.follow("Examples", guarded(self._show))

    def _build(self) -> None:
        names, m = self._session.names, self._marking
        with ui.row().classes("w-full items-center gap-2"):
            self._object = ui.toggle(names, value=names[0], on_change=lambda e: self._do(lambda: m.draw_next(e.value)))
            self._object.props("no-caps data-name=object")
            ui.button("Propose", on_click=self._propose).props("data-name=propose")
            ui.button("Accept all", on_click=lambda: self._do(m.accept_all)).props("flat data-name=accept-all")
            ui.button("Nothing here", on_click=lambda: self._do(m.nothing_here)).props("flat data-name=nothing")
            ui.button("Queue", on_click=self._rank).props("data-name=rank").tooltip("sort frames by what teaches most")
            ui.button("Train", on_click=self._train).props("data-name=train").tooltip("constraints, as artrec train")
            ui.button("Learn colours", on_click=self._learn_colours).props("data-name=colours-of-axes").tooltip(
                "from the marked outlines, as artrec learn-colours --params-file"
            )
            ui.button("Scale limits", on_click=self._scale_limits).props("flat data-name=scale-limits").tooltip(
                "keep out what is smaller or larger than what is marked, by more than a quarter, or more of few"
            )
        ui.label(_HELP).classes("text-xs opacity-70")
        for line in self._examples.misfits:
            ui.label(line).classes("text-sm text-orange").props("data-name=misfit")
        self._build_learning()
        self._hint = ui.label().classes("text-sm").props("data-name=hint")
        with ui.row().classes("w-full no-wrap items-start"):
            with ui.column().classes("w-7/12"):
                self._picture = Viewer(
                    lambda place: self._do(lambda: m.choose(np.array(place))),
                    lambda start, end: self._do(lambda: m.drag(np.array(start), np.array(end))),
                    "line",
                ).mark("examples-picture")
            with ui.column().classes("w-5/12 gap-1"):
                self._list = ui.column().classes("gap-0").props("data-name=objects")
                self._queue_list = ui.column().classes("gap-0").props("data-name=queue")
        self._told = ui.label().classes("mono").props("data-name=trained")  # as wide as the page: it has a table

    def _build_learning(self) -> None:
        """What is learned after each mark, what goes on at the moment, and what it changed."""
        r = self._retraining
        with ui.row().classes("w-full items-center no-wrap gap-2"):
            ui.label("After each mark learn").classes("text-sm shrink-0")
            ui.switch("constraints").bind_value(r, "constraints").props("dense data-name=learn-constraints")
            ui.switch("colours").bind_value(r, "colours").props("dense data-name=learn-colours").tooltip(
                "as Learn colours does; this takes some seconds"
            )
            self._learning = ui.label().classes("text-sm opacity-70 shrink-0").props("data-name=learning")
            self._stop = ui.button("Stop", on_click=r.stop).props("flat dense data-name=stop-learning")
            self._changed = ui.label().classes("text-sm").props("data-name=learned role=status")
        self._stop.set_visibility(False)

    def _follow(self) -> None:
        """What was learned meanwhile."""
        told, self._seen, before = self._retraining.told, self._retraining.told, self._seen
        if told != before:
            self._learning.set_text(f"{told.at_work} …" if told.at_work else "")
            self._stop.set_visibility(bool(told.at_work))
            self._changed.set_text(told.line)
        if told.learned != before.learned:
            self._marking.forget_proposals(here=False)
        self._show_queue()

    def key(self, name: str) -> Any:
        m = self._marking
        jobs: dict[str, Callable[[], Any]] = {
            "a": m.accept, "A": m.accept_all, "x": m.reject, "s": m.skip, "Enter": m.finish, "n": self._next,
            "o": self._other_object,
        }  # fmt: skip
        if name == "p":
            return self._propose()
        if name.isdecimal():
            return self._do(lambda: m.identify(int(name) - 1))
        return self._do(jobs[name]) if name in jobs else None

    def _do(self, job: Callable[[], Any]) -> None:
        """What a person did, and how it looks now."""
        guarded(job)()
        self._redraw()

    def _other_object(self) -> None:
        names = self._session.names
        self._object.set_value(names[(names.index(self._marking.object) + 1) % len(names)])

    async def _propose(self) -> None:
        number = self._board.number
        result: FrameResult | None = await self._board.busy.work("recognising", self._session.recognise, number)
        if result is not None and number == self._board.number:
            count = self._marking.propose(result)
            found = f"{len(result.detections)} found in {result.timing_ms['total']:.0f} ms"
            ui.notify(f"{found}, {count} of them not marked yet")
            self._redraw()

    async def _rank(self) -> None:
        found = await self._board.busy.work("looking at all frames", self._ranked)
        if found is not None:
            self._retraining.queue = found
            self._show_queue()

    def _ranked(self) -> list[Doubt]:
        results = recognised(self._session, range(len(self._session.stills)), self._board.busy.told)
        return ranked(self._session, self._examples, results)

    def _next(self) -> None:
        waiting = [d for d in self._retraining.waiting if d.number != self._board.number]
        if waiting:
            self._board.go(waiting[0].number)
        else:
            ui.notify("no frame waits; Queue sorts them anew")

    async def _train(self) -> None:
        self._retraining.stop()
        trained: Trained | None = await self._board.busy.work(
            "learning constraints", train_examples, self._session, self._examples
        )
        if trained is not None:
            self._told.set_text("\n".join([*(c.line for c in trained.changes), "", *trained.lines]))
            self._learned(f"wrote {', '.join(p.name for p in trained.written)}")
            await self._rank()

    async def _learn_colours(self) -> None:
        self._retraining.stop()
        learned: LearnedColours | None = await self._board.busy.work(
            "learning colours", learn_colours, self._session, self._examples
        )
        if learned is not None:
            self._told.set_text("\n".join(learned.lines))
            self._learned(f"wrote {self._session.parameters}")

    async def _scale_limits(self) -> None:
        kept = await self._board.busy.work("writing", keep_scale_limits, self._session, self._examples)
        if kept is not None:
            self._learned(str(kept))

    def _learned(self, told: str) -> None:
        ui.notify(told, type="positive")
        self._marking.forget_proposals()
        self._redraw()

    def _show(self) -> None:
        if self._marking.number != self._board.number:
            self._marking.look_at(self._board.number)
        self._picture.show(self._session.picture(self._board.number))
        self._redraw()

    def _redraw(self) -> None:
        m = self._marking
        self._picture.draw([shape for o in m.shown for shape in self._shapes(o)])
        key = m.next_key
        begun = " (or Enter: that is all that is seen of it)" if m.drawn is not None else ""
        self._hint.set_text(f"Draw next: {m.object} {'/'.join(key)}{begun}" if key is not None else "")
        self._show_list()
        self._show_queue()

    def _shapes(self, o: AnnotatedObject) -> list[str]:
        target, chosen = self._examples.target(o), o is self._marking.chosen
        colour = "#ffffff" if chosen else css(object_colour(self._session.names, target.name))
        axes = [axis for _, axis in axes_of(o, target.model)]
        dashed = self._marking.is_proposal(o)
        shapes = [arrow(tuple(a[0]), tuple(a[1]), colour, 3.5 if chosen else 2.0, dashed) for a in axes]
        size = self._session.stills.image(self._board.number).shape[1] / 60
        x, y = np.array([*o.points.values()]).max(axis=0)
        place: Point = (float(x) + size / 3, float(y))
        return [*shapes, text(place, self._title(o), colour, size)]

    def _title(self, o: AnnotatedObject) -> str:
        name = "_".join([o.category, *([o.attributes[IDENTITY]] if IDENTITY in o.attributes else [])])
        return f"{name}?" if self._marking.is_proposal(o) else name

    def _show_list(self) -> None:
        self._list.clear()
        own, chosen = self._examples.of(self._board.number), self._marking.chosen
        by_hand = sum(not o.by_machine for o in own)
        told = f"{len(own)} marked, {by_hand} of them by hand; {len(self._marking.proposals)} proposed"
        if self._session.stills.files[self._board.number] in self._examples.empty:
            told = "nothing here"
        with self._list:
            ui.label(told).classes("text-sm font-bold").props("data-name=count")
            known = identities(self._examples.target(chosen)) if chosen is not None else []
            with ui.row().classes("gap-1"):
                for n, name in enumerate(known):
                    button = ui.button(f"{n + 1} {name}", on_click=lambda _, n=n: self.key(str(n + 1)))
                    button.props("flat dense no-caps size=sm")

    def _show_queue(self) -> None:
        waiting = self._retraining.waiting
        if waiting == self._waiting:
            return
        self._waiting = waiting
        self._queue_list.clear()
        with self._queue_list:
            if waiting:
                ui.label("What teaches most").classes("text-sm font-bold")
            for d in waiting[:_LISTED]:
                line = ui.label(f"{self._session.stills.name(d.number)}: {d.why}").classes("text-xs cursor-pointer")
                line.on("click", lambda _, n=d.number: self._board.go(n))
