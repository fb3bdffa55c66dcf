"""Is a score of 0.9 right nine times in ten? Objects made up at random, in the image plane, among what looks like them.

    python benchmarks/calibration.py [--objects 24] [--scenes 20] [--fit]

Each object has one to five parts of random outlines that swing on the first; its constraints are learned from 40
examples. Scenes hold up to three of it, some half hidden or cut, lone parts of it, other random objects of the same
class, ragged edges and speckle. A detection is right when each of its components lies on that component of one
object. `--fit` fits the weights of `core/verdict/trust.py` on even-numbered objects; the table is always of odd ones.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import dataclass

import cv2
import numpy as np

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.geometry.transforms import Array
from artrec_ros.core.grouping.group_search import Group
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.learning.pair_learning import learn
from artrec_ros.core.model.found import Detection, Instance
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict import report as reporting
from artrec_ros.core.verdict.trust import WEIGHTS, features, probability

SIZE, LABEL, FINE = (640, 480), 2, 3
EXAMPLES = 40
BINS = (0.0, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95, 1.0)
Key = tuple[str, str]


@dataclass(frozen=True)
class RandomObject:
    """:param pivots: (N, 2) where each part swings on the first, metres; rest, swing: (N,) its angles, radians."""

    model: ObjectModel
    pivots: Array
    rest: Array
    swing: Array

    def placed(self, x: float, y: float, theta: float, scale: float, rng: np.random.Generator) -> dict[Key, Instance]:
        parts = {}
        for n, component in enumerate(self.model.components):
            (marker,) = component.markers
            turn = theta + (self.rest[n] + rng.uniform(-1, 1) * self.swing[n] if n else 0.0)
            at = complex(x, y) + scale * complex(*self.pivots[n]) * np.exp(1j * theta)
            at += scale * complex(*(marker.centroid * (1, -1))) * np.exp(1j * turn) if n else 0
            parts[component.name, marker.name] = Instance(
                component.name, marker.name, 1.0, at.real, at.imag, turn + marker.axis_angle, scale
            )
        return parts


def random_outline(rng: np.random.Generator, width: float) -> Array:
    angles = np.sort(rng.uniform(0, 2 * np.pi, 30))[:: int(rng.integers(4, 7))] + rng.uniform(0, 1)
    reach = width / 2 * rng.uniform(0.55, 1.0, len(angles))
    return np.column_stack([reach * np.cos(angles), reach * np.sin(angles)])


def random_object(seed: int) -> RandomObject:
    rng = np.random.default_rng([7, seed])
    count = int(rng.integers(1, 6))
    components = []
    for n in range(count):
        if n == 0 or rng.random() < 0.3:
            outline = random_outline(rng, 0.24 if n == 0 else 0.15)
        else:
            length, width = rng.uniform(0.12, 0.25), rng.uniform(0.045, 0.08)
            taper = rng.uniform(0.5, 1.0)
            outline = np.array([[0, -width], [length, -taper * width], [length, taper * width], [0, width]]) / (1, 2)
        marker = Marker("m", outline, np.zeros(2), np.array([0.1, 0.0]))
        components.append(Component(f"c{n}", (marker,), required=n == 0))
    around = rng.uniform(0, 2 * np.pi) + 2 * np.pi * np.arange(count) / max(count - 1, 1)
    pivots = 0.17 * np.column_stack([np.cos(around), np.sin(around)])
    pivots[0] = 0.0
    return RandomObject(ObjectModel(f"o{seed}", tuple(components)), pivots, around, rng.uniform(0.1, 0.7, count))


def draw(fine: np.ndarray, model: ObjectModel, i: Instance, value: int) -> None:
    marker = model.component(i.component).marker(i.marker)
    c, s = i.scale * np.array([np.cos(i.theta - marker.axis_angle), np.sin(i.theta - marker.axis_angle)])
    outline = (marker.image_outline @ np.array([[c, s], [-s, c]]) + (i.x, i.y) + 0.5) * FINE - 0.5
    cv2.fillPoly(fine, [np.round(outline * 16).astype(np.int32)], value, shift=4)


def spot(rng: np.random.Generator) -> tuple[float, float, float, float]:
    scale = np.exp(rng.uniform(np.log(70), np.log(400)))
    return rng.uniform(20, 620), rng.uniform(20, 460), rng.uniform(-np.pi, np.pi), scale


def scene(
    made: RandomObject, other: RandomObject, rng: np.random.Generator
) -> tuple[np.ndarray, list[dict[Key, Instance]]]:
    """(H, W) labels, and where the objects' parts are that were drawn."""
    fine = np.zeros((SIZE[1] * FINE, SIZE[0] * FINE), np.uint8)
    for _ in range(int(rng.integers(0, 6))):  # what looks like it: lone parts, other objects
        # a lone part of an object of one part would be the object
        source = made if rng.random() < 0.5 and len(made.model.components) > 1 else other
        shown = list(source.placed(*spot(rng), rng).values())
        for i in [shown[int(rng.integers(len(shown)))]] if source is made else shown:
            draw(fine, source.model, i, LABEL)
    truths = list[dict[Key, Instance]]()
    for _ in range(int(rng.integers(0, 4))):
        parts = made.placed(*spot(rng), rng)
        truths.append(parts)
        for i in parts.values():
            if i.component == "c0" or rng.random() < 0.85:
                draw(fine, made.model, i, LABEL)
    for _ in range(int(rng.integers(0, 4))):  # things in front
        x, y = rng.uniform(0, SIZE[0]), rng.uniform(0, SIZE[1])
        w, h = rng.uniform(10, 70, 2)
        corners = np.array([[x, y], [x + w, y + h]]) * FINE
        cv2.rectangle(fine, corners[0].astype(int).tolist(), corners[1].astype(int).tolist(), 0, -1)
    smooth = cv2.resize((fine > 0).astype(np.float32), SIZE, interpolation=cv2.INTER_AREA)
    ragged = smooth + rng.normal(0, 0.15, smooth.shape) > rng.uniform(0.35, 0.65)
    labels = np.where(ragged, LABEL, 0).astype(np.uint8)
    labels[rng.random(labels.shape) < 0.001] = LABEL
    return labels, truths


def is_right(d: Detection, made: RandomObject, truths: list[dict[Key, Instance]]) -> bool:
    def near(i: Instance, parts: dict[Key, Instance]) -> bool:
        true = parts[i.component, i.marker]
        size = np.sqrt(made.model.component(i.component).marker(i.marker).area) * true.scale
        return bool(np.hypot(i.x - true.x, i.y - true.y) < 0.35 * size + 1)

    return any(all(near(i, parts) for i in d.components) for parts in truths)


def outcomes(seed: int, scenes: int) -> Iterator[tuple[Detection, bool]]:
    """Detections in the scenes of one object, and whether they are right."""
    made, other = random_object(seed), random_object(seed + 1000)
    rng = np.random.default_rng([8, seed])
    examples = [made.placed(*spot(rng), rng) for _ in range(EXAMPLES)]
    target = Target("it", made.model, LABEL, learn(made.model, examples))
    recognizer = Recognizer([target], RecognizerConfig(), Segmenter(ImageConfig()))
    for _ in range(scenes):
        labels, truths = scene(made, other, rng)
        for d in recognizer.recognize(labels).detections:
            yield d, is_right(d, made, truths)


def reliability(scores: Array, right: Array) -> list[tuple[float, float, int, float, float]]:
    """Per bin of scores: its ends, how many, the mean score, the share that is right."""
    rows = []
    for low, high in zip(BINS, BINS[1:], strict=False):
        inside = (scores >= low) & ((scores < high) | (high == 1.0))
        if inside.any():
            rows.append((low, high, int(inside.sum()), float(scores[inside].mean()), float(right[inside].mean())))
    return rows


def report(scores: Array, right: Array) -> None:
    print("score        detections  mean score  right")
    rows = reliability(scores, right)
    for low, high, count, mean, share in rows:
        print(f"{low:.2f} to {high:.2f}  {count:10d}  {mean:10.3f}  {share:5.3f}")
    error = sum(count * abs(mean - share) for _, _, count, mean, share in rows) / len(scores)
    sure = scores >= 0.9
    print(
        f"{len(scores)} detections, {right.mean():.3f} right; expected calibration error {error:.3f}; of the", end=" "
    )
    print(f"{sure.sum()} at 0.9 and above {right[sure].mean() if sure.any() else float('nan'):.3f} are right")


class FeatureRecorder:
    """Keeps what each score was computed from."""

    def __init__(self) -> None:
        self.by_score: dict[float, tuple[float, ...]] = {}
        reporting.probability = self

    def __call__(self, group: Group) -> float:
        score = probability(group)
        self.by_score[score] = features(group)
        return score


def fit(rows: Array, right: Array) -> Array:
    """Logistic regression with a slight pull to zero, by Newton's method."""
    weights = np.zeros(rows.shape[1])
    for _ in range(50):
        p = 1 / (1 + np.exp(-rows @ weights))
        gradient = rows.T @ (right - p) - weights
        hessian = (rows * (p * (1 - p))[:, None]).T @ rows + np.eye(len(weights))
        weights = weights + np.linalg.solve(hessian, gradient)
    return weights


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--objects", type=int, default=24)
    parser.add_argument("--scenes", type=int, default=20)
    parser.add_argument("--fit", action="store_true")
    args = parser.parse_args()
    recorder = FeatureRecorder()
    rows = [(n, *o) for n in range(args.objects) if n % 2 or args.fit for o in outcomes(n, args.scenes)]
    odd = np.array([n % 2 == 1 for n, _, _ in rows])
    right = np.array([float(ok) for _, _, ok in rows])
    scores = np.array([d.score for _, d, _ in rows])
    report(scores[odd], right[odd])
    if args.fit:
        table = np.array([recorder.by_score[float(s)] for s in scores])
        weights = fit(table[~odd], right[~odd])
        print("weights now", np.round(WEIGHTS, 2).tolist(), "fitted", np.round(weights, 2).tolist())
        report(1 / (1 + np.exp(-table[odd] @ weights)), right[odd])


if __name__ == "__main__":
    main()
