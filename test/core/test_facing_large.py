"""Flat objects whose markers are hundreds of pixels large: what first guesses are off by grows with them."""

import numpy as np
import pytest
from settings import settings
from squares import COLOURS, LEFT, RIGHT, TEAM, Placing, patch, rendered, robot

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer

WEDGE = np.array([(-0.04, -0.01), (0.04, -0.01), (0.04, 0.004), (-0.04, 0.01)])


class Wedge(Placing):
    def patches(self):
        return [(self.at(WEDGE), TEAM)]


class Robot(Placing):
    def patches(self):
        (back, label), *_ = super().patches()
        return [(back, label), (self.at(LEFT), COLOURS["g"]), (self.at(RIGHT), COLOURS["r"])]


MODELS = {
    Wedge: ObjectModel("wedge", (Component("wedge", (patch("wedge", WEDGE),), required=True),)),
    Robot: robot(alternatives=False),
}


@pytest.mark.parametrize(("kind", "scale"), [(Wedge, 8000.0), (Robot, 4000.0)])
def test_large_markers_are_found_at_their_scale(kind, scale):
    """640 and 300 px long."""
    rng, model = np.random.default_rng(int(scale)), MODELS[kind]
    engine = Recognizer((Target(model.name, model, TEAM),), settings(time_budget_ms=60000), Segmenter(ImageConfig()))
    for turn in rng.uniform(-np.pi, np.pi, 8):
        one = kind(*rng.uniform(380, 420, 2), turn, scale)
        (found,) = engine.recognize(rendered(one, size=(800, 800), fine=1)).detections
        assert len(found.components) == len(model.components), one
        assert abs(found.image.scale / scale - 1) < 0.02, one
        assert abs(np.angle(np.exp(1j * (found.image.theta + turn)))) < 0.02, one
