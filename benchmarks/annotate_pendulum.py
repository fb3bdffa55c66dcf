"""Training examples of the double pendulum: COCO keypoints of every third frame, links from its hand-made truth.

    python benchmarks/annotate_pendulum.py PENDULUM_DIR OUTPUT.json

PENDULUM_DIR holds ground_truth.csv (file, A: pivot, B: joint, C: tip, in pixels). Frames 0, 3, 6, ... of the
file are used; `score_pendulum.py` scores the rest. The discs' places and sizes are those of their colour blobs:
examples must scatter as images do, and the truth has one point for a disc and the end of its link.
"""

from __future__ import annotations

import argparse
import csv
from pathlib import Path

import cv2
import numpy as np
from coco import Axis, CocoWriter
from shipped import image_config

from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.io.images.decoding import read_image

EVERY = 3
DISCS = {"joint/disc": 2, "tip/disc": 3}  # class labels
MARKERS = ("lower/link", "joint/disc", "tip/disc", "upper/link")


def read_truth(folder: Path) -> list[dict[str, str]]:
    with open(folder / "ground_truth.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def point(row: dict[str, str], name: str) -> tuple[float, float]:
    return float(row[f"{name}_x"]), float(row[f"{name}_y"])


def disc_axis(labels: np.ndarray, label: int) -> Axis:
    """Of the largest blob of a class. A disc has no direction: any diameter does."""
    _, _, stats, centres = cv2.connectedComponentsWithStats((labels == label).astype(np.uint8))
    largest = 1 + int(np.argmax(stats[1:, cv2.CC_STAT_AREA]))
    x, y = centres[largest]
    radius = float(np.sqrt(stats[largest, cv2.CC_STAT_AREA] / np.pi))
    return (x - radius, y), (x + radius, y)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("output", type=Path)
    args = parser.parse_args()
    writer = CocoWriter(f"double pendulum, every {EVERY}rd frame", ["pendulum"], MARKERS)
    segmenter = Segmenter(image_config("pendulum"))
    for row in read_truth(args.folder)[::EVERY]:
        labels = segmenter.labels(read_image(args.folder / row["file"]))
        image = writer.add_image(row["file"], labels.shape[1], labels.shape[0])
        pivot, joint, tip = (point(row, name) for name in "ABC")
        axes = {"lower/link": (joint, tip), "upper/link": (pivot, joint)}
        axes |= {marker: disc_axis(labels, label) for marker, label in DISCS.items()}
        writer.add_object(image, "pendulum", axes)
    writer.write(args.output)


if __name__ == "__main__":
    main()
