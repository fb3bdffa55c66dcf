"""The patches of soccer robots measured without the recogniser: colour blobs, paired by what lies next to what.

Simple, and good only for these frames: its result was looked at frame by frame before it was used as a reference.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.image.segmentation import Segmenter

TEAMS = {"yellow": 1, "blue": 2}
ACCENT = 3
LEAST_PX = 60  # a patch has 100 to 170 pixels
REACH_PX = 22.0  # the patches' centres are some 17 px apart


@dataclass(frozen=True)
class Patch:
    """:param theta: direction of a side, radians, modulo 90 degrees. :param cut: it ends at a blanked rectangle."""

    x: float
    y: float
    side_px: float
    theta: float
    cut: bool


@dataclass(frozen=True)
class Robot:
    team: str
    patch: Patch
    accent: Patch


def frame_paths(folder: Path) -> list[Path]:
    return sorted((folder / "frames").glob("*.jpg"))


def measure(image: np.ndarray, config: ImageConfig) -> list[Robot]:
    """Every robot of a frame: a team's patch with the nearest accent patch; each accent serves one robot."""
    labels = Segmenter(config).labels(image)
    accents = _patches(labels == ACCENT, config)
    pairs = [
        (float(np.hypot(p.x - a.x, p.y - a.y)), team, p, a)
        for team, label in TEAMS.items()
        for p in _patches(labels == label, config)
        for a in accents
    ]
    robots: list[Robot] = []
    for distance, team, patch, accent in sorted(pairs, key=lambda pair: pair[0]):
        taken = any(patch is r.patch or accent is r.accent for r in robots)
        if distance < REACH_PX and not taken:
            robots.append(Robot(team, patch, accent))
    return robots


def _patches(mask: np.ndarray, config: ImageConfig) -> list[Patch]:
    count, zone, stats, centres = cv2.connectedComponentsWithStats(mask.astype(np.uint8), connectivity=4)
    patches = []
    for i in range(1, count):
        x, y, width, height, area = stats[i].tolist()
        if area < LEAST_PX:
            continue
        points = np.argwhere(zone == i)[:, ::-1].astype(np.float32)
        angle = np.radians(cv2.minAreaRect(points)[2])
        cut = any(
            x <= bx + bw and x + width >= bx and y <= by + bh and y + height >= by
            for bx, by, bw, bh in np.reshape(config.blank, (-1, 4)).tolist()
        )
        patches.append(Patch(float(centres[i][0]), float(centres[i][1]), float(np.sqrt(area)), float(angle), cut))
    return patches
