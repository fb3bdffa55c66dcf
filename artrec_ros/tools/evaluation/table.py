"""Figures as lines of text for a terminal."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

from .comparison import Change
from .figures import FACTORS, OF_PARTS, SHOWN, Figures, title, written
from .strata import Stratum

_GAP = "  "


def of_run(overall: Figures, figures: Mapping[str, Figures]) -> Iterator[str]:
    """A row for each figure, a column for each object name; all together with intervals."""
    names = list(figures) if len(figures) > 1 else []
    rows = [["", *names, "all (95 % interval)"]]
    for key in _known([overall]):
        rows.append([title(key), *(_cell(figures[n], key, False) for n in names), _cell(overall, key, True)])
    yield from aligned(rows)


def of_parts(strata: Sequence[Stratum]) -> Iterator[str]:
    """A row for each part: objects, false detections, and the figures that are told of parts."""
    keys = [k for k in OF_PARTS if any(b.figures[k].value is not None for s in strata for b in s.bins)]
    for stratum in strata:
        yield ""
        yield f"by {stratum.title}"
        rows = [["", "objects", "false", *(SHOWN[k].short for k in keys)]]
        for part in stratum.bins:
            figures = part.figures
            cells = [written(k, figures[k], interval=k in ("recognition_rate", "right_rate")) for k in keys]
            rows.append([f"  {part.name}", str(part.counts.objects), part.false, *cells])
        yield from aligned(rows)


def of_comparison(
    runs: Sequence[str], figures: Sequence[Figures], changes: Sequence[Mapping[str, Change]]
) -> Iterator[str]:
    """A column for each run; then, for each run but the first, what changed from the first."""
    rows = [["", *runs]]
    for key in _known(figures):
        rows.append([title(key), *(_cell(f, key, True) for f in figures)])
    yield from aligned(rows)
    for name, change in zip(runs[1:], changes, strict=True):
        yield ""
        rows = [[f"{name} against {runs[0]}, same objects", "difference (95 % interval)", "gained", "lost", "p"]]
        rows += [[title(key), *change_cells(key, c)] for key, c in change.items() if c.difference.value is not None]
        yield from aligned(rows)


def change_cells(key: str, change: Change) -> list[str]:
    """Difference with interval, gained, lost, p."""
    counts = ["" if v is None else str(v) for v in (change.gained, change.lost)]
    return [signed(key, change), *counts, "" if change.p is None else f"{change.p:.2g}"]


def signed(key: str, change: Change) -> str:
    """A difference with its sign, and the interval, where there is one."""
    d, factor, digits = change.difference, FACTORS.get(key, 1.0), SHOWN[key].digits
    if d.value is None:
        return "-"
    text = f"{factor * d.value:+.{digits}f}"
    if d.low is None or d.high is None:
        return text
    return f"{text} ({factor * d.low:+.{digits}f} to {factor * d.high:+.{digits}f})"


def aligned(rows: Sequence[Sequence[str]]) -> Iterator[str]:
    """Rows of cells as lines; the first column to the left, the others to the right."""
    widths = [max(len(row[i]) for row in rows) for i in range(len(rows[0]))]
    for row in rows:
        cells = [row[0].ljust(widths[0]), *(c.rjust(w) for c, w in zip(row[1:], widths[1:], strict=True))]
        yield _GAP.join(cells).rstrip()


def _known(figures: Sequence[Figures]) -> list[str]:
    """The figures, in order, that any column can tell."""
    return [key for key in SHOWN if any(key in f and f[key].value is not None for f in figures)]


def _cell(figures: Figures, key: str, interval: bool) -> str:
    return written(key, figures[key], interval) if key in figures else "-"
