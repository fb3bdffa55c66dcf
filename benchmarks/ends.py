"""Where long flat markers end that something touches, or of which labels are wider or narrower: fits
`expert.verdict.far_end_odds`.

    python benchmarks/ends.py [--worlds 800]    # five minutes

Bars alone, 60 to 300 px long and 6 to 20 times as long as wide, seen from straight in front, blurred, with ragged edges
and labels 0.3 px off all around, outwards or inwards. Half of them are no more than that; of a sixth the outermost half
to two pixels are lost, of a twelfth one end is up to a twelfth of the length off, of a twelfth one is covered by a
sixteenth to a third of the length; at one end of a sixth lies something of their class, as long: straight on, slanted,
or wider.
Fitted on even-numbered worlds, told of odd ones; seeded. Right is what is no more than a twentieth of the length off.
"""

from __future__ import annotations

import argparse
from typing import ClassVar, NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from tqdm import tqdm

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Array, Pose
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose import finder
from artrec_ros.core.pose.other_ends import OtherEnds, Seen
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.recognizer import Recognizer

STRAYS = "straight", "slanted", "wider"  # at one end
LABEL, SIZE, FINE, BITS = 2, (560, 440), 4, 4
KINDS = {"plain": 1 / 2, "thin": 1 / 6, "end off": 1 / 12, "covered": 1 / 12, **dict.fromkeys(STRAYS, 1 / 18)}
OFF = 0.05  # of the length
Rng = np.random.Generator


class World(NamedTuple):
    """A bar of length one, as often as long as wide as `aspect`, and how it looks. :ivar ends: (2, 2) pixels."""

    kind: str
    aspect: float
    ends: Array
    image: NDArray[np.uint8]

    @property
    def length(self) -> float:
        return float(np.linalg.norm(self.ends[1] - self.ends[0]))

    def off(self, ends: Array) -> float:
        """The farther one's distance from where it is, as a share of the length, be it turned by half."""
        return min(np.linalg.norm(e - self.ends, axis=1).max() for e in (ends, ends[::-1])) / self.length


def world_of(rng: Rng) -> World:
    kind, length = str(rng.choice(list(KINDS), p=list(KINDS.values()))), np.exp(rng.uniform(*np.log([60.0, 300.0])))
    aspect = min(rng.uniform(6, 20), length / 4)
    turn, middle = rng.uniform(-np.pi, np.pi), np.array(SIZE) / 2 + rng.uniform(-40, 40, 2)
    inside = float(rng.choice([0.5, 1.0, 1.5, 2.0])) if kind == "thin" else float(rng.normal(0, 0.3))
    inside = min(inside, (length / aspect - 2.5) / 2)
    along = np.array([np.cos(turn), np.sin(turn)])
    frame = np.stack([along, [-along[1], along[0]]]) * length
    shapes = [shape @ frame + middle for shape in shapes_of(kind, 1 / aspect, rng)]
    ends = np.array([(-0.5, 0.0), (0.5, 0.0)]) @ frame + middle
    return World(kind, aspect, ends, image_of(shapes, inside, rng))


def shapes_of(kind: str, width: float, rng: Rng) -> list[Array]:
    """What is seen of a bar of length one along x, and what lies at its end."""
    reach = float(np.exp(rng.uniform(*np.log([1 / 16, 1 / 3]))))
    end = 0.5 + {"end off": rng.uniform(-1 / 12, 1 / 12), "covered": -reach}.get(kind, 0.0)
    bar = bar_from(-0.5, end, width)
    if kind == "straight":
        return [bar, bar_from(0.49, 0.5 + reach, width)]
    if kind == "wider":
        return [bar, bar_from(0.5, 0.5 + reach, width * rng.uniform(1.2, 2.5))]
    if kind == "slanted":
        slant = rng.choice([-1, 1]) * rng.uniform(0.26, 1.0)
        c, s = np.cos(slant), np.sin(slant)
        return [bar, bar_from(0.0, reach, width) @ np.array([[c, s], [-s, c]]) + (0.5 - width / 4, 0.0)]
    return [bar]


def bar_from(low: float, high: float, width: float) -> Array:
    return np.array([(low, -width / 2), (high, -width / 2), (high, width / 2), (low, width / 2)])


def image_of(shapes: list[Array], inside: float, rng: Rng) -> NDArray[np.uint8]:
    """:param inside: how far labels end inside of shapes, pixels."""
    cover = np.zeros((FINE * SIZE[1], FINE * SIZE[0]), np.uint8)
    for shape in shapes:
        at = ((shape + 0.5) * FINE - 0.5) * (1 << BITS)
        cv2.fillPoly(cover, [at.round().astype(np.int32)], 255, shift=BITS)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (round(2 * FINE * abs(inside)) + 1,) * 2)
    cover = cv2.erode(cover, disc) if inside > 0 else cv2.dilate(cover, disc)
    share = cv2.resize(cover, SIZE, interpolation=cv2.INTER_AREA) / np.float32(255)
    blur, ragged = rng.choice([0.0, 0.7, 1.5]), rng.choice([0.0, 0.1, 0.25])
    share = cv2.GaussianBlur(share, (0, 0), blur) if blur else share
    edge = (share > 0.02) & (share < 0.98)
    return np.where(share + edge * rng.normal(0, ragged, share.shape) > 0.5, LABEL, 0).astype(np.uint8)


class Row(NamedTuple):
    """Readings of a picture: the one that is told first. :ivar evidence: (H, 4). :ivar right: (H,)"""

    kind: str
    evidence: Array
    right: NDArray[np.bool_]


class Watched(OtherEnds):
    """What the recogniser finds to speak for readings."""

    last: tuple[Poses, Array] | None = None
    told: ClassVar[list[tuple[Array, Array]]] = []  # ends and evidence of what is told, and of what else may be

    def seen(self, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_], ends: NDArray[np.int64]) -> Seen:
        out = super().seen(frame, poses, used, ends)
        self.last = poses, out.evidence
        return out

    def of(self, frame: ImageFrame, pose: Poses, used: NDArray[np.bool_]) -> tuple[Poses, Array]:
        self.last = None
        others, odds = super().of(frame, pose, used)
        if self.last is not None:
            at = Poses.concatenate([pose, others])
            rows = [int(np.flatnonzero((self.last[0].t == t).all(axis=1))[0]) for t in at.t]
            points = np.array([(-0.5, 0.0, 0.0), (0.5, 0.0, 0.0)])
            X = points @ at.R.swapaxes(1, 2) + at.t[:, None]
            self.told.append((project(frame.camera, X.reshape(-1, 3)).reshape(-1, 2, 2), self.last[1][rows]))
        return others, odds


def row_of(world: World) -> Row | None:
    outline = bar_from(-0.5, 0.5, 1 / world.aspect)
    marker = Marker("m", outline, np.array([-0.5, 0.0]), np.array([0.5, 0.0]), None, Pose.identity())
    model = ObjectModel("bar", (Component("c", (marker,), required=True),))
    config = RecognizerConfig(min_scale=40.0, max_scale=450.0, memory=False)
    recognizer = Recognizer([Target("bar", model, LABEL)], config, Segmenter(ImageConfig()), calibrated=False)
    Watched.told.clear()
    if not recognizer.recognize(world.image).detections or not Watched.told:
        return None
    ends, evidence = Watched.told[0]
    return Row(world.kind, evidence, np.array([world.off(e) < OFF for e in ends]))


def log_shares(weights: Array, evidence: Array) -> Array:
    worth = evidence @ weights
    return np.asarray(worth - np.logaddexp.reduce(worth))


def log_loss(weights: Array, rows: list[Row]) -> float:
    told = [np.logaddexp.reduce(log_shares(weights, row.evidence)[row.right]) for row in rows if row.right.any()]
    return -float(np.mean(told))


def report(name: str, weights: Array, rows: list[Row]) -> None:
    if not rows:
        return
    shares = [np.exp(log_shares(weights, row.evidence)) for row in rows]
    p = np.array([s.max() for s in shares])
    right = np.array([row.right[s.argmax()] for s, row in zip(shares, rows, strict=True)])
    sure, first = p > 0.9, np.mean([row.right[0] for row in rows])
    possible = np.mean([row.right.any() for row in rows])
    print(f"{name}: {len(rows)}; right first {first:.3f}, likeliest {right.mean():.3f}, any {possible:.3f};", end=" ")
    print(f"{p.mean():.3f} said; {sure.sum()} said above 0.9, of which {(sure & ~right).sum()} are wrong")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--worlds", type=int, default=800)
    parser.add_argument("--seed", type=int, default=11)
    args = parser.parse_args()
    vars(finder)["OtherEnds"] = Watched
    found = [row_of(world_of(np.random.default_rng([args.seed, n]))) for n in tqdm(range(args.worlds))]
    fit, held_out = ([row for row in found[k::2] if row is not None] for k in (0, 1))
    weights = minimize(log_loss, np.array([0.6, 2.4, 18.0, 5.0]), (fit,), method="Nelder-Mead").x
    print(f"far_end_odds: {weights.round(2).tolist()}, of {len(fit)} pictures; log loss {log_loss(weights, fit):.3f}")
    for kind in (*KINDS, None):
        report(f"held out, {kind or 'all'}", weights, [row for row in held_out if kind in (None, row.kind)])


if __name__ == "__main__":
    main()
