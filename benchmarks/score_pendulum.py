"""Errors of both links' directions against the hand-made truth.

    python benchmarks/score_pendulum.py PENDULUM_DIR DETECTIONS.jsonl

Reports the frames that `annotate_pendulum.py` did not use, and all. A frame is right when both links are found and
both directions are within 2 degrees.
"""

from __future__ import annotations

import math
from pathlib import Path
from statistics import median

from annotate_pendulum import EVERY, point, read_truth
from replayed import folder_and_objects

RIGHT_DEG = 2.0


def direction(tail: tuple[float, float], head: tuple[float, float]) -> float:
    return math.atan2(head[1] - tail[1], head[0] - tail[0])


def frame_errors(row: dict[str, str], detected: dict | None) -> dict[str, float]:
    """Degrees per link; infinite where it was not found."""
    pivot, joint, tip = (point(row, name) for name in "ABC")
    truth = {"upper": direction(pivot, joint), "lower": direction(joint, tip)}
    found = {c["name"]: c["theta"] for c in detected["components"]} if detected else {}
    return {
        name: abs(math.degrees(math.remainder(found[name] - theta, math.tau))) if name in found else math.inf
        for name, theta in truth.items()
    }


def report(title: str, errors: dict[str, dict[str, float]], pendulums: dict[str, int]) -> None:
    right = sum(max(e.values()) <= RIGHT_DEG for e in errors.values())
    extra = sum(max(0, pendulums[name] - 1) for name in errors)
    medians = {name: median(e[name] for e in errors.values()) for name in ("lower", "upper")}
    print(
        f"{title}: {right} of {len(errors)} frames right, median error lower {medians['lower']:.2f} deg, "
        f"upper {medians['upper']:.2f} deg, {extra} pendulums invented"
    )
    for name, e in errors.items():
        if max(e.values()) > RIGHT_DEG:
            print(f"  {name}: lower {e['lower']:.2f} deg, upper {e['upper']:.2f} deg")


def main() -> None:
    folder, frames = folder_and_objects(str(__doc__))
    rows = {Path(row["file"]).name: row for row in read_truth(folder)}
    errors = {name: frame_errors(row, next(iter(frames.get(name, [])), None)) for name, row in rows.items()}
    pendulums = {name: len(frames.get(name, [])) for name in rows}
    trained = list(rows)[::EVERY]
    report("not trained on", {n: e for n, e in errors.items() if n not in trained}, pendulums)
    report("all", errors, pendulums)


if __name__ == "__main__":
    main()
