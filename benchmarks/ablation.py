"""What each ingredient of recognition in space brings: the same replay with one of them taken away.

    python benchmarks/ablation.py BAG TRUTH --params-file config/aibo.yaml [--topic TOPIC] [--start S --seconds S]

Each row is `artrec replay` and `artrec evaluate` with parameters changed, or, where no parameter takes it away, a
function of the recogniser replaced for the run. Rows that say nothing of a set change nothing there: soft codes where
images are labels, lookalikes where no components are alike, memory where frames are no sequence. Votes at outlines are
not among them: the verdict's evidence of outlines is made of these, and without it nothing is believed.
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

from artrec_ros.core import second_looks
from artrec_ros.core.base.config import RecognizerConfig, rooms_of
from artrec_ros.core.image.codes import Codes
from artrec_ros.core.model import surface
from artrec_ros.core.pose import lookalikes, seeds
from artrec_ros.core.pose import view_bank as bank
from artrec_ros.core.pose.climber import Climber
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.resting import Resting
from artrec_ros.core.verdict.judge import Judge
from artrec_ros.core.verdict.ownership import Shared
from artrec_ros.tools.main import main

COLUMNS = {
    "recognition": ("recognition_rate", 1),
    "right": ("right_rate", 1),
    "false a frame": ("false_per_frame", 1),
    "component precision": ("component_precision", 1),
    "position %": ("position_error_median", 100),
    "rotation deg": ("rotation_error_deg_median", 1),
}


FINDER = WholeObjectFinder


def unfitted(model: Any, frame: Any, poses: Any, *_: Any, **__: Any) -> Any:
    """In place of `Resting._fitted` and `fit_component`: leaves hypotheses where they are."""
    return poses


def ranked(self: Any, frame: Any, poses: Any) -> Any:
    """In place of `WholeObjectFinder.fit_all`: leaves hypotheses where they are, with their votes."""
    return self.ranked(frame, poses)


def unclimbed(self: Any, frame: Any, found: Any, *_: Any) -> Any:
    """In place of searches on the votes."""
    return found


def faceless(index: int, component: Any) -> list[Any]:
    """In place of `surface._face_patches`: bodies still hide, and say nothing."""
    return []


def no_couples(contour: Any, tolerances_px: Any) -> tuple[Any, Any]:
    """In place of `views.blob_couples`."""
    return np.zeros((0, 2)), np.zeros((0, 2))


def no_rivals(surface: Any) -> tuple[list[Any], set[int]]:
    """In place of `lookalikes._placements`."""
    return [], {surface.root}


def unconfirmed(self: Any, verdict: Any) -> str | None:
    """In place of `Judge.reason`."""
    return None if likely(self, verdict.claim.votes, verdict.probability) else "unlikely"


def likely(judge: Any, votes: Any, probability: Any) -> Any:
    return (votes >= judge.min_votes) & (probability >= judge.min_probability)


def by_place(found: Any, frame: Any, judge: Any) -> Shared:
    """In place of `ownership.share_out`: the best at each place, as of labels that nobody owns."""
    rows = []
    for finder, poses in found:
        verdicts = judge.verdicts(finder, poses, frame)
        worth = judge.worth(verdicts)
        rows += [(worth[i], verdicts[i]) for i in np.flatnonzero(worth > 0) if judge.shows_required(verdicts[i])]
    accepted: list[Any] = []
    for _, verdict in sorted(rows, key=lambda r: -r[0]):
        claim = verdict.claim
        mine = [v.claim.poses for v in accepted if v.claim.finder is claim.finder]
        if not mine or not claim.finder.required.is_over(frame.camera, Poses.concatenate(mine), claim.poses).any():
            accepted.append(verdict)
    return Shared(accepted, ())


def hard(self: Any, of_labels: Any) -> Any:
    """In place of `Codes.votes`: a pixel is of the likeliest class and of no other."""
    return np.ascontiguousarray(of_labels[..., self.label], float)  # another order would be compiled for anew


def patches(*changes: tuple[Any, str, Any]) -> Callable[[], contextlib.ExitStack]:
    def enter() -> contextlib.ExitStack:
        stack = contextlib.ExitStack()
        for owner, name, value in changes:
            stack.enter_context(mock.patch.object(owner, name, value))
        return stack

    return enter


# what replaces functions, and what changes parameters: of the recogniser, of its rooms by their names
VARIANTS: dict[str, tuple[Callable[[], contextlib.ExitStack], dict[str, Any]]] = {
    "all of it": (patches(), {}),
    "each frame alone: no memory": (patches(), {"memory": False}),
    "without fits to contours": (
        patches((FINDER, "fit_all", ranked), (Resting, "_fitted", unfitted), (seeds, "fit_component", unfitted)),
        {},
    ),
    "without the local search on votes": (patches((Climber, "climb", unclimbed), (Climber, "sweep", unclimbed)), {}),
    "without the bodies' faces": (patches((surface, "_face_patches", faceless)), {}),
    "votes of the likeliest class, not of its share": (patches((Codes, "votes", hard)), {}),
    "without mirrored turns": (patches((FINDER, "flips", lambda self, found: self.surface.no_poses)), {}),
    "without lookalikes": (patches((lookalikes, "_placements", no_rivals)), {}),
    "without taking sure objects' pixels first": (
        patches(), {"search": {"sure": 2.0, "likely": 2.0}}),
    "starting from the required component alone": (
        patches((seeds.Seeds, "_of_limbs", lambda self, *_: self._surface.no_poses)), {}),
    "blobs aligned by moments alone": (patches((bank, "blob_couples", no_couples)), {}),
    "the best at each place, no pixels owned": (patches((second_looks, "share_out", by_place)), {}),
    "required component need not be confirmed": (
        patches((Judge, "accepts", lambda self, all_: likely(self, all_.claims.votes, all_.probability)),
                (Judge, "reason", unconfirmed)), {}),
    "objects of any probability": (patches(), {"min_probability": 0.0}),
    "components of any probability": (patches(), {"min_component_probability": 0.0}),
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
    words += ["--start-offset", args.start, *(["--playback-duration", args.seconds] if args.seconds else [])]
    with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
        start = time.process_time()
        if main([str(w) for w in words]):
            raise SystemExit("the replay failed; run it by hand with --debug")
        seconds = time.process_time() - start
        main(["evaluate", str(folder / "out"), "--truth", str(args.truth), "--common", "--no-page"])
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
    parser.add_argument("--start", type=float, default=0.0, help="seconds of the bag that are skipped")
    parser.add_argument("--seconds", type=float, help="of the bag after that; default: all of it")
    parser.add_argument("--only", nargs="+", default=[""], help="rows whose names contain one of these")
    args = parser.parse_args()
    heads = ["", *COLUMNS, "CPU ms a frame"]
    print("| " + " | ".join(heads) + " |\n|" + " --- |" * len(heads))
    for number, (title, (enter, changes)) in enumerate(VARIANTS.items()):
        if not any(word in title for word in args.only):
            continue
        with tempfile.TemporaryDirectory() as folder, enter():
            print(f"| {title} | " + " | ".join(run(args, Path(folder), number, changes)) + " |", flush=True)


if __name__ == "__main__":
    table()
