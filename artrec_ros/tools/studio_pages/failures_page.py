"""Tab Failures: the frames in which a replay failed; a click leads to the frame."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from ..studio_state.failures import Shown, load_failures
from .board import Board
from .kit import ui

_CARD_PX = 330


class FailuresPage:
    """One page's part."""

    def __init__(self, board: Board, results: Path | None, look: Callable[[], Any]) -> None:
        """:param results: a folder of artrec replay to begin with. :param look: shows the tab where frames are seen."""
        self._board, self._look = board, look
        with ui.row().classes("w-full items-center gap-2"):
            self._folder = ui.input("folder of artrec replay", value=str(results or "")).classes("w-72")
            self._folder.props("dense data-name=results")
            self._truth = ui.input("truth (else as it was evaluated)").classes("w-72").props("dense data-name=truth")
            ui.button("Show", on_click=self._load).props("data-name=show-failures")
            self._count = ui.label().classes("text-sm").props("data-name=failed-count")
        self._cards = ui.row().classes("w-full gap-2 items-stretch").props("data-name=failures")
        self._fresh = results is not None
        board.follow("Failures", self._show)

    async def _show(self) -> None:
        if self._fresh:
            self._fresh = False
            await self._load()

    async def _load(self) -> None:
        folder, truth = Path(str(self._folder.value).strip()), str(self._truth.value or "").strip()
        shown: list[Shown] | None = await self._board.busy.work(
            "scoring", load_failures, folder, Path(truth) if truth else None, self._board.session.stills
        )
        if shown is None:
            return
        self._count.set_text(f"frames that failed: {len(shown)}")
        self._cards.clear()
        with self._cards:
            for one in shown:
                self._card(one)

    def _card(self, shown: Shown) -> None:
        with ui.card().classes("p-1 gap-1 cursor-pointer").style(f"width:{_CARD_PX}px") as card:
            if shown.card.picture:
                ui.image(shown.card.picture).classes("w-full")
            ui.label(shown.key).classes("text-xs font-bold")
            for reason in shown.reasons:
                ui.label(reason).classes("text-xs")
        card.on("click", lambda _: self._go(shown))

    def _go(self, shown: Shown) -> Any:
        if shown.number is None:
            count = len(self._board.session.stills.stamps_ns)
            told = f"{shown.key} is none of the {count} frames that are open here; start with a larger --frames"
            ui.notify(told, type="warning")
            return None
        self._board.go(shown.number)
        return self._look()
