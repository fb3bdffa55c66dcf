import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.io.learned.annotations import instance_from_axis
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.joint_examples import joint_examples
from artrec_ros.simulation.records import is_annotated
from artrec_ros.simulation.simulator import simulate

from .conftest import square

SCENE = SceneConfig(distractors=0)


def test_examples_are_what_annotated_images_of_the_same_scenes_give(target, camera):
    examples = list(joint_examples(target, camera, SCENE, 5, 12))
    frames = list(simulate([target], camera, SCENE, SensorConfig().scaled(0), 5, 12))
    compared = 0
    for example, frame in zip(examples, frames, strict=True):
        (truth,) = frame.truths
        annotated = {(m.component, m.marker): m for m in truth.markers if is_annotated(m)}
        assert set(annotated) <= set(example)
        for key, m in annotated.items():
            seen = instance_from_axis(key[0], target.model.component(key[0]).marker(key[1]), m.tail, m.head)
            for value in ("x", "y", "theta", "scale"):
                assert getattr(example[key], value) == pytest.approx(getattr(seen, value), abs=1e-9)
            compared += 1
    assert compared > 10


def test_a_view_does_not_depend_on_how_many_follow(target, camera):
    few, many = (list(joint_examples(target, camera, SCENE, 3, n)) for n in (3, 6))
    assert few == many[:3] and few != many[3:]


def test_markers_that_look_away_are_no_examples(target, camera):
    scene = SceneConfig(distractors=0, facing=0.0)
    keys = [set(e) for e in joint_examples(target, camera, scene, 0, 40)]
    fronts = np.mean([("base", "front") in k for k in keys])
    assert 0.15 < fronts < 0.6  # in about four of ten headings


def test_places_must_be_known(camera):
    loose = ObjectModel("loose", (Component("base", (square(0.1),), required=True),))
    with pytest.raises(ConfigError, match="has no pose"):
        next(joint_examples(Target("loose", loose, 2), camera, SCENE, 0, 1))
