"""Which way round a lone flat marker lies that all but repeats itself: fits `expert.verdict.differing_odds`.

    python benchmarks/lone_turns.py [--worlds 800]    # two minutes

Plates, ellipses and polygons that something small tells from themselves turned, a notch or a tab; and even ones that
have one at each side, at one of them less of it, as gears and rotors. Half of them are drawn as they are, half by eye:
what is small is of another size and in another place, and corners are off. They are seen from straight in front, 12 to
160 pixels long, blurred, with speckle and dents, at times half hidden.
Fitted on even-numbered worlds, told of odd ones; seeded.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from itertools import pairwise
from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from tqdm import tqdm

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.geometry.transforms import Array, Pose
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose import differing, other_layouts
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.turn_evidence import evidence
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.io.objects.outlines import crossing_edges, folded_corner

LABEL, SIDE, EACH = 2, 256, 6  # of an image, pixels; images of each world
SIZES_PX, FINE = (12.0, 160.0), 4
NEAR_RAD = np.radians(15)
Rng = np.random.Generator


def base_of(rng: Rng) -> Array:
    """(n, 2) an outline of length one that is the same after a turn, counter-clockwise."""
    n, high = int(rng.choice([4, 4, 6, 32])), rng.uniform(0.25, 1.0)
    angle = 2 * np.pi * (np.arange(n) + 0.5) / n
    round_about = np.column_stack([np.cos(angle), np.sin(angle)])
    return 0.5 * round_about / np.abs(round_about).max(axis=0) * (1, high)


def with_feature(base: Array, where: float, wide: float, deep: float) -> Array:
    """With a notch, or a tab where it is deep by less than 0, at a share of its first side."""
    first, second = base[0], base[1]
    along = second - first
    across, length = np.array([-along[1], along[0]]) / np.linalg.norm(along), float(np.linalg.norm(along))
    ends = [where - wide / (2 * length), where + wide / (2 * length)]
    foot = [first + float(np.clip(e, 0.02, 0.98)) * along for e in ends]
    return np.vstack([first, foot[0], foot[0] + deep * across, foot[1] + deep * across, foot[1], base[1:]])


def of_like_sides(n: int, where: float, wide: float, deep: float, odd: float) -> Array:
    """An even polygon with the same at each side, as blades of a rotor or teeth of a gear; at one it is less."""
    angle = 2 * np.pi * (np.arange(n) + 0.5) / n
    corners = 0.5 * np.column_stack([np.cos(angle), np.sin(angle)])
    sides = [np.roll(corners, -k, axis=0) for k in range(n)]
    with_each = [with_feature(side, where, wide, deep * (1.0 if k else odd))[:5] for k, side in enumerate(sides)]
    return np.vstack(with_each)


class World(NamedTuple):
    """A marker as it is, and as its file has it."""

    true: Array
    drawn: Array


def world_of(rng: Rng) -> World:
    """One of which both outlines are simple."""
    while True:
        base, n, odd = base_of(rng), int(rng.integers(3, 7)), rng.uniform(0.0, 0.85)
        where, wide, deep = rng.uniform(0.15, 0.85), rng.uniform(0.04, 0.25), rng.uniform(0.02, 0.2)
        deep, several = deep * rng.choice([1.0, -1.0]), rng.random() < 0.5
        feature = where, wide, deep, odd
        true = drawn = of_like_sides(n, *feature) if several else with_feature(base, *feature[:3])
        if rng.random() < 0.5:
            off = rng.normal(0, 0.05), np.exp(rng.normal(0, 0.3)), rng.uniform(0.2, 1.5)
            if several:
                by_eye = where + off[0] / 2, wide * off[1], deep, float(np.clip(1 - (1 - odd) * off[2], 0, 1))
                drawn = of_like_sides(n, *by_eye)
            else:
                drawn = with_feature(base, where + off[0], wide * off[1], deep * off[2])
            drawn = drawn + rng.normal(0, rng.uniform(0, 0.02), drawn.shape)
        if all(crossing_edges(o) is None and folded_corner(o) is None for o in (true, drawn)):
            return World(true, drawn)


def image_of(true: Array, size_px: float, turn: float, rng: Rng) -> NDArray[np.uint8]:
    """Class numbers."""
    zoom, way = 4, np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    at = ((true * (1, -1)) @ way.T * size_px + SIDE / 2 + rng.uniform(-20, 20, 2)) * zoom * (1 << FINE)
    canvas = cv2.fillPoly(np.zeros((zoom * SIDE,) * 2, np.uint8), [np.rint(at).astype(np.int32)], 255, shift=FINE)
    light = cv2.resize(canvas, (SIDE, SIDE), interpolation=cv2.INTER_AREA).astype(np.float32)
    light = cv2.GaussianBlur(light, (0, 0), rng.uniform(0.3, 1.2)) + rng.normal(0, 25, light.shape)
    labels = np.where(cv2.GaussianBlur(light, (0, 0), 0.5) > 127, LABEL, 0).astype(np.uint8)
    return spoilt(labels, size_px, rng)


def spoilt(labels: NDArray[np.uint8], size_px: float, rng: Rng) -> NDArray[np.uint8]:
    """With what lies over an object in the middle."""
    for _ in range(rng.integers(0, 3)):  # glare, dirt
        middle = rng.normal(SIDE / 2, size_px / 2, 2)
        cv2.circle(labels, np.rint(middle).astype(int).tolist(), int(rng.uniform(0, 0.04) * size_px), 0, -1)
    if rng.random() < 0.2:  # somebody's finger
        ends = rng.normal(SIDE / 2, size_px / 2, (2, 2))
        ends = np.rint(ends + (ends - ends.mean(axis=0)) * 9).astype(int)
        cv2.line(labels, ends[0].tolist(), ends[1].tolist(), 0, max(int(0.15 * size_px), 1))
    return labels


class Row(NamedTuple):
    """What was found of H turns of which one is right, which one that is, and whether the file is drawn by eye.

    :ivar speaks: (H, H) pixels that speak for one against one. :ivar more: (2, H) votes and contours against the first.
    """

    speaks: Array
    more: Array
    right: int
    by_eye: bool


class Watched:
    """What the recogniser finds to speak for turns."""

    def __init__(self) -> None:
        self._plain, self.seen = differing.odds_among, list[tuple[Poses, Array, Array]]()
        vars(other_layouts)["odds_among"] = self._odds_among

    def _odds_among(self, finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Array:
        found = evidence(finder, frame, poses[np.zeros(len(poses), int)], poses)
        more = np.stack([found.votes, found.contours])
        outlines = differing.outlines_of(finder.surface, frame, poses)
        speaks = differing.differing_px(differing.worth_of(finder.surface), frame, [[o] for o in outlines])
        self.seen.append((poses, speaks, more))
        return self._plain(finder, frame, poses)


def rows_of(world: World, watched: Watched, rng: Rng) -> list[Row]:
    marker = Marker("m", world.drawn, np.array([-0.5, 0.0]), np.array([0.5, 0.0]), None, Pose.identity())
    model = ObjectModel("lone", (Component("c", (marker,), required=True),))
    recognizer = Recognizer(
        [Target("lone", model, LABEL)], RecognizerConfig(), Segmenter(ImageConfig()), calibrated=False
    )
    out = []
    for _ in range(EACH):
        size, turn = float(np.exp(rng.uniform(*np.log(SIZES_PX)))), rng.uniform(-np.pi, np.pi)
        watched.seen.clear()
        found = recognizer.recognize(image_of(world.true, size, turn, rng)).detections
        for poses, speaks, more in watched.seen[:1] if found else ():
            right = np.flatnonzero([_is_near(R, turn) for R in poses.R])
            if len(right) == 1:
                out.append(Row(speaks, more, int(right[0]), world.drawn is not world.true))
    return out


def _is_near(R: Array, turn: float) -> bool:
    x, y = R[:2, 0]
    return bool(abs((np.arctan2(y, x) - turn + np.pi) % (2 * np.pi) - np.pi) < NEAR_RAD)


def log_shares(weights: Array, row: Row) -> Array:
    """(H,) logarithms of the probability of each turn."""
    factor, least_px = np.exp(weights[:2])
    odds = factor * np.log((row.speaks + least_px) / (row.speaks.T + least_px))
    worth = odds.mean(axis=1) + np.exp(weights[2:]) @ row.more
    return np.asarray(worth - np.logaddexp.reduce(worth))


def log_loss(weights: Array, rows: list[Row]) -> float:
    return -float(np.mean([log_shares(weights, row)[row.right] for row in rows]))


def report(name: str, weights: Array, rows: list[Row]) -> None:
    if not rows:
        return
    shares = [np.exp(log_shares(weights, row)) for row in rows]
    p = np.array([s.max() for s in shares])
    right = np.array([s.argmax() == r.right for s, r in zip(shares, rows, strict=True)])
    first = np.mean([r.right == 0 for r in rows])
    print(f"{name}: {len(rows)} pictures, in which what was found is right in {first:.3f},")
    print(f"  the likeliest turn in {np.mean(right):.3f}; log loss {log_loss(weights, rows):.3f}")
    tell_in_bins(p, right, (0.0, 0.6, 0.75, 0.9, 0.97, 1.01))


def tell_in_bins(p: Array, right: NDArray[np.bool_], edges: Sequence[float]) -> None:
    """How many are right of what is said with about one probability."""
    for low, high in pairwise(edges):
        inside = (p >= low) & (p < high)
        if inside.any():
            said, true = p[inside].mean(), right[inside].mean()
            print(f"  said {low:.2f} to {min(high, 1):.2f}: {inside.sum()} pictures, {said:.3f} said, {true:.3f} right")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--worlds", type=int, default=800)
    parser.add_argument("--seed", type=int, default=7)
    args = parser.parse_args()
    found, watched = list[list[Row]](), Watched()
    for n in tqdm(range(args.worlds)):
        rng = np.random.default_rng([args.seed, n])
        found.append(rows_of(world_of(rng), watched, rng))
    fit, held_out = ([r for rows in found[k::2] for r in rows] for k in (0, 1))
    weights = minimize(log_loss, np.log([1.7, 0.1, 5.0, 0.4]), (fit,), method="Nelder-Mead").x
    print(f"differing_odds: {np.exp(weights).round(3).tolist()}, of {len(fit)} pictures")
    for by_eye, how in ((False, "as they are"), (True, "by eye")):
        for several, turns in ((False, "two turns"), (True, "more")):
            mine = [r for r in held_out if r.by_eye is by_eye and (len(r.speaks) > 2) is several]
            report(f"held out, drawn {how}, {turns}", weights, mine)


if __name__ == "__main__":
    main()
