"""The page as a whole, and the server that shows it."""

from __future__ import annotations

import inspect
import socket
from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from ...core.base.errors import ArtrecError, ConfigError
from ..studio_state.colour_marks import ColourMarks
from ..studio_state.examples import Examples
from ..studio_state.retraining import Retraining
from ..studio_state.ros import Ros
from ..studio_state.session import Session
from .board import Board
from .colours_page import ColoursPage
from .examples_page import ExamplesPage
from .failures_page import FailuresPage
from .kit import HEAD, Busy, ui
from .live_page import LivePage
from .object_page import ObjectPage
from .parameters_page import ParametersPage

_TABS = ("Live", "Colours", "Examples", "Parameters", "Object", "Failures")


@dataclass(frozen=True)
class Opened:
    """What all windows that show the page share.

    :param ros: where a live topic comes from, and nodes are asked. :param results: a folder of artrec replay to begin
        with.
    """

    session: Session
    examples: Examples
    ros: Ros
    results: Path | None = None

    @cached_property
    def colours(self) -> ColourMarks:
        """:raises ArtrecError: there are no colours to learn, or what was marked before cannot be read."""
        return ColourMarks(self.session)

    @cached_property
    def retraining(self) -> Retraining:
        """What learns while examples are marked."""
        return Retraining(self.session, self.examples)

    def close(self) -> None:
        """Ends what is being learned."""
        if "retraining" in vars(self):
            self.retraining.close()


def serve(opened: Opened, host: str, port: int, show: bool, ready: Callable[[], None]) -> None:
    """Shows the page until it is interrupted. :param show: in the user's browser. :raises ConfigError: no such port."""
    _check_free(host, port)
    ready()
    ui.run(
        lambda: _page(opened), host=host, port=port, show=show, reload=False, title="artrec studio",
        dark=None, show_welcome_message=False, reconnect_timeout=30.0,
    )  # fmt: skip


def _check_free(host: str, port: int) -> None:
    with socket.socket() as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            raise ConfigError(f"--port {port}: cannot be used on {host}: {error.strerror}; name another one") from None


def _page(opened: Opened) -> None:
    session, shown = opened.session, [name for name in _TABS if name != "Live" or opened.ros.live is not None]
    ui.add_head_html(HEAD)
    with ui.header().classes("items-center py-1 gap-4"):
        ui.label("artrec studio").classes("font-bold")
        board = Board(session, Busy(lambda: session.compiled))
        board.bar()
        ui.label(str(session.folder)).classes("text-xs opacity-80").tooltip("what is made here is written there")
        board.warnings()
    with ui.tabs(on_change=lambda e: board.show(str(e.value))).props("dense align=left no-caps") as tabs:
        for name in shown:
            ui.tab(name).props(f"data-name=tab-{name.lower()}")
    live = opened.ros.live
    makers: dict[str, Callable[[], Any]] = {
        **({"Live": lambda: LivePage(board, live)} if live is not None else {}),
        "Colours": lambda: ColoursPage(board, opened.colours),
        "Examples": lambda: ExamplesPage(board, opened.examples, opened.retraining),
        "Parameters": lambda: ParametersPage(board, opened.ros),
        "Object": lambda: ObjectPage(board, opened.examples),
        "Failures": lambda: FailuresPage(board, opened.results, lambda: tabs.set_value("Parameters")),
    }
    pages: dict[str, Any] = {}
    with ui.tab_panels(tabs, animated=False, keep_alive=True).classes("w-full"):
        for name in shown:
            with ui.tab_panel(name).classes("p-2 gap-2"):
                try:
                    pages[name] = makers[name]()
                except ArtrecError as error:  # such as of images that have no colours
                    ui.label(str(error)).classes("p-4")
    ui.keyboard(lambda event: _pressed(event, board, pages), ignore=["input", "select", "textarea"])
    tabs.set_value(next(iter(pages)))


async def _pressed(event: Any, board: Board, pages: dict[str, Any]) -> None:
    """Arrows, Home and End go through the frames; other keys are the tab's."""
    held = event.modifiers
    if not event.action.keydown or held.ctrl or held.alt or held.meta:  # those are the browser's
        return
    answer = None
    if event.key.arrow_left or event.key.arrow_right:
        answer = board.step(1 if event.key.arrow_right else -1)
    elif event.key.name in ("Home", "End"):
        answer = board.go(0 if event.key.name == "Home" else len(board.session.stills) - 1)
    elif hasattr(pages.get(board.shown), "key"):
        answer = pages[board.shown].key(event.key.name)
    if inspect.isawaitable(answer):
        await answer
