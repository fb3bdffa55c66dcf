"""Objects whose required component hangs on a joint: the object's frame is another component's."""

from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, camera_of, pose, render, truck, turn_between

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.recognizer import Recognizer

CAMERA = camera_of()


def towed() -> ObjectModel:
    """A truck that a bar carries, as a tower does a crane; the truck's torso is what must be seen."""
    torso, *legs = truck().components
    fore = replace(legs[0], name="bar", joint=None, required=False)
    swing = Joint("bar", Pose.from_xyz_rpy((-0.075, 0, 0.04)), np.array([0.0, 1.0, 0.0]), -0.8, 0.8)
    return ObjectModel("towed", (fore, replace(torso, joint=swing)))


MODEL = towed()


def at(x, swing):
    return pose(x, 0.0, 0.6, 0.4, 0.1, MODEL, {"torso": swing})


def test_a_mirrored_sibling_leaves_the_seen_markers_centre_where_it_is():
    finder, seen = WholeObjectFinder(Target("towed", MODEL, RED), DEFAULTS), at(0.0, 0.5)
    flips = finder.required.flips(seen)
    kin, T = finder.surface.kinematics, MODEL.required.marker("right").T_component_marker
    was, now = (kin.forward(p.R, p.t, p.q) for p in (seen, flips))
    centroid = T.apply(np.append(MODEL.required.marker("right").centroid, 0.0))
    places = [f.R[:, finder.root] @ centroid + f.t[:, finder.root] for f in (was, now)]
    assert np.linalg.norm(places[1] - places[0], axis=1).min() < 1e-9
    turned = [turn_between(R, was.R[0, finder.root]) for R in now.R[:, finder.root]]
    assert min(turned) > 0.3


def test_places_are_those_of_the_required_component():
    finder = WholeObjectFinder(Target("towed", MODEL, RED), DEFAULTS)
    assert finder.required.is_over(CAMERA, at(0.0, 0.5), at(0.0, 0.5)).tolist() == [True]
    assert finder.required.is_over(CAMERA, at(0.3, 0.5), at(0.0, 0.5)).tolist() == [False]


@pytest.mark.parametrize("swing", [-0.5, 0.4])
def test_it_is_recognised(swing):
    truth = at(0.02, swing)
    labels = render(CAMERA, [(MODEL, truth, RED)])
    config = RecognizerConfig(time_budget_ms=60000.0)
    recognizer = Recognizer((Target("towed", MODEL, RED),), config, Segmenter(ImageConfig()))
    (found,) = recognizer.recognize(labels, CAMERA).detections
    assert np.linalg.norm(found.pose.position - truth.t[0]) < 0.05
    assert turn_between(found.pose.rotation, truth.R[0]) < 0.2
    assert found.joints["torso"] == pytest.approx(swing, abs=0.15)
    assert {c.component for c in found.components} == {"bar", "torso"}
