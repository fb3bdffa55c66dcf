"""Tab Live: the topic's last images; one that is taken becomes a frame of the sitting."""

from __future__ import annotations

from typing import Any

from ...core.drawing import class_picture
from ...io.sources.frames import Frame
from ..studio_state.ros import Live
from .board import Board
from .kit import Viewer, guarded, ui

_PERIOD_S = 0.3  # between pictures: that many fit through SSH


class LivePage:
    """One page's part."""

    def __init__(self, board: Board, live: Live) -> None:
        self._board, self._live = board, live
        self._frozen: tuple[Any, ...] = ()
        self._shown: Any = None
        self._count = len(board.session.stills)
        self._build()
        board.follow("Live", lambda: None)
        ui.timer(_PERIOD_S, guarded(self._turn))

    def _build(self) -> None:
        with ui.row().classes("w-full items-center gap-2"):
            self._freeze_button = ui.button("Freeze", on_click=guarded(self._freeze)).props("data-name=freeze")
            self._back = ui.slider(min=0, max=1, value=0, on_change=guarded(lambda _: self._show_frozen()))
            self._back.props("data-name=back reverse").classes("w-64 mx-2")
            self._back.tooltip("how many images back")
            ui.button("Take", on_click=guarded(self._take)).props("data-name=take")
            self._state = ui.label().classes("text-sm").props("data-name=live-state")
        ui.label(
            "f freezes, and goes on; while frozen, the slider goes back through the last images. t takes what is shown "
            "as a frame, at full quality: it is then marked and tried as those of a bag."
        ).classes("text-xs opacity-70")
        with ui.column().classes("w-7/12"):
            self._picture = Viewer().mark("live-picture")
        self._back.set_visibility(False)

    def key(self, name: str) -> Any:
        jobs = {"f": self._freeze, "t": self._take}
        return guarded(jobs[name])() if name in jobs else None

    def _turn(self) -> None:
        """What is new, in a window where this tab is seen."""
        if self._count != len(self._board.session.stills):  # taken here or in another window
            self._count = len(self._board.session.stills)
            self._board.grown()
        if self._board.shown != "Live":
            return
        self._state.set_text(self._live.state())
        held = self._live.held()
        if held and not self._frozen:
            self._show(held[-1])

    def _freeze(self) -> None:
        self._frozen = () if self._frozen else self._live.held()
        self._freeze_button.set_text("Go on" if self._frozen else "Freeze")
        self._back.set_visibility(bool(self._frozen))
        self._back.props(f"max={max(len(self._frozen) - 1, 1)}")
        self._back.set_value(0)
        self._show_frozen()

    def _show_frozen(self) -> None:
        if self._frozen:
            self._show(self._frozen[-1 - min(int(self._back.value), len(self._frozen) - 1)])

    def _show(self, held: Any) -> None:
        if held is self._shown:
            return
        self._shown = held
        frame: Frame = self._live.frame(held)
        if frame.image is None:
            self._state.set_text(f"{self._live.topic}: {frame.error}")
        else:
            image = frame.image
            self._picture.show(class_picture(image) if image.ndim == 2 else image, lossy=True)

    def _take(self) -> None:
        if self._shown is None:
            ui.notify("no image has come yet", type="warning")
            return
        before = len(self._board.session.stills)
        number = self._board.session.take(self._live.frame(self._shown))
        name = self._board.session.stills.name(number)
        self._turn()
        self._board.go(number)
        ui.notify(f"took {name}" if number >= before else f"{name} was taken before", type="positive")
