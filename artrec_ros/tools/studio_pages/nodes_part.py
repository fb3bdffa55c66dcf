"""Part of the tab Parameters: what differs on a node that runs, and setting it there."""

from __future__ import annotations

import html
from collections.abc import Mapping
from typing import Any

from ..studio_state.ros import Ros
from ..studio_state.running_nodes import Difference, differences, set_on_node
from ..studio_state.settings import Settings
from .kit import Busy, ui

_LONGEST = 60  # characters of a value that are shown


class NodesPart:
    """Finds recogniser nodes, shows the differences to what is tried, sets those that can be set while a node runs."""

    def __init__(self, busy: Busy, settings: Settings, ros: Ros) -> None:
        self._busy, self._settings, self._ros = busy, settings, ros
        with ui.row().classes("w-full items-center gap-2 pt-2"):
            ui.label("Running node").classes("text-sm font-bold")
            ui.button("Find", on_click=self._find).props("flat data-name=find-nodes").tooltip(
                "recogniser nodes of the ROS graph"
            )
            self._node = ui.select([], on_change=self._compare).props("dense data-name=node").classes("w-64")
            self._set_button = (
                ui.button("Set on it", on_click=self._set)
                .props("data-name=set-on-node")
                .tooltip("what can be set while it runs, as it is tried here")
            )
            self._told = ui.label().classes("text-sm").props("data-name=node-told role=status")
        self._table = ui.html("", sanitize=False).classes("text-xs").props("data-name=node-differences")
        self._show_controls()

    def _show_controls(self) -> None:
        for control in (self._node, self._set_button):
            control.set_visibility(bool(self._node.options))

    async def _find(self) -> None:
        self._told.set_text("looking for recogniser nodes …")
        found: list[str] | None = await self._busy.work("asking the graph", lambda: self._ros.parameters().nodes())
        self._told.set_text("")
        if found is None:
            return
        kept = self._node.value if self._node.value in found else next(iter(found), None)
        is_another = kept != self._node.value  # which is compared as soon as it is chosen
        self._node.set_options(found, value=kept)
        self._show_controls()
        if not found:
            self._told.set_text("no recogniser node answers; ROS_DOMAIN_ID and the network decide which can be seen")
            self._table.set_content("")
        elif not is_another:
            await self._compare()

    def _differences(self) -> list[Difference]:
        return differences(self._settings.tried, self._ros.parameters(), str(self._node.value))

    async def _compare(self) -> None:
        if not self._node.value:
            return
        found: list[Difference] | None = await self._busy.work("asking the node", self._differences)
        if found is not None:
            self._show(found, {})

    async def _set(self) -> None:
        done: tuple[list[Difference], dict[str, str], int] | None = await self._busy.work("setting", self._set_all)
        if done is not None:
            left, refused, count = done
            self._show(left, refused)
            told = f"{count - len(refused)} of {count} set"
            self._told.set_text(f"{told}; {len(refused)} refused" if refused else told)

    def _set_all(self) -> tuple[list[Difference], dict[str, str], int]:
        found = self._differences()
        refused = set_on_node(found, self._ros.parameters(), str(self._node.value))
        return self._differences(), refused, sum(d.is_live for d in found)

    def _show(self, found: list[Difference], refused: Mapping[str, str]) -> None:
        live = sum(d.is_live for d in found)
        told = f"{live} differ and can be set, {len(found) - live} need a restart"
        self._told.set_text(told if found else "all parameters are as here")
        rows = "".join(_row(d, refused) for d in found)
        heads = "<tr><th></th><th>here</th><th>on the node</th><th></th></tr>"
        self._table.set_content(f'<table class="told">{heads}{rows}</table>' if found else "")


def _row(d: Difference, refused: Mapping[str, str]) -> str:
    reason = refused.get(d.spec.name)
    what = f"refused: {reason}" if reason else "can be set" if d.is_live else "needs a restart"
    cells = (d.spec.name, _value(d.here), _value(d.there), what)
    return f"<tr>{''.join(f'<td>{html.escape(c)}</td>' for c in cells)}</tr>"


def _value(value: Any) -> str:
    told = "-" if value is None else str(value)
    return told if len(told) <= _LONGEST else f"…{told[-_LONGEST:]}"
