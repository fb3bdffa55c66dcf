"""Robots found, missed and invented, against `vss_patches.py`'s measurement of every frame.

    python benchmarks/score_vss.py VSS_DIR DETECTIONS.jsonl

A robot is found when a detection of its team has the team's patch and the accent within 5 px of the measured ones
(8 px for a patch that a blanked rectangle cuts). What matches no robot is invented.
"""

from __future__ import annotations

import numpy as np
from annotate_vss import EVERY
from replayed import folder_and_objects
from shipped import image_config
from vss_patches import Patch, Robot, frame_paths, measure

from artrec_ros.io.images.decoding import read_image

NEAR_PX, NEAR_CUT_PX = 5.0, 8.0


def is_at(component: dict | None, patch: Patch) -> bool:
    near = NEAR_CUT_PX if patch.cut else NEAR_PX
    return component is not None and bool(np.hypot(component["x"] - patch.x, component["y"] - patch.y) <= near)


def matches(detected: dict, robot: Robot) -> bool:
    parts = {c["name"]: c for c in detected["components"]}
    same_team = detected["object"] == robot.team
    return same_team and is_at(parts.get("team"), robot.patch) and is_at(parts.get("accent"), robot.accent)


def frame_counts(robots: list[Robot], detected: list[dict]) -> tuple[int, int, int]:
    """(robots, found, invented)."""
    left = list(detected)
    for robot in robots:
        hit = next((d for d in left if matches(d, robot)), None)
        if hit is not None:
            left.remove(hit)
    return len(robots), len(detected) - len(left), len(left)


def report(title: str, counts: dict[str, tuple[int, int, int]]) -> None:
    there, found, invented = (sum(column) for column in zip(*counts.values(), strict=True))
    complete = sum(c[1] == c[0] and not c[2] for c in counts.values())
    five = sum(c[1] >= 5 for c in counts.values())
    print(
        f"{title}: {found} of {there} robots found, {invented} invented; {complete} of {len(counts)} frames without "
        f"a fault, five robots in {five}"
    )
    for name, (n, hit, wrong) in counts.items():
        if hit < n or wrong:
            print(f"  {name}: {hit} of {n} found, {wrong} invented")


def main() -> None:
    folder, frames = folder_and_objects(str(__doc__))
    config = image_config("vss")
    counts = {
        path.name: frame_counts(measure(read_image(path), config), frames.get(path.name, []))
        for path in frame_paths(folder)
    }
    trained = list(counts)[::EVERY]
    report("not trained on", {n: c for n, c in counts.items() if n not in trained})
    report("all", counts)


if __name__ == "__main__":
    main()
