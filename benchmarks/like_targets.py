"""Which of two targets that look alike is seen: fits `expert.verdict.rival_odds`.

    python benchmarks/like_targets.py [--worlds 400]    # five minutes

Lone outlines, with and without a notch or tab, or with a larger one; and two to six patches of one to three classes,
and the same with one more, one elsewhere, one of another class or size, or the classes of two exchanged. Half of them
are drawn as they are, half by eye. They are seen from straight in front, 16 to 160 pixels long, blurred, with speckle
and dents, at times half hidden. Fitted on even-numbered worlds, told of odd ones; seeded.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np
from lone_turns import FINE, SIDE, Rng, base_of, spoilt, tell_in_bins, with_feature
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
from artrec_ros.core.pose.between_targets import Laid, Said, said_of
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict import other_objects
from artrec_ros.io.objects.outlines import crossing_edges, folded_corner

EACH = 4  # images of each world
SIZES_PX = 16.0, 160.0
FIRST_LABEL, ZOOM = 2, 4
NEVER = 1e-6  # no probability is less
Piece = tuple[int, Array]  # class, and an outline (n, 2)


class World(NamedTuple):
    """Two objects, about one long, as they are, and as their files have them."""

    true: tuple[list[Piece], list[Piece]]
    drawn: tuple[list[Piece], list[Piece]]


def lone_pair(rng: Rng) -> tuple[list[Piece], list[Piece]]:
    base, where, wide, deep = base_of(rng), rng.uniform(0.15, 0.85), rng.uniform(0.05, 0.25), rng.uniform(0.04, 0.2)
    deep *= rng.choice([1.0, -1.0])
    one = with_feature(base, where, wide, deep)
    other = base if rng.random() < 0.5 else with_feature(base, where, wide, deep * rng.uniform(0.2, 0.7))
    return [(0, one)], [(0, other)]


def patch(rng: Rng, at: Array, size: float) -> Array:
    n = int(rng.choice([3, 4, 5, 24]))
    angle = 2 * np.pi * np.arange(n) / n + rng.uniform(0, 2 * np.pi)
    return np.asarray(at + size * np.column_stack([np.cos(angle), np.sin(angle)]))


def pattern_pair(rng: Rng) -> tuple[list[Piece], list[Piece]]:
    n, classes, size = int(rng.integers(2, 7)), int(rng.integers(1, 4)), rng.uniform(0.08, 0.14)
    cells = np.array([(x, y) for x in range(3) for y in range(3)], float)
    at = (rng.permutation(cells)[: n + 1] - 1) * 0.38 + rng.uniform(-0.04, 0.04, (n + 1, 2))
    pieces = [(int(rng.integers(classes)), patch(rng, place, size)) for place in at[:n]]
    other, k, what = list(pieces), int(rng.integers(1, n)), int(rng.integers(5))
    label, outline = other[k]
    if what == 0:
        other.append((int(rng.integers(classes)), patch(rng, at[n], size)))
    elif what == 1:
        other[k] = label, outline + at[n] - at[k]
    elif what == 2:
        other[k] = (label + 1) % max(classes, 2), outline
    elif what == 3:
        middle = outline.mean(axis=0)
        other[k] = label, middle + (outline - middle) * rng.choice([0.6, 0.75, 1.3])
    else:
        other[0], other[k] = (other[k][0], other[0][1]), (other[0][0], other[k][1])
    return pieces, other


def by_eye(rng: Rng, outline: Array, off: float, of: int) -> Array:
    """An outline as it is drawn: of lone ones corners are off, of several they are off as wholes."""
    if of == 1:
        return outline + rng.normal(0, off, outline.shape)
    middle = outline.mean(axis=0)
    return np.asarray(middle + rng.normal(0, off, 2) + (outline - middle) * np.exp(rng.normal(0, 4 * off)))


def world_of(rng: Rng) -> World:
    """One whose outlines are simple."""
    while True:
        true = lone_pair(rng) if rng.random() < 0.5 else pattern_pair(rng)
        drawn = true
        if rng.random() < 0.5:  # by eye
            off = rng.uniform(0, 0.02)
            one, other = ([(label, by_eye(rng, o, off, len(pieces))) for label, o in pieces] for pieces in true)
            drawn = one, other
        outlines = [o for pieces in (*true, *drawn) for _, o in pieces]
        if all(crossing_edges(o) is None and folded_corner(o) is None for o in outlines):
            return World(true, drawn)


def image_of(true: Sequence[Piece], size_px: float, rng: Rng) -> NDArray[np.uint8]:
    """Class numbers."""
    turn, shift = rng.uniform(-np.pi, np.pi), SIDE / 2 + rng.uniform(-20, 20, 2)
    way, blur = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]]), rng.uniform(0.3, 1.2)
    light = [np.full((SIDE, SIDE), 127, np.float32)]
    for label in range(1 + max(label for label, _ in true)):
        canvas = np.zeros((ZOOM * SIDE,) * 2, np.uint8)
        for own, outline in true:
            at = ((outline * (1, -1)) @ way.T * size_px + shift) * ZOOM * (1 << FINE)
            if own == label:
                cv2.fillPoly(canvas, [np.rint(at).astype(np.int32)], 255, shift=FINE)
        seen = cv2.resize(canvas, (SIDE, SIDE), interpolation=cv2.INTER_AREA).astype(np.float32)
        light.append(cv2.GaussianBlur(seen, (0, 0), blur) + rng.normal(0, 25, seen.shape))
    most = np.argmax([cv2.GaussianBlur(of, (0, 0), 0.5) for of in light], axis=0)
    labels = np.where(most > 0, most - 1 + FIRST_LABEL, 0).astype(np.uint8)
    return spoilt(labels, size_px, rng)


def target_of(name: str, pieces: Sequence[Piece]) -> Target:
    components = []
    for k, (label, outline) in enumerate(pieces):
        low, high = outline.min(axis=0), outline.max(axis=0)
        middle = (low[1] + high[1]) / 2
        axis = np.array([low[0], middle]), np.array([high[0], middle])
        marker = Marker(f"m{k}", outline, *axis, None, Pose.identity())
        own = None if k == 0 else FIRST_LABEL + label
        components.append(Component(f"c{k}", (marker,), required=k == 0, label=own))
    return Target(name, ObjectModel(name, tuple(components)), FIRST_LABEL + pieces[0][0])


class Row(NamedTuple):
    """What was found to speak for a rival, and whether it is the one that is there.

    :ivar lone: whether it is about lone outlines.
    """

    said: Said
    right: bool
    lone: bool
    by_eye: bool


class Watched:
    """What the recogniser finds to speak for rivals."""

    def __init__(self) -> None:
        self.seen = list[tuple[str, Said]]()
        vars(other_objects)["said_of"] = self._said_of

    def _said_of(self, frame: ImageFrame, own: Laid, rival: Laid) -> Said:
        said = said_of(frame, own, rival)
        self.seen.append((rival.finder.target.name, said))
        return said


class Told(NamedTuple):
    """An object that is told, and whether it is of the target that is there."""

    score: float
    right: bool


def rows_of(world: World, watched: Watched, rng: Rng) -> tuple[list[Row], list[Told]]:
    targets = [target_of(name, pieces) for name, pieces in zip("ab", world.drawn, strict=True)]
    recognizer = Recognizer(targets, RecognizerConfig(), Segmenter(ImageConfig()), calibrated=False)
    out, told = list[Row](), list[Told]()
    for _ in range(EACH):
        which, size = int(rng.integers(2)), float(np.exp(rng.uniform(*np.log(SIZES_PX))))
        watched.seen.clear()
        found = recognizer.recognize(image_of(world.true[which], size, rng)).detections
        lone, drawn_by_eye = len(world.true[0]) == 1, world.drawn is not world.true
        out += [Row(said, name == "ab"[which], lone, drawn_by_eye) for name, said in watched.seen[:1]]
        told += [Told(d.score, d.object == "ab"[which]) for d in found[:1]]
    return out, told


def probability(weights: Array, row: Row) -> float:
    p = 1 / (1 + np.exp(-row.said.log_odds(np.exp(weights))))
    return float(np.clip(p, NEVER, 1 - NEVER))


def log_loss(weights: Array, rows: Sequence[Row]) -> float:
    p = np.array([probability(weights, row) for row in rows])
    return -float(np.log(np.where([row.right for row in rows], p, 1 - p)).mean())


def report(name: str, p: Array, right: NDArray[np.bool_]) -> None:
    print(f"{name}: {len(p)}, {np.mean(right):.3f} right")
    tell_in_bins(p, right, (0.0, 0.5, 0.6, 0.75, 0.9, 0.97, 1.01))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--worlds", type=int, default=400)
    parser.add_argument("--seed", type=int, default=5)
    args = parser.parse_args()
    found, watched = list[tuple[list[Row], list[Told]]](), Watched()
    for n in tqdm(range(args.worlds)):
        rng = np.random.default_rng([args.seed, n])
        found.append(rows_of(world_of(rng), watched, rng))
    fit, held_out = ([r for rows, _ in found[k::2] for r in rows] for k in (0, 1))
    start = np.log(RecognizerConfig().verdict.rival_odds)
    weights = minimize(log_loss, start, (fit,), method="Nelder-Mead").x
    print(f"rival_odds: {np.exp(weights).round(3).tolist()}, of {len(fit)} pictures")
    print(f"log loss held out: {log_loss(weights, held_out):.3f}, as configured {log_loss(start, held_out):.3f}")
    for lone, what in ((True, "lone outlines"), (False, "patterns")):
        for by_eye, how in ((False, "as they are"), (True, "by eye")):
            mine = [r for r in held_out if r.lone is lone and r.by_eye is by_eye]
            p = np.array([probability(weights, r) for r in mine])
            likelier = np.array([r.right for r in mine]) == (p > 0.5)
            report(f"held out, {what}, drawn {how}", np.maximum(p, 1 - p), likelier)
    told = [t for _, mine in found[1::2] for t in mine]
    report("as configured, what is told", np.array([t.score for t in told]), np.array([t.right for t in told]))


if __name__ == "__main__":
    main()
