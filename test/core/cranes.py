"""A small image of a crane and what is found in it, stage by stage: the fixtures are in `conftest.py`."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from scene import Placed, crane, crane_placed, disc, draw, flag, rectangle, render
from settings import settings

from artrec_ros.core.alignment.contour_map import ContourMap
from artrec_ros.core.alignment.placements import Placements
from artrec_ros.core.alignment.shapes import Shape
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.learning.pair_learning import learn

RED, BLUE = 3, 2
CONFIG = settings(max_slant_deg=30.0, coarse_step=8, refine_steps=6)
SIZE = (150, 110)
BLANK = (0, 0, 40, 20)
MARKERS = (flag(), flag(mirrored=True), rectangle("bar", 0.8, 0.16), disc("d", 0.3))
SHAPE_OF = {("base", "flag"): 0, ("base", "flag_mirrored"): 1, ("fore", "bar"): 2, ("aft", "bar"): 2}
CRANES = {(0, RED), (1, RED), (2, RED)}
TRUTH = crane_placed(60.3, 44.6, 0.4, 34, (0.2, -0.3))


def crane_examples(count=60):
    rng = np.random.default_rng(7)
    return [
        crane_placed(0, 0, rng.uniform(-3, 3), rng.uniform(30, 80), tuple(rng.uniform(-0.5, 0.5, 2)), bool(n % 2))
        for n in range(count)
    ]


CRANE = learn(crane(), crane_examples())


def crane_scene() -> SimpleNamespace:
    """Labels, blobs, their contour map, shapes: a crane, a disc, one that the border cuts off."""
    labels = render(SIZE, crane(), [TRUTH], RED)
    draw(labels, disc("disc", 0.3), Placed(120, 30, 0.0, 40), BLUE)
    draw(labels, flag(), Placed(140, 90, 2.0, 30), RED)
    blobs = find_blobs(labels, {RED, BLUE}, CONFIG, BLANK)
    return SimpleNamespace(
        labels=labels, blobs=blobs, cmap=ContourMap.build(blobs, SIZE), shapes=[Shape.from_marker(m) for m in MARKERS]
    )


def placed_points(p: Placements, n: int, points: np.ndarray) -> np.ndarray:
    """Points of an outline where the nth placement puts them, as complex pixels."""
    return np.asarray(p.t[n] + p.z[n] * points + p.w[n] * np.conj(points))
