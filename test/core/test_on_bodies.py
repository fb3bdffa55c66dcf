"""Objects whose bodies have no class, and show between their markers and a floor that has one."""

from dataclasses import replace

import numpy as np
import pytest
from settings import settings
from solids import BODY, RED, camera_of, pose, render, truck

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.image.codes import UNKNOWN
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer

CAMERA = camera_of((640, 480), 500.0)


def without_class(model):
    return replace(model, components=tuple(replace(c, body_label=None) for c in model.components))


def test_whose_markers_stand_on_what_is_unknown():
    bare, labelled = without_class(truck()), truck()
    assert Target("truck", bare, RED).on_bodies == {RED}
    assert not Target("truck", labelled, RED).on_bodies and not Target("truck", truck(bodies=False), RED).on_bodies
    torso, *legs = labelled.components
    mixed = replace(labelled, components=(replace(torso, body_label=None), *(replace(c, label=7) for c in legs)))
    assert Target("truck", mixed, RED).on_bodies == {RED, 7}  # the torso's body may show behind a leg


@pytest.mark.parametrize("heading", [0.0, 0.5])
def test_what_shows_of_such_a_body_does_not_bring_it_nearer(heading):
    """Two millimetres of it to three centimetres: it was told a tenth too near."""
    truth = pose(0.05, 0.02, 2.2, heading, 0.1, truck())
    labels = render(CAMERA, [(truck(), truth, RED)])
    labels[labels == BODY] = UNKNOWN
    target = Target("truck", without_class(truck()), RED)
    engine = Recognizer((target,), settings(), Segmenter(ImageConfig()))
    (found,) = engine.recognize(labels, CAMERA).detections
    assert np.linalg.norm(found.pose.position - truth.t[0]) < 0.03 * 2.2
