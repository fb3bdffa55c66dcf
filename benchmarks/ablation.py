"""What each ingredient of the whole-object fit brings: the same replay with one of them taken away.

    python benchmarks/ablation.py BAG TRUTH.jsonl --params-file config/aibo.yaml [--topic TOPIC]

Each row is `artrec replay` and `artrec evaluate` with parameters changed, or, where no parameter takes it away, a
function of the recogniser replaced for the run.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import json
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import yaml

from artrec_ros.core.base.config import RecognizerConfig, rooms_of
from artrec_ros.core.model import surface
from artrec_ros.core.pose import finder as whole_object
from artrec_ros.core.pose import seeds
from artrec_ros.core.pose import view_bank as bank
from artrec_ros.core.verdict.judge import Judge
from artrec_ros.tools.main import main

COLUMNS = {
    "recognition": ("recognition_rate", 1),
    "right": ("right_rate", 1),
    "false a frame": ("false_per_frame", 1),
    "component precision": ("component_precision", 1),
    "position %": ("position_error_median", 100),
    "rotation deg": ("rotation_error_deg_median", 1),
}


FINDER = whole_object.WholeObjectFinder


def unfitted(model: Any, frame: Any, poses: Any, *_: Any) -> Any:
    """In place of `pose_fit.fit_poses`: leaves hypotheses where they are."""
    return poses


def unclimbed(self: Any, frame: Any, found: Any, *_: Any) -> Any:
    """In place of searches on the votes."""
    return found


def faceless(index: int, component: Any) -> list[Any]:
    """In place of `surface._face_patches`: bodies still hide, and say nothing."""
    return []


def no_couples(contour: Any, tolerances_px: Any) -> tuple[Any, Any]:
    """In place of `views.blob_couples`."""
    return np.zeros((0, 2)), np.zeros((0, 2))


def likely(self: Any, verdict: Any) -> str | None:
    """In place of `Judge.reason`."""
    enough = verdict.claim.votes >= self.min_votes and verdict.probability >= self.min_probability
    return None if enough else "unlikely"


def patches(*changes: tuple[Any, str, Any]) -> Callable[[], contextlib.ExitStack]:
    def enter() -> contextlib.ExitStack:
        stack = contextlib.ExitStack()
        for owner, name, value in changes:
            stack.enter_context(mock.patch.object(owner, name, value))
        return stack

    return enter


# what replaces functions, and what changes parameters: of the recogniser, and of its rooms by their names
VARIANTS: dict[str, tuple[Callable[[], contextlib.ExitStack], dict[str, Any]]] = {
    "all of it": (patches(), {}),
    "without fits to contours": (patches((whole_object, "fit_poses", unfitted), (seeds, "fit_poses", unfitted)), {}),
    "without the local search on votes": (patches((FINDER, "_climb", unclimbed), (FINDER, "_sweep", unclimbed)), {}),
    "without the bodies' faces": (patches((surface, "_face_patches", faceless)), {}),
    "without votes at and around outlines": (
        patches(), {"votes": {"rim": [0.0] * 3, "ring": [0.0] * 3, "ring_on_body": [0.0] * 3, "ring_body_label": 0.0}}),
    "without mirrored turns": (patches((FINDER, "_with_flips", lambda self, found: found.poses)), {}),
    "without taking sure objects' pixels first": (
        patches(), {"search": {"sure": 2.0, "likely": 2.0}}),
    "starting from the required component alone": (
        patches((seeds.Seeds, "_of_limbs", lambda self, *_: self._surface.no_poses)), {}),
    "required component need not be confirmed": (patches((Judge, "reason", likely)), {}),
    "blobs aligned by moments alone": (patches((bank, "blob_couples", no_couples)), {}),
    "without telling grazing components": (patches(), {"verdict": {"told_agree": 1.0}}),
    "flat path: learned constraints, no space": (patches(), {"whole_object": False}),
    "profile paper": (patches(), {"profile": "paper"}),
}  # fmt: skip


def run(args: argparse.Namespace, folder: Path, number: int, changes: dict[str, Any]) -> Iterator[str]:
    """Figures of one replay, as text."""
    more, budget = folder / "more.yaml", {"time_budget_ms": 20000.0 + number}  # its own: no recogniser is used again
    expert = {name: value for name, value in changes.items() if name in rooms_of(RecognizerConfig)}
    own = {name: value for name, value in changes.items() if name not in expert}
    parameters = {"recognizer": {**budget, **own}, **({"expert": expert} if expert else {})}
    more.write_text(yaml.safe_dump({"/**": {"ros__parameters": parameters}}))
    words = ["replay", args.bag, "--params-file", args.params_file, "--params-file", more, "-o", folder / "out"]
    words += ["--images", "none", "--no-video", *(["--topic", args.topic] if args.topic else [])]
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        start = time.process_time()
        if main([str(w) for w in words]):
            raise SystemExit("the replay failed; run it by hand with --debug")
        seconds = time.process_time() - start
        main(["evaluate", str(folder / "out"), "--truth", str(args.truth), "--no-page"])
    metrics = json.loads((folder / "out/metrics.json").read_text())["all"]
    for key, factor in COLUMNS.values():
        value = metrics.get(key, {}).get("value")
        yield "-" if value is None else f"{factor * value:.3g}"
    yield f"{1e3 * seconds / metrics['counts']['frames']:.0f}"


def table() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("bag", type=Path)
    parser.add_argument("truth", type=Path)
    parser.add_argument("--params-file", type=Path, required=True)
    parser.add_argument("--topic")
    args = parser.parse_args()
    heads = ["", *COLUMNS, "CPU ms a frame"]
    print("| " + " | ".join(heads) + " |\n|" + " --- |" * len(heads))
    for number, (title, (enter, changes)) in enumerate(VARIANTS.items()):
        with tempfile.TemporaryDirectory() as folder, enter():
            print(f"| {title} | " + " | ".join(run(args, Path(folder), number, changes)) + " |", flush=True)


if __name__ == "__main__":
    table()
