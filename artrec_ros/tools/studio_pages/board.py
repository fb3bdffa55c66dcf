"""What all tabs have in common: the session, the frame that is looked at, and the bar to choose it."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ..studio_state.session import Session
from .kit import Busy, ui

_WARNED_S = 1.0  # between looks at what there is to be warned of


class Board:
    """:ivar number: the frame that is looked at. :ivar shown: the tab that is."""

    def __init__(self, session: Session, busy: Busy) -> None:
        self.session, self.busy = session, busy
        self.number, self.shown = 0, ""
        self._followers: dict[str, Callable[[], Any]] = {}
        self._slider: Any = None

    def follow(self, tab: str, refresh: Callable[[], Any]) -> None:
        """`refresh` is called when another frame is chosen while this tab is shown, or the tab is."""
        self._followers[tab] = refresh

    def bar(self) -> None:
        """Previous, next, a slider, and the frame's name."""
        last = len(self.session.stills) - 1
        with ui.row().classes("items-center no-wrap gap-2 grow"):
            ui.button(icon="chevron_left", on_click=lambda: self.step(-1)).props("flat dense color=white").tooltip(
                "left arrow"
            )
            self._slider = ui.slider(min=0, max=max(last, 1), value=0)
            self._slider.on("change", lambda e: self.go(int(e.args)))  # a person's; values that are set echo too late
            self._slider.props("color=white data-name=frames").classes("w-48")
            ui.button(icon="chevron_right", on_click=lambda: self.step(1)).props("flat dense color=white").tooltip(
                "right arrow"
            )
            self._name = ui.label().classes("text-sm").props("data-name=frame")
        self._tell()

    def warnings(self) -> None:
        """A line below, where there is one to tell."""
        label = ui.label().classes("w-full text-xs").props("data-name=warnings")

        def tell() -> None:
            label.set_text("; ".join(f"warning: {line}" for line in self.session.warnings))
            label.set_visibility(bool(label.text))

        tell()
        ui.timer(_WARNED_S, tell)

    def step(self, by: int) -> Any:
        return self.go(self.number + by)

    def go(self, number: int) -> Any:
        """What it returns is awaited, where it can be."""
        number = min(max(number, 0), len(self.session.stills) - 1)
        if number != self.number:
            self.number = number
            self._slider.set_value(number)
            self._tell()
            return self.refresh()
        return None

    def grown(self) -> None:
        """There are more frames than before."""
        self._slider.props(f"max={max(len(self.session.stills) - 1, 1)}")
        self._tell()

    def show(self, tab: str) -> Any:
        self.shown = tab
        return self.refresh()

    def refresh(self) -> Any:
        return self._followers[self.shown]() if self.shown in self._followers else None

    def _tell(self) -> None:
        stills = self.session.stills
        self._name.set_text(f"{self.number + 1}/{len(stills)} {stills.name(self.number)}")
