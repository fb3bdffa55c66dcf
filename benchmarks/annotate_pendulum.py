"""Training examples of the double pendulum: COCO keypoints from every third frame of its hand-made truth.

    python benchmarks/annotate_pendulum.py PENDULUM_DIR OUTPUT.json

PENDULUM_DIR holds ground_truth.csv (file, A: pivot, B: joint, C: tip, in pixels). Frames 0, 3, 6, ... of the
file are used; `score_pendulum.py` scores the rest.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

from coco import Axis, CocoWriter

EVERY = 3
SIZE = (1000, 1000)
DISC_RADIUS_PX = 23.8
MARKERS = ("lower/link", "joint/disc", "tip/disc", "upper/link")


def read_truth(folder: Path) -> list[dict[str, str]]:
    with open(folder / "ground_truth.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def point(row: dict[str, str], name: str) -> tuple[float, float]:
    return float(row[f"{name}_x"]), float(row[f"{name}_y"])


def disc_axis(centre: tuple[float, float]) -> Axis:
    """A disc has no direction: any diameter does."""
    x, y = centre
    return (x - DISC_RADIUS_PX, y), (x + DISC_RADIUS_PX, y)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("output", type=Path)
    args = parser.parse_args()
    writer = CocoWriter(f"double pendulum, every {EVERY}rd frame", ["pendulum"], MARKERS)
    for row in read_truth(args.folder)[::EVERY]:
        image = writer.add_image(row["file"], *SIZE)
        pivot, joint, tip = (point(row, name) for name in "ABC")
        axes = {
            "lower/link": (joint, tip),
            "upper/link": (pivot, joint),
            "joint/disc": disc_axis(joint),
            "tip/disc": disc_axis(tip),
        }
        writer.add_object(image, "pendulum", axes)
    writer.write(args.output)


if __name__ == "__main__":
    main()
