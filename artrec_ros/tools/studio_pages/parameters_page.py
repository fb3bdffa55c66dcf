"""Tab Parameters: each with its range and meaning; the overlay before and after, side by side."""

from __future__ import annotations

import html
from collections import defaultdict
from typing import Any

from ...core.base.errors import ArtrecError
from ...core.model.frame_result import FrameResult
from ...io.parameters.parameter_file import Setup
from ...io.parameters.specs import EXPERT, Spec
from ..studio_state.ros import Ros
from ..studio_state.settings import Settings, read_list
from .board import Board
from .kit import Viewer, complain, ui
from .nodes_part import NodesPart

_STEPS = 200  # of a slider
_WIDEST = 1e5  # ranges beyond have no slider: a step would be too coarse
_MOST_REASONS = 40


class ParametersPage:
    """One page's part. Nothing is written until `Save`."""

    def __init__(self, board: Board, ros: Ros) -> None:
        """:param ros: through which nodes are asked that run."""
        self._board, self._settings = board, Settings(board.session)
        self._listed: Setup | None = None  # the saved parameters that the list shows
        self._fields: dict[str, Any] = {}
        self._sliders: dict[str, Any] = {}
        self._build(ros)
        board.follow("Parameters", self._show)

    def _build(self, ros: Ros) -> None:
        with ui.row().classes("w-full items-center gap-2"):
            self._find = ui.input(placeholder="find a parameter", on_change=lambda _: self._list())
            self._find.props("dense clearable data-name=find").classes("w-56")
            self._experts = ui.switch("for experts, too", on_change=lambda _: self._list()).props("data-name=experts")
            ui.button("Save", on_click=self._save).props("data-name=save-parameters")
            ui.button("Reset", on_click=self._reset).props("flat data-name=reset")
            with ui.button("Score", on_click=self._score).props("data-name=score"):
                ui.tooltip("before and after, on the frames that are marked by hand, as artrec evaluate").props(
                    'anchor="top middle" self="bottom middle"'  # below it would hide the headings
                )
            self._changed = ui.label().classes("text-sm").props("data-name=changed")
        self._unread = ui.label().classes("text-sm text-orange").props("data-name=unread")
        self._unread.style("min-height: 1.25rem")  # its line: else sliders move away under the mouse
        with ui.row().classes("w-full no-wrap items-start"):
            with ui.column().classes("w-1/3 gap-0").style("max-height:80vh;overflow:auto"):
                self._rows = ui.column().classes("w-full gap-1").props("data-name=parameters")
            with ui.column().classes("w-2/3 gap-1"):
                with ui.row().classes("w-full no-wrap"):
                    self._sides = [self._side("before"), self._side("after")]
                self._scores = ui.label().classes("mono").props("data-name=scores")
                NodesPart(self._board.busy, self._settings, ros)
        self._list()

    def _side(self, name: str) -> tuple[Any, Viewer, Any]:
        with ui.column().classes("w-1/2 gap-1"):
            caption = ui.label(name).classes("text-sm font-bold").props(f"data-name=caption-{name}")
            viewer = Viewer().mark(f"parameters-{name}")
            reasons = ui.html("", sanitize=False).classes("text-xs").props(f"data-name=reasons-{name}")
        return caption, viewer, reasons

    # the list of parameters

    def _list(self) -> None:
        """Groups of those that are looked for."""
        self._listed = self._board.session.setup
        self._rows.clear()
        self._fields.clear()
        self._sliders.clear()
        wanted, groups = str(self._find.value or "").lower(), defaultdict(list)
        for name, spec in self._settings.specs().items():
            if wanted in f"{name} {spec.description}".lower() and (self._experts.value or not name.startswith(EXPERT)):
                groups[name.rpartition(".")[0]].append(spec)
        with self._rows:
            for group, specs in groups.items():
                opened = bool(wanted) or group == "recognizer"
                with ui.expansion(group or "node", value=opened).classes("w-full").props("dense switch-toggle-side"):
                    for spec in specs:
                        self._row(spec)

    def _row(self, spec: Spec) -> None:
        with ui.row().classes("w-full items-center no-wrap gap-2"):
            label = ui.label(spec.name.rpartition(".")[2]).classes("text-xs w-2/5")
            label.tooltip(f"{spec.description}. {_range(spec)}")
            self._fields[spec.name] = self._field(spec)

    def _field(self, spec: Spec) -> Any:
        value = self._settings.value(spec.name)
        named = f"data-name=field-{spec.name}"
        if spec.is_list:
            field = ui.input(value=", ".join(map(str, value))).props(f"dense {named}").classes("grow")
            for event in ("keydown.enter", "blur"):
                field.on(event, lambda _, f=field: self._take_list(spec, str(f.value)))
            return field
        if spec.type is bool:
            return ui.switch(value=value, on_change=lambda e: self._take(spec, bool(e.value))).props(f"dense {named}")
        if spec.choices:
            field = ui.select(list(spec.choices), value=value, on_change=lambda e: self._take(spec, e.value))
            return field.props(f"dense {named}").classes("grow")
        if spec.type is str:
            field = ui.input(value=value).props(f"dense {named}").classes("grow")
            field.on("keydown.enter", lambda _: self._take(spec, str(field.value)))
            return field
        return self._number(spec, value, named)

    def _number(self, spec: Spec, value: float, named: str) -> Any:
        # without limits of its own, which would make another number of what was typed
        number = ui.number(value=value).props(f"dense {named}").classes("w-24")
        for event in ("keydown.enter", "blur"):
            number.on(event, lambda _: self._take(spec, number.value))
        if spec.low is not None and spec.high is not None and spec.high - spec.low <= _WIDEST:
            step = 1 if spec.type is int else (spec.high - spec.low) / _STEPS
            slider = ui.slider(min=spec.low, max=spec.high, step=step, value=value).classes("grow")
            slider.props(f"dense data-name=slider-{spec.name}")
            self._sliders[spec.name] = slider
            slider.on("change", lambda e: self._take(spec, e.args))
            slider.on("update:model-value", lambda e: number.set_value(round(e.args, 6)), throttle=0.1)
        return number

    async def _take_list(self, spec: Spec, text: str) -> None:
        try:
            values = read_list(text)
        except ArtrecError as error:
            complain(error)
            return
        await self._take(spec, [spec.type(v) if spec.type is float and isinstance(v, int) else v for v in values])

    async def _take(self, spec: Spec, value: Any) -> None:
        if value is None:  # of a field that was emptied
            self._show_value(spec)
        if value is None or value == self._settings.value(spec.name):
            return
        if spec.type in (int, float) and not spec.is_list and spec.type(value) == value:  # else it is refused as it is
            value = spec.type(value)
        try:
            self._settings.change(spec.name, value)
        except ArtrecError as error:
            complain(error)
            self._show_value(spec)
            return
        self._show_value(spec)
        await self._show()

    def _show_value(self, spec: Spec) -> None:
        """As it is tried now, wherever it was changed."""
        value = self._settings.value(spec.name)
        self._fields[spec.name].set_value(", ".join(map(str, value)) if spec.is_list else value)
        if spec.name in self._sliders:
            self._sliders[spec.name].set_value(value)

    # results

    async def _show(self) -> None:
        if self._listed is not self._board.session.setup:  # something was learned meanwhile
            self._list()
        changes = self._settings.changes
        told = ", ".join(f"{name}: {value}" for name, value in changes.items())
        self._changed.set_text(f"tried: {told}" if told else "nothing is changed")
        self._unread.set_text("; ".join(self._settings.unread()))
        number = self._board.number
        both = await self._board.busy.work("recognising", self._settings.both, number)
        if both is None:
            return
        if number != self._board.number or dict(self._settings.changes) != dict(changes):
            return await self._show()
        for (caption, viewer, reasons), name, result in zip(self._sides, ("before", "after"), both, strict=True):
            self._show_side(caption, viewer, reasons, name, result)

    def _show_side(self, caption: Any, viewer: Viewer, reasons: Any, name: str, result: FrameResult) -> None:
        ended = f", ended by {', '.join(result.ended_by)}" if result.ended_by else ""
        caption.set_text(f"{name}: {len(result.detections)} found, {result.timing_ms['total']:.0f} ms{ended}")
        viewer.show(self._board.session.overlay(self._board.number, result))
        reasons.set_content(_table(result))

    async def _score(self) -> None:
        lines = await self._board.busy.work("scoring", self._settings.scored, self._board.busy.told)
        if lines is not None:
            self._scores.set_text("\n".join(lines))

    async def _save(self) -> None:
        if await self._board.busy.work("writing", self._saved):
            ui.notify(f"wrote {self._board.session.parameters}", type="positive")
        self._list()
        await self._show()

    def _saved(self) -> bool:
        self._settings.save()
        return True

    async def _reset(self) -> None:
        self._settings.reset()
        self._list()
        await self._show()


def _range(spec: Spec) -> str:
    low, high = ("" if v is None else f"{v:g}" for v in (spec.low, spec.high))
    ends = f"{low} to {high} {spec.unit}".strip() if low or high else spec.unit
    return f"{ends}; default {spec.default}" if ends else f"Default {spec.default}"


def _table(result: FrameResult) -> str:
    """What was found, then what was turned down, each with why."""
    rows = [
        f"<tr><td><b>{html.escape(d.name)}</b></td><td>{d.score:.2f}</td><td>{len(d.components)} components</td></tr>"
        for d in sorted(result.detections, key=lambda d: -d.score)
    ]
    rejected = sorted(result.rejected, key=lambda r: -r.score)
    rows += [
        f"<tr><td>{html.escape(r.object)}</td><td>{r.score:.2f}</td>"
        f"<td>({r.x:.0f}, {r.y:.0f}) {html.escape(r.reason)}</td></tr>"
        for r in rejected[:_MOST_REASONS]
    ]
    more = f"<tr><td></td><td></td><td>and {len(rejected) - _MOST_REASONS} more</td></tr>"
    body = "".join([*rows, more if len(rejected) > _MOST_REASONS else ""])
    return f'<table class="told">{body}</table>'
