"""Training examples of the MiroSot robots: COCO keypoints from the hand-checked truth of some frames.

    python benchmarks/annotate_mirosot.py MIROSOT_DIR OUTPUT.json [--frames NAME...]

Each robot is an annotation of the category yellow or blue, with its identity as an attribute, as CVAT writes it.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np
from coco import Axis, CocoWriter

from artrec_ros.io.images.decoding import read_image
from artrec_ros.io.objects.object_reader import load_object

EVERY = 3
OBJECT = Path(__file__).parents[1] / "config/objects/mirosot.yaml"
TEAMS = {"Y": "yellow", "B": "blue"}


def axes(robot: dict, model_half_m: float) -> dict[str, Axis]:
    """Axes of the object file's markers, in pixels."""
    angle, scale = np.radians(robot["deg"]), robot["half"] / model_half_m
    ahead, left = np.array([np.cos(angle), np.sin(angle)]), np.array([np.sin(angle), -np.cos(angle)])
    found = {}
    for component in load_object(OBJECT).components:
        for marker in component.markers:
            (x0, y0), (x1, y1) = (
                (np.array([robot["x"], robot["y"]]) + scale * (p[0] * ahead + p[1] * left)).tolist()
                for p in (marker.tail, marker.head)
            )
            found[f"{component.name}/{marker.name}"] = (x0, y0), (x1, y1)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("output", type=Path)
    parser.add_argument("--frames", nargs="+", help=f"names of frames; default: every {EVERY}rd")
    args = parser.parse_args()
    truth = json.loads((args.folder / "truth.json").read_text())
    named = args.frames or sorted(p.name for p in (args.folder / "frames").iterdir())[::EVERY]
    model = load_object(OBJECT)
    half_m = float(np.abs(model.required.markers[0].outline).max())
    markers = [f"{c.name}/{m.name}" for c in model.components for m in c.markers]
    writer = CocoWriter("MiroSot robots", list(TEAMS.values()), markers)
    for name in named:
        height, width = read_image(args.folder / "frames" / name).shape[:2]
        image = writer.add_image(name, width, height)
        for robot in truth[name]:
            if robot.get("deg") is not None:
                attributes = {"identity": robot["pair"]}
                writer.add_object(image, TEAMS[robot["team"]], axes(robot, half_m), attributes)
    writer.write(args.output)


if __name__ == "__main__":
    main()
