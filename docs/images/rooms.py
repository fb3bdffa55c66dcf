"""Draws docs/images/rooms.png: the rooms of core, the lowest below, and who imports whom, read off the sources.

python docs/images/rooms.py
"""

from __future__ import annotations

import ast
from pathlib import Path

import matplotlib

matplotlib.use("Agg")
import matplotlib.pyplot as plt
from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

ROOT = Path(__file__).resolve().parents[2]
CORE = ROOT / "artrec_ros" / "core"
ROOMS = [
    "base", "geometry", "model", "image", "alignment", "constraints", "grouping", "pose", "verdict", "memory",
    "tracking",
]  # fmt: skip
OFFLINE = ["learning", "design"]
TOP = "recognizer, stages, drawing"
INK, LINE = "#1d2733", "#9aa7b5"
COLOURS = {TOP: "#f4e3c1"} | dict.fromkeys(ROOMS, "#dbe7f3") | dict.fromkeys(OFFLINE, "#e4efdc")
WIDTH, HEIGHT, STEP = 9.9, 0.62, 0.92


def room_of(parts: tuple[str, ...]) -> str:
    return parts[0] if len(parts) > 1 and parts[0] in (*ROOMS, *OFFLINE) else TOP


def links() -> dict[tuple[str, str], int]:
    """How many imports lead from one room to another."""
    found: dict[tuple[str, str], int] = {}
    for path in sorted(CORE.rglob("*.py")):
        parts = path.relative_to(CORE).parts
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and node.level == len(parts) and node.module:
                name = tuple(node.module.split("."))
                pair = room_of(parts), room_of((*name, "x"))
                if pair[0] != pair[1]:
                    found[pair] = found.get(pair, 0) + 1
    return found


def said(room: str) -> str:
    if room == TOP:
        return "The method's steps, one call a line"
    return (ast.get_docstring(ast.parse((CORE / room / "__init__.py").read_text(encoding="utf-8"))) or "").rstrip(".")


def main() -> None:
    places = {room: (0.0, STEP * i) for i, room in enumerate([*ROOMS, TOP])}
    places |= {"learning": (WIDTH + 2.6, STEP * 7.5), "design": (WIDTH + 2.6, STEP * 5.5)}
    figure, axes = plt.subplots(figsize=(15.5, 9.2))
    for (above, below), count in links().items():
        (x0, y0), (x1, y1) = places[above], places[below]
        if above in OFFLINE:
            start, end, bend = (x0, y0 + HEIGHT / 2), (x1 + WIDTH, y1 + HEIGHT / 2), 0.0
        elif y0 - y1 < 1.5 * STEP:
            start, end, bend = (x0 + WIDTH / 2, y0), (x1 + WIDTH / 2, y1 + HEIGHT), 0.0
        else:
            start, end, bend = (x0, y0 + HEIGHT / 2), (x1, y1 + HEIGHT / 2), 0.35
        axes.add_patch(
            FancyArrowPatch(
                start, end, connectionstyle=f"arc3,rad={bend}", arrowstyle="-|>", mutation_scale=10, color=LINE,
                linewidth=0.6 + 0.09 * min(count, 20), zorder=1,
            )
        )  # fmt: skip
    for room, (x, y) in places.items():
        shape = "round,pad=0.02,rounding_size=0.08"
        axes.add_patch(FancyBboxPatch((x, y), WIDTH, HEIGHT, shape, fc=COLOURS[room], ec=INK, zorder=2))
        files = len(list((CORE / room).glob("[!_]*.py"))) if room != TOP else len(list(CORE.glob("[!_]*.py")))
        axes.text(x + 0.12, y + HEIGHT * 0.68, room, weight="bold", color=INK, size=11, va="center", zorder=3)
        right = {"size": 8, "va": "center", "ha": "right", "zorder": 3}
        axes.text(x + WIDTH - 0.12, y + HEIGHT * 0.68, f"{files} files", color=INK, **right)
        axes.text(x + 0.12, y + HEIGHT * 0.27, said(room), color=INK, size=7.4, va="center", zorder=3)
    x, y = places["learning"]
    axes.text(x, y + HEIGHT + 0.18, "offline, beside the recogniser", color=INK, size=9)
    axes.set(xlim=(-3.6, 2 * WIDTH + 2.8), ylim=(-0.2, STEP * len(ROOMS) + HEIGHT + 0.2))
    axes.axis("off")
    figure.savefig(Path(__file__).with_name("rooms.png"), dpi=80, bbox_inches="tight", facecolor="white")


if __name__ == "__main__":
    main()
