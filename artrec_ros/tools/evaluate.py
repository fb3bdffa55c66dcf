"""`artrec evaluate`: scores the results of a replay against truth."""

from __future__ import annotations

import argparse
import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from ..core.datatypes import Detection
from ..core.errors import SourceError
from ..io.results import DETECTIONS_FILE, SUMMARY_FILE, read_results
from ..io.truth import load_truth
from .metrics import Counts, score

METRICS_FILE = "metrics.json"


def add_parser(subparsers: Any) -> None:
    p = subparsers.add_parser("evaluate", help="score a replay against truth", description=__doc__)
    p.add_argument("results", metavar="DIR", type=Path, help="folder that `artrec replay` wrote")
    p.add_argument("--truth", required=True, type=Path, metavar="FILE", help="truth.jsonl, matched by stamp")
    p.add_argument(
        "--names",
        type=_names,
        metavar="NAME=LABEL,...",
        help="the truth's label of each object (default: the replay's)",
    )
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    metrics = evaluate(args.results, args.truth, args.names)
    (args.results / METRICS_FILE).write_text(json.dumps(metrics, indent=2) + "\n", encoding="utf-8")
    for line in table(metrics):
        print(line)
    return 0


def evaluate(folder: Path, truth_file: Path, labels: Mapping[str, int] | None = None) -> dict[str, dict[str, Any]]:
    """Figures per object name, and of all together under 'all'.

    :param labels: the truth's class number by object name; None: as the replay's parameters have them.
    :raises SourceError: if truth and results have no frame in common, or files cannot be read.
    """
    objects = _replayed_objects(folder)
    labels = {name: o["label"] for name, o in objects.items()} if labels is None else labels
    if unknown := sorted(set(labels) - set(objects)):
        raise SourceError(f"--names: '{unknown[0]}' is no object of this replay ({', '.join(objects)})")
    truth = load_truth(truth_file)
    detections = {r.stamp_ns: r.detections for r in read_results(folder / DETECTIONS_FILE)}
    _check_common_stamps(truth, detections)
    counts = {name: score(truth, detections, label, name, objects[name]["required"]) for name, label in labels.items()}
    return {**{name: c.rates() for name, c in counts.items()}, "all": _together(list(counts.values())).rates()}


def table(metrics: Mapping[str, Mapping[str, Any]]) -> Iterator[str]:
    """The figures as lines of text: a row for each figure, a column for each object name."""
    width = max(len(row) for row in metrics["all"]) + 2
    yield " " * width + "".join(f"{name:>12}" for name in metrics)
    for row in metrics["all"]:
        yield f"{row:<{width}}" + "".join(f"{'-' if m[row] is None else m[row]:>12}" for m in metrics.values())


def _together(counts: list[Counts]) -> Counts:
    """The sum over names: they were scored on the same frames, which count once."""
    total = sum(counts[1:], counts[0])
    frames, without = counts[0].frames, counts[0].frames_without_result
    return total + Counts(frames=frames - total.frames, frames_without_result=without - total.frames_without_result)


def _replayed_objects(folder: Path) -> dict[str, dict[str, Any]]:
    path = folder / SUMMARY_FILE
    try:
        objects: dict[str, dict[str, Any]] = json.loads(path.read_text(encoding="utf-8"))["looked_for"]
    except OSError as error:
        raise SourceError(f"{path}: cannot be read ({error.strerror}); is this a folder of `artrec replay`?") from error
    except (ValueError, KeyError, TypeError) as error:
        raise SourceError(f"{path}: no summary of a replay: {error!r}") from error
    return objects


def _check_common_stamps(truth: Mapping[int, Any], detections: Mapping[int, tuple[Detection, ...]]) -> None:
    if truth.keys() & detections.keys():
        return
    if not detections:
        raise SourceError(f"the results hold no frame, the truth {len(truth)}")
    known, found = np.array(sorted(truth)), np.array(sorted(detections))
    gap_ns = np.abs(known[:, None] - found[None, :]).min()
    raise SourceError(
        f"no stamp of the truth ({len(known)} frames from {known[0]}) is one of the results' ({len(found)} frames from "
        f"{found[0]}); the nearest two are {gap_ns / 1e9:.6g} s apart"
    )


def _names(text: str) -> dict[str, int]:
    pairs = [part.partition("=") for part in text.split(",")]
    if not all(name and label.isdecimal() for name, _, label in pairs):
        raise argparse.ArgumentTypeError(f"'{text}': NAME=LABEL,... is expected, as in red=3,blue=2")
    return {name: int(label) for name, _, label in pairs}
