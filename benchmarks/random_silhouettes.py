"""Silhouettes made up at random, turned and scaled as those of the MPEG-7 set are, for benchmarks/mpeg7.py.

    python benchmarks/random_silhouettes.py FOLDER && python benchmarks/mpeg7.py FOLDER

Ten kinds: discs and plates with notches, gears with an odd tooth, lobes, bodies with limbs, polygons, waves, open
rings, springs, ellipses with a bump. Many all but repeat themselves: what tells their turn is small. Seeded.
"""

from __future__ import annotations

import argparse
import math
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
from mpeg7 import ROTATIONS_DEG, SCALES
from numpy.typing import NDArray
from tqdm import tqdm

SIDE, EACH, SEED = 520, 9, 23  # of a picture, pixels; silhouettes of a kind
FINE = 4  # bits of a pixel's fraction
Picture = NDArray[np.uint8]
Rng = np.random.Generator


def filled(points: NDArray[np.float64]) -> Picture:
    """:param points: (n, 2) about the middle, pixels."""
    picture = np.zeros((SIDE, SIDE), np.uint8)
    cv2.fillPoly(picture, [np.rint((points + SIDE / 2) * (1 << FINE)).astype(np.int32)], 255, shift=FINE)
    return picture


def drawn(points: NDArray[np.float64], width: float) -> Picture:
    """A line (n, 2) about the middle."""
    picture = np.zeros((SIDE, SIDE), np.uint8)
    cv2.polylines(picture, [np.rint(points + SIDE / 2).astype(np.int32)], False, 255, round(width))
    return picture


def round_about(radius: NDArray[np.float64]) -> NDArray[np.float64]:
    """(n, 2) points at these distances (n,) all around."""
    angle = np.linspace(0, 2 * np.pi, len(radius), endpoint=False)
    return radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def notched_disc(rng: Rng) -> Picture:
    angle = np.abs(np.linspace(-np.pi, np.pi, 4000, endpoint=False))
    return filled(round_about(np.where(angle < rng.uniform(0.015, 0.07), rng.uniform(100, 200), 220.0)))


def notched_plate(rng: Rng) -> Picture:
    width, height, half = *rng.uniform(80, 220, 2), rng.uniform(8, 25)
    at, deep = rng.uniform(-width + 2 * half, width - 2 * half), rng.uniform(10, 40)
    notch = [(at - half, -height), (at - half, deep - height), (at + half, deep - height), (at + half, -height)]
    return filled(np.array([(-width, -height), *notch, (width, -height), (width, height), (-width, height)]))


def gear(rng: Rng) -> Picture:
    teeth, tooth = int(rng.integers(4, 13)), rng.uniform(20, 60)
    angle = np.linspace(0, 2 * np.pi, 4000, endpoint=False)
    odd = angle < 2 * np.pi / teeth  # one has no tooth
    return filled(round_about(np.where(odd, 180 - tooth, 180 + tooth * np.sign(np.sin(teeth * angle)))))


def lobes(rng: Rng) -> Picture:
    angle, n = np.linspace(0, 2 * np.pi, 2000, endpoint=False), int(rng.integers(2, 11))
    radius = 150 + rng.uniform(15, 70) * np.cos(n * angle) + rng.uniform(5, 20) * np.cos(angle + rng.uniform(0, 6))
    return filled(round_about(radius + rng.uniform(0, 10) * np.cos(2 * angle)))


def limbs(rng: Rng) -> Picture:
    picture = np.zeros((SIDE, SIDE), np.uint8)
    axes = round(rng.uniform(50, 120)), round(rng.uniform(40, 90))
    cv2.ellipse(picture, (SIDE // 2, SIDE // 2), axes, rng.uniform(0, 180), 0, 360, 255, -1)
    for _ in range(rng.integers(2, 7)):
        first, bend, reach = rng.uniform(0, 2 * np.pi), rng.normal(0, 0.5), rng.uniform(120, 220)
        middle = 0.6 * reach * np.array([math.cos(first), math.sin(first)])
        end = middle + 0.4 * reach * np.array([math.cos(first + bend), math.sin(first + bend)])
        picture |= drawn(np.stack([np.zeros(2), middle, end]), rng.uniform(8, 36))
    return picture


def polygon(rng: Rng) -> Picture:
    n, inner = int(rng.integers(3, 9)), rng.uniform(0.3, 0.8)
    return filled(round_about(230 * np.tile([1.0, inner], n) * rng.uniform(0.85, 1, 2 * n)))


def wave(rng: Rng) -> Picture:
    x = np.linspace(-210, 210, 400)
    y = rng.uniform(40, 120) * np.sin(x * rng.uniform(0.02, 0.05) + rng.uniform(0, 6)) + rng.uniform(0, 0.2) * x
    return drawn(np.stack([x, y], axis=1), rng.uniform(14, 40))


def open_ring(rng: Rng) -> Picture:
    picture = np.zeros((SIDE, SIDE), np.uint8)
    axes, width = rng.uniform(120, 215, 2).astype(int).tolist(), round(rng.uniform(20, 70))
    cv2.ellipse(picture, (SIDE // 2, SIDE // 2), axes, rng.uniform(0, 180), 0, rng.uniform(180, 330), 255, width)
    return picture


def spring(rng: Rng) -> Picture:
    turns = int(rng.integers(4, 9))
    x, y = np.linspace(-200, 200, 2 * turns), rng.uniform(40, 120) * np.tile([1.0, -1.0], turns)
    y[[0, -1]] = 0
    return drawn(np.stack([x, y], axis=1), rng.uniform(10, 20))


def bump(rng: Rng) -> Picture:
    angle, wide, high = np.linspace(0, 2 * np.pi, 2000, endpoint=False), 200.0, rng.uniform(110, 170)
    outline = np.stack([wide * np.cos(angle), high * np.sin(angle)], axis=1)
    picture, at = filled(outline), rng.uniform(0, 2 * np.pi)
    place = round(SIDE / 2 + wide * math.cos(at)), round(SIDE / 2 + high * math.sin(at))
    cv2.circle(picture, place, round(rng.uniform(18, 40)), 255, -1)
    return picture


KINDS: tuple[Callable[[Rng], Picture], ...] = (
    notched_disc, notched_plate, gear, lobes, limbs, polygon, wave, open_ring, spring, bump,
)  # fmt: skip


def write(folder: Path, name: str, picture: Picture) -> None:
    """The picture as it is, scaled and turned: nearest neighbours, as the set has it."""
    for part in ("scale", "rotation"):
        (folder / part).mkdir(parents=True, exist_ok=True)
    cv2.imwrite(str(folder / "scale" / f"{name}-1.png"), picture)
    for n, scale in SCALES.items():
        T = np.array([[scale, 0, (scale - 1) / 2], [0, scale, (scale - 1) / 2]])
        scaled = cv2.warpAffine(picture, T, (round(SIDE * scale),) * 2, flags=cv2.INTER_NEAREST)
        cv2.imwrite(str(folder / "scale" / f"{name}-{n}.png"), scaled)
    side, middle = math.ceil(SIDE * math.sqrt(2)) + 2, (SIDE - 1) / 2
    for n, angle in ROTATIONS_DEG.items():
        T = cv2.getRotationMatrix2D((middle, middle), angle, 1.0)
        T[:, 2] += (side - 1) / 2 - middle
        turned = cv2.warpAffine(picture, T, (side, side), flags=cv2.INTER_NEAREST)
        cv2.imwrite(str(folder / "rotation" / f"{name}-{n}.png"), turned)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path, help="made where it is missing")
    parser.add_argument("--seed", type=int, default=SEED, help="of the silhouettes (%(default)s)")
    args = parser.parse_args()
    rng = np.random.default_rng(args.seed)
    for kind in tqdm(KINDS):
        for n in range(EACH):
            write(args.folder, f"{kind.__name__}_{n}", kind(rng))


if __name__ == "__main__":
    main()
