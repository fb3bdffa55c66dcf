"""Training examples of the soccer robots: COCO keypoints from every third frame, measured by `vss_patches.py`.

    python benchmarks/annotate_vss.py VSS_DIR OUTPUT.json [--overlays DIR]

Frames 0, 3, 6, ... by name are used. A patch that a blanked rectangle cuts is left unlabelled. The axis of the team's
patch is that side's direction from which the accent lies at about +45 degrees (towards +y); the accent's axis runs the
same way. `--overlays` draws what was measured in every frame, to be looked at.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import cv2
import numpy as np
from coco import Axis, CocoWriter
from shipped import image_config
from vss_patches import TEAMS, Patch, Robot, frame_paths, measure

from artrec_ros.io.images.decoding import read_image

EVERY = 3
MARKERS = ("team/patch", "accent/patch")


def axes(robot: Robot) -> dict[str, Axis]:
    towards_accent = np.arctan2(robot.accent.y - robot.patch.y, robot.accent.x - robot.patch.x)
    patches = zip(MARKERS, (robot.patch, robot.accent), strict=True)
    return {name: _axis(p, towards_accent - np.pi / 4) for name, p in patches if not p.cut}


def _axis(patch: Patch, near_rad: float) -> Axis:
    quarter = np.pi / 2
    theta = patch.theta + quarter * round((near_rad - patch.theta) / quarter)
    dx, dy = patch.side_px / 2 * np.cos(theta), patch.side_px / 2 * np.sin(theta)
    return (patch.x - dx, patch.y - dy), (patch.x + dx, patch.y + dy)


def draw(image: np.ndarray, robots: list[Robot]) -> np.ndarray:
    """Twice the size; an arrow along each axis, a number of robots."""
    canvas = cv2.resize(image, None, fx=2, fy=2)
    for robot in robots:
        for tail, head in axes(robot).values():
            ends = [tuple(int(round(2 * v)) for v in end) for end in (tail, head)]
            cv2.arrowedLine(canvas, ends[0], ends[1], (255, 0, 255), 1, tipLength=0.4)
        at = (int(2 * robot.patch.x) + 20, int(2 * robot.patch.y) - 20)
        cv2.putText(canvas, robot.team, at, cv2.FONT_HERSHEY_SIMPLEX, 0.5, (255, 255, 255), 1)
    cv2.putText(canvas, f"{len(robots)} robots", (200, 920), cv2.FONT_HERSHEY_SIMPLEX, 0.8, (255, 255, 255), 2)
    return canvas


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("--overlays", type=Path)
    args = parser.parse_args()
    config = image_config("vss")
    writer = CocoWriter(f"soccer robots, every {EVERY}rd frame", list(TEAMS), MARKERS)
    for number, path in enumerate(frame_paths(args.folder)):
        image = read_image(path)
        robots = measure(image, config)
        if args.overlays:
            args.overlays.mkdir(parents=True, exist_ok=True)
            cv2.imwrite(str(args.overlays / f"{path.stem}.png"), draw(image, robots))
        if number % EVERY:
            continue
        image_id = writer.add_image(f"frames/{path.name}", image.shape[1], image.shape[0])
        for robot in robots:
            writer.add_object(image_id, robot.team, axes(robot))
    writer.write(args.output)


if __name__ == "__main__":
    main()
