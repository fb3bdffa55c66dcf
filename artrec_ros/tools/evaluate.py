"""`artrec evaluate`: scores replays against truth, and compares them."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from importlib.util import find_spec
from pathlib import Path
from typing import Any

from ..io.base.whole_files import make_folder
from ..io.images.cameras import load_camera
from ..io.results.results import DETECTIONS_FILE
from ..io.truth.reading import read_truth
from .evaluation import table
from .evaluation.comparison import Change, compare
from .evaluation.output import write_json, write_whole
from .evaluation.result import FORMAT, Result, changes_to_dict, results_of
from .evaluation.runs import load_runs
from .evaluation.scoring import Options, evaluate_runs
from .options.outputs import OF_METRICS, OF_PAGE, check_output
from .options.paths import path
from .options.work_options import seconds

METRICS_FILE, PAGE_FILE = "metrics.json", "report.html"
COMPARISON_FILE, COMPARISON_PAGE_FILE = "comparison.json", "comparison.html"
_NO_PAGE = "no page: it needs matplotlib and Jinja2: pip install artrec_ros[report]"
_EPILOG = """\
Truth: truth.jsonl as `artrec simulate` writes it (matched by stamp); a bag with PoseArray topics .../NAME/poses
in the camera's optical frame (by stamp; needs a calibration, beside them in the bag or with --camera-info); a
COCO file with keypoints COMPONENT/MARKER.tail and .head (by image file name: replay that folder).

Written: metrics.json into each DIR, and report.html; with several DIRs comparison.json and comparison.html into
the first one or --output. The pages need: pip install artrec_ros[report]
"""


def add_parser(subparsers: Any) -> None:
    p = subparsers.add_parser("evaluate", help="score replays against truth", description=__doc__, epilog=_EPILOG)
    p.add_argument("results", metavar="DIR", nargs="+", type=_results, help="folders that `artrec replay` wrote")
    p.add_argument("--truth", required=True, type=path, metavar="PATH", help="truth.jsonl, a bag, or a COCO file")
    p.add_argument("--truth-topic", action="append", default=[], metavar="TOPIC",
                   help="of a bag: its PoseArray topics (default: those under /ground_truth/, or all)")  # fmt: skip
    p.add_argument("--names", type=_names, metavar="NAME=TRUTH,...",
                   help="the truth's name or label of each object; only these are scored")  # fmt: skip
    p.add_argument("--camera-info", type=path, metavar="FILE", help="calibration file, for poses without one")
    p.add_argument("--max-gap", type=seconds, default=0.0, metavar="S", help="how far stamps may differ (0 s)")
    p.add_argument("--common", action="store_true", help="score only frames for which every DIR has a result")
    p.add_argument("-o", "--output", type=path, metavar="DIR", help="where page and comparison go (default: first DIR)")
    p.add_argument("--pictures", type=_count, default=60, metavar="N", help="overlays on the page, of each DIR (60)")
    p.add_argument("--no-page", action="store_true", help="write no page")
    p.set_defaults(run=run)


def _results(text: str) -> Path:
    """The folder of results that somebody names, be it by the file in it."""
    given = path(text)
    return given.parent if given.name == DETECTIONS_FILE and given.is_file() else given


def run(args: argparse.Namespace) -> int:
    output = args.output or args.results[0]
    _check_outputs(args, output)
    camera = load_camera(args.camera_info) if args.camera_info else None
    options = Options(args.names, round(args.max_gap * 1e9), args.common, camera)
    results, changes = evaluate(args.results, args.truth, args.truth_topic, options)
    make_folder(output)
    written = [_write_metrics(r) for r in results]
    if changes:
        content = {"format": FORMAT, "runs": [r.to_dict() for r in results]}
        write_json(output / COMPARISON_FILE, content | {"changes": [changes_to_dict(c) for c in changes]})
        written.append(output / COMPARISON_FILE)
    for line in lines(results, changes):
        print(line)
    print()
    if not args.no_page and _can_make_pages():
        from .evaluation.page import render

        written.append(output / (COMPARISON_PAGE_FILE if changes else PAGE_FILE))
        write_whole(written[-1], render(results, changes, args.pictures))
    print(f"written: {', '.join(map(str, written))}")
    if not args.no_page and not _can_make_pages():
        print(_NO_PAGE)
    return 0


def evaluate(
    folders: Sequence[Path], truth: Path, topics: Sequence[str] = (), options: Options | None = None
) -> tuple[list[Result], list[dict[str, Change]]]:
    """Each replay's figures, and the changes of each but the first against the first.

    :param topics: of a bag of truth.
    :raises ArtrecError: truth and results have nothing in common, or files cannot be read.
    """
    evaluations = evaluate_runs(load_runs(folders), read_truth(truth, topics), options or Options())
    return results_of(evaluations), [compare(evaluations[0], other) for other in evaluations[1:]]


def lines(results: Sequence[Result], changes: Sequence[Mapping[str, Change]]) -> Iterator[str]:
    """What the user reads on the terminal."""
    for result in results:
        prefix = f"{result.name}: " if changes else ""
        yield from (f"note: {prefix}{note}" for note in result.evaluation.notes)
    if changes:
        yield from table.of_comparison([r.name for r in results], [r.overall for r in results], changes)
        return
    counts = results[0].evaluation.counts()
    yield f"{counts.frames} frames, {counts.objects} objects in view, {counts.recognised} found, {counts.false} false"
    yield from table.of_run(results[0].overall, results[0].figures)
    yield from table.of_parts(results[0].strata)


def _check_outputs(args: argparse.Namespace, output: Path) -> None:
    """:raises ConfigError: a file that would be written is read, or somebody else's."""
    inputs = [args.truth, *filter(None, [args.camera_info])]
    several = len(args.results) > 1
    written = {folder / METRICS_FILE: OF_METRICS for folder in args.results}
    written |= {output / COMPARISON_FILE: OF_METRICS} if several else {}
    written |= {} if args.no_page else {output / (COMPARISON_PAGE_FILE if several else PAGE_FILE): OF_PAGE}
    for place, mark in written.items():
        if place.is_file():
            check_output(place, inputs, mark)


def _write_metrics(result: Result) -> Path:
    path = result.evaluation.run.folder / METRICS_FILE
    write_json(path, result.to_dict())
    return path


def _can_make_pages() -> bool:
    return all(find_spec(module) is not None for module in ("jinja2", "matplotlib"))


def _names(text: str) -> dict[str, str]:
    pairs = [part.partition("=") for part in text.split(",")]
    if not all(name and wanted for name, _, wanted in pairs):
        raise argparse.ArgumentTypeError(f"'{text}': NAME=TRUTH,... is expected, as in red=3,blue=2 or lamp=desk_lamp")
    return {name.strip(): wanted.strip() for name, _, wanted in pairs}


def _count(text: str) -> int:
    if not text.isdecimal():
        raise argparse.ArgumentTypeError(f"'{text}' is no number of pictures")
    return int(text)
