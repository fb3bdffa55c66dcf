"""Tab Object: what the object file says, over the frame, in space, on a sheet, and on pages to be printed."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...core.drawing import object_colour
from ...core.model.target import Target
from ..studio_state import object_views
from ..studio_state.examples import Examples
from .board import Board
from .kit import Viewer, css, data_url, guarded, polygon, ui

_PAPERS = ("A4", "A3", "letter")
_STEPS = 60  # of a joint's slider
_VIEW_PX = 420


class ObjectPage:
    """One page's part."""

    def __init__(self, board: Board, examples: Examples) -> None:
        self._board, self._session, self._examples = board, board.session, examples
        self._joints: dict[str, float] = {}
        self._drawn = ""  # the object whose sliders and sheet are shown
        self._azimuth, self._elevation = -40.0, 35.0
        self._build()
        board.follow("Object", self._show)

    @property
    def _target(self) -> Target:
        return next(t for t in self._session.setup.targets if t.name == self._name.value)

    def _build(self) -> None:
        names = self._session.names
        with ui.row().classes("w-full items-center gap-2"):
            self._name = ui.toggle(names, value=names[0], on_change=lambda _: self._show())
            self._name.props("no-caps data-name=object-shown")
            self._paper = ui.select(list(_PAPERS), value="A4").props("dense")
            ui.button("Print", on_click=self._print).props("data-name=print").tooltip("a PDF at true scale")
            self._link = ui.row()
        with ui.row().classes("w-full no-wrap items-start"):
            with ui.column().classes("w-1/2 gap-1"):
                ui.label("The file's outlines where axes are marked in this frame").classes("text-sm")
                self._picture = Viewer().mark("object-picture")
            with ui.column().classes("w-1/2 gap-1"):
                self._view = ui.image("").style(f"width:{_VIEW_PX}px").props("data-name=object-view")
                self._sliders = ui.column().classes("w-full gap-0")
        self._sheet = ui.image("").classes("w-full").props("data-name=sheet fit=contain")

    def _choose(self) -> None:
        self._joints = object_views.middle(self._target)
        self._sliders.clear()
        if self._target.model.is_spatial:
            with self._sliders:
                self._slider("azimuth, deg", -180, 180, self._azimuth, self._turn)
                self._slider("elevation, deg", -85, 85, self._elevation, self._raise)
                units = object_views.joint_units(self._target)
                for name, (low, high) in object_views.joint_ranges(self._target).items():
                    titled, take = f"{name}, {units[name]}", lambda v, n=name: self._joints.update({n: v})
                    self._slider(titled, low, high, self._joints[name], take)
        self._draw_view()

    def _slider(self, name: str, low: float, high: float, value: float, take: Any) -> None:
        def moved(event: Any) -> None:
            take(float(event.value))
            number.set_text(f"{event.value:.3g}")
            self._draw_view()

        with ui.row().classes("w-full items-center no-wrap"):
            ui.label(name).classes("text-xs w-32")
            slider = ui.slider(min=low, max=high, step=(high - low) / _STEPS, value=value, on_change=guarded(moved))
            slider.props(f'throttle=150 data-name="slider-{name}"').classes("grow")
            number = ui.label(f"{value:.3g}").classes("text-xs w-16")

    def _turn(self, value: float) -> None:
        self._azimuth = value

    def _raise(self, value: float) -> None:
        self._elevation = value

    def _draw_view(self) -> None:
        drawn = object_views.picture(self._target, self._joints, self._azimuth, self._elevation)
        self._view.set_visibility(drawn is not None)
        if drawn is not None:
            self._view.set_source(data_url(drawn))

    async def _show(self) -> None:
        guarded(self._show_outlines)()
        if self._drawn == self._name.value:
            return
        self._drawn = str(self._name.value)
        guarded(self._choose)()
        sheet: NDArray[np.uint8] | None = await self._board.busy.work(
            "drawing the sheet", object_views.sheet, self._session, self._target
        )
        if sheet is not None:
            self._sheet.set_source(data_url(sheet))

    def _show_outlines(self) -> None:
        number, examples = self._board.number, self._examples
        self._picture.show(self._session.picture(number))
        shapes = []
        for o in examples.of(number):
            target = examples.target(o)
            colour = css(object_colour(self._session.names, target.name))
            shapes += [polygon(outline, colour, name, 0.1) for name, outline in object_views.outlines(o, target)]
        self._picture.draw(shapes)

    async def _print(self) -> None:
        path = await self._board.busy.work(
            "writing pages", object_views.write_pages, self._session, self._target, str(self._paper.value)
        )
        if path is not None:
            ui.notify(f"wrote {path}; print at 100 % and measure the ruler", type="positive")
            self._link.clear()
            with self._link:
                ui.button(path.name, on_click=lambda: ui.download.file(path)).props("flat no-caps data-name=pages")
