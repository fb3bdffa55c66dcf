"""Discs like a hand's own that belong to nothing: two of them are no hand of which all else is not seen."""

from __future__ import annotations

import numpy as np
import pytest
from hands import hand, picture, places
from legs import PX_PER_M
from settings import settings

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.recognizer import Recognizer


@pytest.fixture(scope="module")
def engine():
    config = settings(time_budget_ms=60000.0, min_scale=80.0, max_scale=125.0)
    return Recognizer((hand(),), config, Segmenter(ImageConfig()), calibrated=False)


@pytest.mark.parametrize("seed", range(4))
def test_two_strays_are_hardly_a_hand_and_the_hand_beside_them_is_one_for_sure(engine, seed):
    rng = np.random.default_rng(seed)
    own = places((300, 300), rng.uniform(0, 1, 3))
    first = np.array([90.0, 90.0]) + rng.uniform(-30, 30, 2)
    turn = rng.uniform(-np.pi, np.pi)
    strays = [first, first + PX_PER_M * np.hypot(0.5, 0.15) * np.array([np.cos(turn), np.sin(turn)])]
    told, *others = engine.recognize(picture([*own, *strays])).detections
    assert np.hypot(*(np.array([told.image.x, told.image.y]) - own[0])) < 3
    assert told.score > 0.95 and len(told.components) == 9
    assert all(d.score < 0.5 for d in others)


def test_a_hand_of_which_two_thirds_are_seen_is_told(engine):
    own = places((250, 300), (0.2, 0.6, 0.9))
    (told,) = engine.recognize(picture(own[:6])).detections
    assert told.score > 0.9 and {c.component for c in told.components} >= {"p0", "p1", "p2"}
