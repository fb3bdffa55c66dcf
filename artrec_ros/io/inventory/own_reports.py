"""What artrec's own reports and drawings hold, in a few lines each."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from ...core.base.errors import ConfigError
from ..base.kinds import COMPARISON, METRICS, PLAN, SUMMARY, TUNING, kind_of
from ..base.typed import UnfitError, typed
from ..base.yaml_files import Value
from ..objects.urdf import read_robot
from ..results.summary_file import SummaryContent
from .contents import Report

_FIGURES = ("recognition_rate", "right_rate", "precision", "false_per_frame", "latency_ms_median")


def read_report(value: Value) -> Report:
    """Of a JSON file that `artrec` wrote. :raises ConfigError: it is none, or holds something else than it should."""
    kind = kind_of(value.raw)
    if kind not in _LINES:
        what = f"is {kind}, which is not looked into" if kind else "neither a COCO file nor a report of artrec"
        raise value.error(what)
    try:
        return Report(kind, tuple(_LINES[kind](value.raw)))
    except UnfitError as error:
        raise value.error(f"is {kind}, but damaged: {error}") from None
    except (KeyError, TypeError, AttributeError, ValueError, IndexError):
        raise value.error(f"is {kind}, but damaged: something in it is missing or of another kind") from None


def read_drawing(path: Path) -> Report:
    """The shapes of an SVG drawing that can be markers. :raises ConfigError: there are none, or it cannot be read."""
    from ..objects.svg import svg_markers

    parts: dict[str, list[str]] = {}
    for loose in svg_markers(path, width_m=None):
        width, height = loose.marker.outline.max(axis=0) - loose.marker.outline.min(axis=0)
        shown = f"{loose.marker.name} ({1e3 * width:.1f} x {1e3 * height:.1f} mm)"
        parts.setdefault(loose.component, []).append(shown)
    lines = (f"{component}: {', '.join(markers)}" for component, markers in parts.items())
    return Report("a drawing", ("an object file is made of it with artrec model", *lines))


def read_urdf(path: Path) -> Report:
    """Links and joints of a URDF. :raises ConfigError: it is none."""
    robot = read_robot(path)
    joints = [(e.get("name", ""), e.get("type", "")) for e in robot.findall("joint")]
    moving = [f"{name} {kind}" for name, kind in joints if kind != "fixed"]
    links = [e.get("name", "") for e in robot.findall("link")]
    if not links:
        raise ConfigError(f"{path}: holds no link")
    return Report(
        f"the URDF of '{robot.get('name', '')}'",
        (
            "an object file is made of it with artrec model",
            f"{len(links)} links: {', '.join(links)}",
            f"{len(joints)} joints, {len(moving)} of them moving{': ' if moving else ''}{', '.join(moving)}",
        ),
    )


def _summary(raw: Any) -> Iterator[str]:
    c = typed(raw, SummaryContent)
    found = ", ".join(f"{name}: {count}" for name, count in c["objects"].items()) or "none"
    yield f"sources: {', '.join(map(str, c['sources']))}"
    yield f"{c['frames']} frames, {c['frames_with_error']} of them unusable; objects found: {found}"
    if c["total_ms"] is not None:
        yield f"ms per frame: median {c['total_ms']['median']:.1f}, longest {c['total_ms']['max']:.1f}"
    if c["interrupted"]:
        yield "interrupted: the same command goes on"
    yield from (f"problem then: {line}" for line in c["problems"])


def _plan(c: Mapping[str, Any]) -> Iterator[str]:
    given = {k: v for k, v in c["options"].items() if v not in (None, "None", False)}
    yield f"sources: {', '.join(map(str, c['sources']))}"
    yield f"objects: {', '.join(map(str, c['parameters']['objects']))}; files: {', '.join(c['files'])}"
    if isinstance(camera := given.get("camera"), dict):
        (width, height), (fx, fy) = camera["size"], (camera["K"][i] for i in (0, 4))
        given["camera"] = f"{width}x{height} (focal lengths {fx:.1f}, {fy:.1f} px)"
    yield f"options: {', '.join(f'{k} {v}' for k, v in given.items())}; artrec_ros {c['version']}"


def _metrics(c: Mapping[str, Any]) -> Iterator[str]:
    counts = c["all"]["counts"]
    yield f"run: {c['run']}; truth: {c['truth']}"
    found = f"{counts['objects']} objects, {counts['recognised']} found, {counts['false']} false"
    yield f"{counts['frames']} frames, {found}"
    known = [(name, c["all"].get(name, {}).get("value")) for name in _FIGURES]
    yield ", ".join(f"{name} {value:g}" for name, value in known if value is not None)


def _comparison(c: Mapping[str, Any]) -> Iterator[str]:
    for run in c["runs"]:
        head, *rest = _metrics(run)
        yield head
        yield from (f"  {line}" for line in rest)


def _tuning(c: Mapping[str, Any]) -> Iterator[str]:
    for key, value in c.items():
        if isinstance(value, (str, int, float, bool)) and key != "format":
            yield f"{key}: {value}"
        elif isinstance(value, (list, dict)):
            yield f"{key}: {len(value)} entries"


_LINES: dict[str, Callable[[Mapping[str, Any]], Iterator[str]]] = {
    SUMMARY: _summary,
    PLAN: _plan,
    METRICS: _metrics,
    COMPARISON: _comparison,
    TUNING: _tuning,
}
