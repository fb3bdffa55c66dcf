"""The report page: one HTML file with everything in it, to be mailed and opened anywhere. Needs the extra `report`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

import yaml
from jinja2 import Environment, PackageLoader, StrictUndefined

from ..replaying.summary import versions
from . import figures as f
from . import table
from .breakdown import NOTHING, component_counts, confusion
from .comparison import Change
from .failures import FALSE, FAR_OFF, MISNAMED, MISSED, NOT_RIGHT, failed_frames
from .gallery import MOST_CARDS, cards
from .metrics import COUNTED_PX
from .plots import COLOURS, distribution_plots, reliability_plots, strata_plots
from .result import Result

_TEMPLATE = "page.html.j2"
_MOST_LISTED = 50  # failed frames without a picture


def render(results: Sequence[Result], changes: Sequence[Mapping[str, Change]] = (), pictures: int = 60) -> str:
    """The page of one run, or of several side by side.

    :param changes: of each run but the first, against the first. :param pictures: overlays a run, at most.
    """
    environment = Environment(
        loader=PackageLoader(__package__, "templates"), autoescape=True, undefined=StrictUndefined, trim_blocks=True,
        lstrip_blocks=True,
    )  # fmt: skip
    evaluations = [r.evaluation for r in results]
    failed = [failed_frames(e) for e in evaluations]
    found = cards(evaluations, failed, pictures)
    return environment.get_template(_TEMPLATE).render(
        results=results,
        colours=[COLOURS[i % len(COLOURS)] for i in range(len(results))],
        headings=_headings(results),
        changes=[(r.name, _changed(change)) for r, change in zip(results[1:], changes, strict=False)],
        plots=[*distribution_plots(results), *reliability_plots(results), *strata_plots(results)],
        pictured=[c for c in found if c.picture],
        listed=[c for c in found if not c.picture],
        components=[component_counts(e) for e in evaluations],
        confusions=[confusion(e) for e in evaluations],
        nothing=NOTHING,
        counted_px=f"{COUNTED_PX:g}",
        most_listed=_MOST_LISTED,
        rate=partial(f.written, "precision"),
        left_out=sum(max(0, len(f) - MOST_CARDS) for f in failed),
        frames=len(evaluations[0].frames),
        kinds=[MISSED, NOT_RIGHT, MISNAMED, FAR_OFF, FALSE],
        names=list(dict.fromkeys(name for e in evaluations for name in e.names)),
        keys=[k for k in f.SHOWN if any(r.overall[k].value is not None for r in results)],
        part_keys=[k for k in f.OF_PARTS if any(r.overall[k].value is not None for r in results)],
        shown=f.SHOWN,
        title=f.title,
        written=f.written,
        parameters=[yaml.safe_dump(dict(r.evaluation.run.parameters), sort_keys=False) for r in results],
        differing=_differing([r.evaluation.run.parameters for r in results]),
        versions=_versions(results),
    )


def _headings(results: Sequence[Result]) -> list[tuple[str, list[tuple[str, str]]]]:
    """The figures that one looks at first; for each run value and interval."""
    keys = ("recognition_rate", "precision", "right_rate", "rotation_error_deg_median", "latency_ms_median")
    known = [k for k in keys if any(r.overall[k].value is not None for r in results)]
    return [(k, [_parted(f.written(k, r.overall[k])) for r in results]) for k in known]


def _parted(text: str) -> tuple[str, str]:
    value, _, interval = text.partition(" ")
    return value, interval


def _changed(changes: Mapping[str, Change]) -> list[tuple[str, list[str], str]]:
    """Title, cells, and whether it is surely better or worse: its interval is on one side of zero."""
    rows = []
    for key, change in changes.items():
        d = change.difference
        if d.value is None:
            continue
        sure = d.low is not None and d.high is not None and (d.low > 0 or d.high < 0)
        verdict = ("better" if d.value * f.SHOWN[key].better > 0 else "worse") if sure else ""
        rows.append((f.title(key), table.change_cells(key, change), verdict))
    return rows


def _differing(parameters: Sequence[Mapping[str, Any]]) -> list[tuple[str, list[Any]]]:
    """Parameters that the runs do not share."""
    keys = list(dict.fromkeys(key for p in parameters for key in p))
    rows = [(key, [p.get(key, "") for p in parameters]) for key in keys]
    return [(key, values) for key, values in rows if any(v != values[0] for v in values)]


def _versions(results: Sequence[Result]) -> list[tuple[str, list[str]]]:
    """What made the results and what scored them, a row for each part."""
    columns = [dict(r.evaluation.run.summary.get("versions") or {}) for r in results] + [versions()]
    return [(name, [str(c.get(name, "not recorded")) for c in columns]) for name in columns[-1]]
