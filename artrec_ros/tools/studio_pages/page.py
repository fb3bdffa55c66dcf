"""The page as a whole, and the server that shows it."""

from __future__ import annotations

import inspect
import socket
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from ...core.base.errors import ArtrecError, ConfigError
from ..studio_state.session import Session
from .board import Board
from .colours_page import ColoursPage
from .examples_page import ExamplesPage
from .kit import HEAD, Busy, complain, ui
from .object_page import ObjectPage
from .parameters_page import ParametersPage

_TABS = ("Colours", "Examples", "Parameters", "Object")


def serve(
    session: Session, annotations: Sequence[Path], host: str, port: int, show: bool, ready: Callable[[], None]
) -> None:
    """Shows the page until it is interrupted. :param show: in the user's browser. :raises ConfigError: no such port."""
    _check_free(host, port)
    ready()
    ui.run(
        lambda: _page(session, annotations), host=host, port=port, show=show, reload=False, title="artrec studio",
        dark=None, show_welcome_message=False, reconnect_timeout=30.0,
    )  # fmt: skip


def _makers(annotations: Sequence[Path]) -> dict[str, Callable[[Board], Any]]:
    """What makes each tab's content, in their order."""
    makers: dict[str, Callable[[Board], Any]] = {
        "Colours": ColoursPage,
        "Examples": lambda board: ExamplesPage(board, annotations),
        "Parameters": ParametersPage,
        "Object": ObjectPage,
    }
    return {name: makers[name] for name in _TABS}


def _check_free(host: str, port: int) -> None:
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            raise ConfigError(f"--port {port}: cannot be used on {host}: {error.strerror}; name another one") from None


def _page(session: Session, annotations: Sequence[Path]) -> None:
    ui.add_head_html(HEAD)
    with ui.header().classes("items-center py-1 gap-4"):
        ui.label("artrec studio").classes("font-bold")
        board = Board(session, Busy())
        board.bar()
        ui.label(str(session.folder)).classes("text-xs opacity-80").tooltip("what is made here is written there")
    with ui.tabs(on_change=lambda e: board.show(str(e.value))).props("dense align=left no-caps") as tabs:
        for name in _TABS:
            ui.tab(name).props(f"data-name=tab-{name.lower()}")
    pages: dict[str, Any] = {}
    with ui.tab_panels(tabs, animated=False, keep_alive=True).classes("w-full"):
        for name, make in _makers(annotations).items():
            with ui.tab_panel(name).classes("p-2 gap-2"):
                try:
                    pages[name] = make(board)
                except ArtrecError as error:
                    complain(error)
                    ui.label(str(error)).classes("text-negative")

    async def pressed(event: Any) -> None:
        if not event.action.keydown:
            return
        answer = None
        if event.key.arrow_left or event.key.arrow_right:
            answer = board.step(1 if event.key.arrow_right else -1)
        elif event.key.name in ("Home", "End"):
            answer = board.go(0 if event.key.name == "Home" else len(session.stills) - 1)
        elif hasattr(pages.get(board.shown), "key"):
            answer = pages[board.shown].key(event.key.name)
        if inspect.isawaitable(answer):
            await answer

    ui.keyboard(pressed, ignore=["input", "select", "textarea"])
    tabs.set_value(_TABS[0])
