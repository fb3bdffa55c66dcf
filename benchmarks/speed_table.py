"""The tables of `speed.py`, as text and as Markdown."""

from __future__ import annotations

import math
from dataclasses import dataclass

from speed_runs import STAGES, Times

Noises = dict[tuple[int, int], tuple[Times, Times, Times]]
Table = list[list[str]]

_INTRODUCTION = """# Speed

Made by `python benchmarks/speed.py --markdown docs/speed.md` on a 2-core x86-64 cloud machine that had nothing else
to do. Milliseconds a frame; medians unless it says p99. The clock counts CPU time of one thread, or, where it says
two, wall-clock time. *legged*: simulated quadrupeds (`config/aibo.yaml`), 16 to 20 % of the image's width across,
their markers turned away at all angles. *overhead*: soccer robots (`config/vss.yaml`) of two patches, each 4 % of
the width, seen from above: what recognition in the image plane is for.

- *floor*: `cv2.findContours` of the classes in use, and nothing else. In noise recognition may take less: it leaves out
  specks before it draws contours.
- *plane*: the default profile without calibration. *paper*: the same with `recognizer.profile: paper`.
- *Hough*: OpenCV's generalized Hough transform (Guil) of one marker in each class.
- *ArUco*: `cv2.aruco` on the scene's picture with as many tags in it as objects; in brackets how many it finds.
- *space*: with calibration, whole objects fitted.
"""


@dataclass(frozen=True)
class Row:
    """One kind of scene."""

    kind: str
    size: tuple[int, int]
    objects: int
    floor: Times
    plane: Times
    plane_two_threads: Times
    paper: Times
    hough: Times
    aruco: Times
    tags_found: float
    space: Times | None
    space_two_threads: Times | None

    @property
    def name(self) -> list[str]:
        return [self.kind, f"{self.size[0]}x{self.size[1]}", str(self.objects)]


def to_text(rows: list[Row], noises: Noises, budget_ms: float) -> str:
    """All tables, columns aligned."""
    return "\n\n".join(f"{title}\n{_aligned(table)}" for title, table in _tables(rows, noises, budget_ms))


def to_markdown(rows: list[Row], noises: Noises, budget_ms: float) -> str:
    """A page with all tables."""
    parts = [_INTRODUCTION]
    for title, table in _tables(rows, noises, budget_ms):
        lines = [table[0], ["---"] * len(table[0]), *table[1:]]
        parts.append(f"## {title}\n\n" + "\n".join("| " + " | ".join(line) + " |" for line in lines) + "\n")
    return "\n".join(parts)


def _tables(rows: list[Row], noises: Noises, budget_ms: float) -> list[tuple[str, Table]]:
    tables = [("In the image plane", _plane(rows)), ("In space", _space(rows)), ("Stages", _stages(rows))]
    tables += [("Growth", _growth(rows)), ("Label noise at every pixel", _noise(noises, budget_ms))]
    return [(title, table) for title, table in tables if len(table) > 1]


def _plane(rows: list[Row]) -> Table:
    head = ["scene", "image", "objects", "found", "floor", "plane", "p99", "two threads", "paper", "Hough", "ArUco"]
    head += ["plane / floor", "plane / paper", "plane / Hough", "plane / ArUco"]
    table = [head]
    for r in rows:
        times = [_ms(r.floor.median), _ms(r.plane.median), _ms(r.plane.p99), _ms(r.plane_two_threads.median)]
        times += [_ms(r.paper.median), _ms(r.hough.median), f"{_ms(r.aruco.median)} ({r.tags_found:.1f})"]
        ratios = [f"{r.plane.median / other.median:.2f}" for other in (r.floor, r.paper, r.hough, r.aruco)]
        table.append([*r.name, f"{r.plane.found:.1f}", *times, *ratios])
    return table


def _space(rows: list[Row]) -> Table:
    table = [["scene", "image", "objects", "found", "space", "p99", "two threads", "space / floor", "space / ArUco"]]
    for r in rows:
        if r.space is not None and r.space_two_threads is not None:
            times = [_ms(r.space.median), _ms(r.space.p99), _ms(r.space_two_threads.median)]
            found = f"{r.space.found:.1f}"
            table.append(
                [*r.name, found, *times, *(f"{r.space.median / other.median:.1f}" for other in (r.floor, r.aruco))]
            )
    return table


def _stages(rows: list[Row]) -> Table:
    table = [["scene", "image", "objects", "", *STAGES]]
    for r in rows:
        for kind, times in (("plane", r.plane), ("space", r.space)):
            if times is not None:
                table.append([*r.name, kind, *(_ms(times.stages[s]) for s in STAGES)])
    return table


def _growth(rows: list[Row]) -> Table:
    """Many objects over few, and the exponent of pixels between the least and the greatest image."""
    table = [["scene", "", "plane", "space"]]
    by_name = {(r.kind, r.size, r.objects): r for r in rows}
    sizes, counts = sorted({r.size for r in rows}), sorted({r.objects for r in rows})
    for kind in dict.fromkeys(r.kind for r in rows):
        for size in sizes if len(counts) > 1 else []:
            few, many = by_name[kind, size, counts[0]], by_name[kind, size, counts[-1]]
            label = f"{size[0]}x{size[1]}: {counts[-1]} objects over {counts[0]}"
            pairs = ((few.plane, many.plane), (few.space, many.space))
            table.append([kind, label, *(f"{b.median / a.median:.1f}" if a and b else "" for a, b in pairs)])
        for count in counts if len(sizes) > 1 else []:
            small, large = by_name[kind, sizes[0], count], by_name[kind, sizes[-1], count]
            more = math.log(math.prod(sizes[-1]) / math.prod(sizes[0]))
            pairs = ((small.plane, large.plane), (small.space, large.space))
            powers = [f"{math.log(b.median / a.median) / more:.2f}" if a and b else "" for a, b in pairs]
            table.append([kind, f"{count} objects: time grows as pixels to the power of", *powers])
    return table


def _noise(noises: Noises, budget_ms: float) -> Table:
    budget = f"with a budget of {budget_ms:g} ms"
    table = [["image", "floor", "plane", "p99", "plane / floor", budget, "p99", "cut short"]]
    for size, (floor, plane, short) in noises.items():
        values = [_ms(floor.median), _ms(plane.median), _ms(plane.p99), f"{plane.median / floor.median:.1f}"]
        table.append([f"{size[0]}x{size[1]}", *values, _ms(short.median), _ms(short.p99), f"{short.incomplete:.0%}"])
    return table


def _ms(value: float) -> str:
    return f"{value:.2f}" if value < 100 else f"{value:.0f}"


def _aligned(table: Table) -> str:
    widths = [max(len(line[c]) for line in table) for c in range(len(table[0]))]
    return "\n".join("  ".join(cell.rjust(w) for cell, w in zip(line, widths, strict=True)) for line in table)
