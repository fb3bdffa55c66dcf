"""Plots as SVG elements to stand in a page: text stays text, and the same data gives the same bytes."""

from __future__ import annotations

import hashlib
import html
import io
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure

from .figures import FACTORS, title
from .result import Result
from .strata import Bin

COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9")  # Okabe and Ito: all can tell them apart
_STYLE: dict[Any, Any] = {
    "svg.fonttype": "none",
    "svg.hashsalt": "artrec",
    "font.family": "sans-serif",
    "font.size": 9,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e5e5e5",
    "axes.axisbelow": True,
    "lines.linewidth": 1.4,
}
_RATES = ("recognition_rate", "right_rate", "precision")
_ERRORS = ("position_error_median", "rotation_error_deg_median", "joint_error_deg_median")
_PANEL_INCHES = (3.3, 2.4)
_UNFOLDED = ("range", "azimuth")
_MARGINS = {"left": 0.13, "right": 0.96, "top": 0.9, "bottom": 0.25}  # of the panel; a layout engine takes long


@dataclass(frozen=True)
class Plots:
    """Some plots that belong together, each an <svg> element of its own. :param folded: shown on demand."""

    title: str
    panels: tuple[str, ...]
    folded: bool = False


def strata_plots(results: Sequence[Result]) -> list[Plots]:
    """For each condition rates and errors by part, with intervals."""
    plots = []
    for i, stratum in enumerate(results[0].strata):
        rows = [r.strata[i].bins for r in results]
        keys = [k for k in (*_RATES, *_ERRORS) if any(b.figures[k].value is not None for bins in rows for b in bins)]
        panels = [_svg(partial(_draw_parts, rows=rows, key=k), f"{title(k)}, by {stratum.title}") for k in keys]
        plots.append(Plots(f"By {stratum.title}", tuple(panels), stratum.key not in _UNFOLDED))
    return [p for p in plots if p.panels]


def reliability_plots(results: Sequence[Result]) -> list[Plots]:
    """Precision by score, and how many detections have which score; none where there is no detection."""
    if not any(r.calibration.bins for r in results):
        return []
    panels = [
        _svg(partial(_draw_reliability, results=results), "precision of detections by score"),
        _svg(partial(_draw_scores, results=results), "number of detections by score"),
    ]
    return [Plots("Score calibration", tuple(panels))]


def distribution_plots(results: Sequence[Result]) -> list[Plots]:
    """Shares of objects with an error, of frames with a latency, of that size or less."""
    panels = []
    for key in (*_ERRORS, "latency_ms_median"):
        samples, name = [_sample(r, key) for r in results], title(key).replace(", median", "")
        if any(len(s) for s in samples):
            panels.append(_svg(partial(_draw_distribution, samples=samples, name=name), f"distribution of {name}"))
    return [Plots("Errors and latency", tuple(panels))] if panels else []


def _sample(result: Result, key: str) -> np.ndarray:
    e = result.evaluation
    counts = e.counts()
    values: dict[str, Any] = {
        "position_error_median": counts.position_errors,
        "rotation_error_deg_median": np.degrees(counts.rotation_errors_rad),
        "joint_error_deg_median": np.degrees(counts.joint_errors_rad),
        "latency_ms_median": [r.timing_ms["total"] for r in e.used_records if "total" in r.timing_ms],
    }
    return np.sort(np.asarray(values[key], float)) * FACTORS.get(key, 1.0)


def _draw_parts(axes: Any, rows: Sequence[Sequence[Bin]], key: str) -> None:
    """A point with its interval for each part, runs beside each other."""
    factor, count = FACTORS.get(key, 1.0), len(rows)
    for number, bins in enumerate(rows):
        shift = (number - (count - 1) / 2) * 0.6 / max(count, 2)
        for place, estimate in enumerate(b.figures[key] for b in bins):
            if estimate.value is None:
                continue
            x, y, colour = place + shift, factor * estimate.value, COLOURS[number % len(COLOURS)]
            if estimate.low is not None and estimate.high is not None:
                axes.plot([x, x], [factor * estimate.low, factor * estimate.high], color=colour, alpha=0.55)
            axes.plot([x], [y], "o", color=colour, markersize=4.5)
    bins = rows[0]
    turn = 0 if len(bins) <= 4 else 40
    axes.set_xticks(range(len(bins)), [b.name for b in bins], rotation=turn, ha="right" if turn else "center")
    axes.set_xlim(-0.6, len(bins) - 0.4)
    axes.set_title(title(key), fontsize=9)
    if key in _RATES:
        axes.set_ylim(-0.03, 1.03)
    else:
        axes.set_ylim(bottom=0)


def _draw_reliability(axes: Any, results: Sequence[Result]) -> None:
    axes.plot([0, 1], [0, 1], color="#999999", linewidth=1, linestyle="--")
    for number, result in enumerate(results):
        bins, colour = result.calibration.bins, COLOURS[number % len(COLOURS)]
        for b in bins:
            axes.plot([b.score, b.score], [b.precision.low, b.precision.high], color=colour, alpha=0.55)
        axes.plot([b.score for b in bins], [b.precision.value for b in bins], "o-", color=colour, markersize=4.5)
    axes.set(xlim=(-0.03, 1.03), ylim=(-0.03, 1.03), xlabel="score")
    axes.set_title("precision by score", fontsize=9)


def _draw_scores(axes: Any, results: Sequence[Result]) -> None:
    for number, result in enumerate(results):
        bins, colour = result.calibration.bins, COLOURS[number % len(COLOURS)]
        width = 0.08 / len(results)
        left = [b.low + 0.01 + number * width for b in bins]
        axes.bar(left, [b.precision.n for b in bins], width, align="edge", color=colour)
    axes.set(xlim=(-0.03, 1.03), xlabel="score")
    axes.set_title("detections by score", fontsize=9)


def _draw_distribution(axes: Any, samples: Sequence[np.ndarray], name: str) -> None:
    for number, values in enumerate(samples):
        if not len(values):
            continue
        thin = np.unique(np.linspace(0, len(values) - 1, 300).astype(int))  # more cannot be seen
        share = (thin + 1) / len(values)
        axes.step([0, *values[thin]], [0, *share], where="post", color=COLOURS[number % len(COLOURS)])
    most = 1.05 * max(float(np.quantile(v, 0.98)) for v in samples if len(v)) or 1.0
    beyond = max(float(v[-1]) for v in samples if len(v))
    axes.set_xlim(0, most)
    axes.set_ylim(-0.03, 1.03)
    axes.set_xlabel(f"{name} (up to {beyond:.3g})" if beyond > most else name)
    axes.set_title("share of that or less", fontsize=9)


def _svg(draw: Callable[[Any], None], label: str) -> str:
    """A plot as one <svg> element that takes the width it is given."""
    with mpl.rc_context(_STYLE):
        figure = Figure(figsize=_PANEL_INCHES)
        figure.subplots_adjust(**_MARGINS)
        canvas = FigureCanvasSVG(figure)
        draw(figure.subplots())
        stream = io.StringIO()
        canvas.print_svg(stream, metadata={"Date": None, "Creator": None})
    return _as_element(stream.getvalue(), label)


def _as_element(svg: str, label: str) -> str:
    """The element alone: named for screen readers, without what a page needs not, its ids its own among other plots."""
    element = svg[svg.index("<svg") :]
    for needless in (r"<metadata>.*?</metadata>", r"<defs>\s*<style.*?</style>\s*</defs>", r"font-family: [^;\"]*;?"):
        element = re.sub(needless, "", element, flags=re.DOTALL)
    element = re.sub(r'<g id="[^"]*"', "<g", element)  # nothing refers to groups
    element = re.sub(r"(\d+\.\d\d)\d+", r"\1", element)  # hundredths of a point are enough
    element = re.sub(r">\s+<", "><", re.sub(r"\s*\n\s*", " ", element))
    prefix = hashlib.sha1(label.encode()).hexdigest()[:8]
    element = re.sub(r'\bid="', f'id="{prefix}-', element)
    element = element.replace("url(#", f"url(#{prefix}-").replace('href="#', f'href="#{prefix}-')
    for side in ("width", "height"):
        element = re.sub(rf'(<svg [^>]*?)\b{side}="[^"]*"', r"\1", element, count=1)
    return element.replace("<svg ", f'<svg role="img" aria-label="{html.escape(label)}" ', 1)
