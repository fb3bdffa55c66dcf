"""How a Rerun recording is laid out when it is opened. Needs rerun-sdk."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from contextlib import suppress

with suppress(ImportError):  # RerunFile tells what to install
    import rerun.blueprint as rrb


def layout(roots: Sequence[Sequence[str]], shown: Collection[tuple[str, ...]]) -> rrb.Blueprint:
    """A tab for each source: image and classes, space, and the plots.

    :param roots: path of each source. :param shown: paths of all that any frame showed; what never was has no view.
    """
    own = [[path[len(root) :] for path in shown if path[: len(root)] == tuple(root)] for root in roots]
    tabs = [_source(list(root), paths) for root, paths in zip(roots, own, strict=True)]
    return rrb.Blueprint(tabs[0] if len(tabs) == 1 else rrb.Tabs(*tabs), rrb.SelectionPanel(state="collapsed"))


def _source(root: list[str], shown: Sequence[tuple[str, ...]]) -> rrb.Container:
    at = "/" + "/".join(root)
    below = at.rstrip("/")
    first = {path[0] for path in shown}
    camera = [f"{below}/camera/found/**", f"{below}/camera/rejected"]
    pictures: list[rrb.View] = []
    for name, title in (("image", "Image"), ("classes", "Classes")):
        if ("camera", name) in shown:
            pictures.append(_image(below, title, [f"{below}/camera/{name}", *camera]))
    spaces = [_space(at, "Space", ["camera", "objects", "uncertainty"])] if "objects" in first else []
    for frame in sorted(first - {"camera", "objects", "uncertainty", "plots", "log"}):
        spaces.append(_space(f"{below}/{frame}", frame, ["objects", "uncertainty"]))
    views = [rrb.Vertical(*pictures), rrb.Vertical(*spaces)] if spaces else pictures
    plots: list[rrb.View] = [
        rrb.TimeSeriesView(origin=f"{below}/plots/{kind}", name=title, axis_y=axis)
        for kind, title, axis in _plots()
        if any(path[:2] == ("plots", kind) for path in shown)
    ]
    if "log" in first:
        plots.append(rrb.TextLogView(origin=f"{below}/log", name="Log"))
    rows = rrb.Vertical(rrb.Horizontal(*views), rrb.Horizontal(*plots), row_shares=[3, 1])
    return rrb.Vertical(rows, name=root[-1] if root else None)


def _plots() -> list[tuple[str, str, rrb.ScalarAxis | None]]:
    return [
        ("scores", "Scores", rrb.ScalarAxis(range=(0.0, 1.05))),
        ("joints", "Joints, rad or m", None),
        ("milliseconds", "Milliseconds", None),
    ]


def _image(below: str, title: str, contents: list[str]) -> rrb.View:
    return rrb.Spatial2DView(origin=f"{below}/camera", name=title, contents=contents)


def _space(origin: str, title: str, parts: Sequence[str]) -> rrb.View:
    below = origin.rstrip("/")
    return rrb.Spatial3DView(origin=origin, name=title, contents=[f"{below}/{part}/**" for part in parts])
