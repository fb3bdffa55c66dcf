"""Poses that are found by what others leave unexplained."""

from __future__ import annotations

import numpy as np
import pytest
from legs import ANKLE, KNEE, SIZE, leg, picture, places
from settings import settings

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.through_middles import Middles, ThroughMiddles
from artrec_ros.core.recognizer import Recognizer

LIMITS = {"time_budget_ms": 60000.0, "min_scale": 85.0, "max_scale": 118.0}
CAMERA = Camera.pinhole(SIZE, 600.0)


def angles_of(n):
    rng = np.random.default_rng(n)
    return rng.uniform(0.8, 2.2), rng.uniform(-1.6, 0.2), rng.uniform(0, 2)


@pytest.mark.parametrize("looks", [4, 0], ids=["looked for again", "as first found"])
@pytest.mark.parametrize(
    ("camera", "hidden", "seeds"),
    [(None, (ANKLE,), (4, 5, 7, 11)), (CAMERA, (), (15, 47, 52, 59, 82))],
    ids=["flat", "space"],
)
def test_an_exact_leg_is_bent_as_it_is(camera, hidden, seeds, looks):
    """Each of these is first found on some of its discs, with another one left."""
    config = settings(**LIMITS, looks=looks)
    engine = Recognizer((leg(),), config, Segmenter(ImageConfig()), calibrated=camera is not None)
    for n in seeds:
        thigh, knee, ankle = angles_of(n)
        (found,) = engine.recognize(picture(places(1.0, thigh, knee, ankle), hidden), camera).detections
        true = {"knee_angle": knee, "ankle_angle": ankle}
        off = [abs(found.image.theta - thigh), *(abs(q - true[name]) for name, q in found.joints.items())]
        if looks:
            assert max(off) < 0.15 and found.as_told == 1 and len(found.components) == 4 - len(hidden), n
        else:
            assert found.as_told < 0.9, n


@pytest.mark.parametrize("n", [5, 7, 8, 12, 13])
def test_a_leg_whose_knee_is_hidden_may_be_bent_to_either_side(n):
    engine = Recognizer((leg(),), settings(**LIMITS), Segmenter(ImageConfig()))
    thigh, knee, ankle = angles_of(n)
    (found,) = engine.recognize(picture(places(1.0, thigh, knee, ankle), (KNEE,)), CAMERA).detections
    true = {"knee_angle": knee, "ankle_angle": ankle}
    assert found.other_turn is not None and 0.1 < found.other_turn.probability <= 0.5
    for name, deviation in found.joint_deviations.items():
        assert abs(found.joints[name] - true[name]) < 3 * deviation


def test_one_with_its_knee_in_view_is_bent_one_way():
    engine = Recognizer((leg(),), settings(**LIMITS), Segmenter(ImageConfig()))
    (found,) = engine.recognize(picture(places(1.0, *angles_of(5))), CAMERA).detections
    assert max(found.joint_deviations.values()) < 0.1


@pytest.mark.parametrize(
    ("camera", "facing"),
    [(Camera.facing(SIZE), True), (CAMERA, False), (Camera(CAMERA.matrix, [-0.3, 0.1, 0.01, 0.01], SIZE), False)],
    ids=["flat", "space", "a lens that bends"],
)
@pytest.mark.parametrize("n", range(6))
def test_a_pose_goes_through_middles_whatever_it_was(n, camera, facing):
    config, rng = settings(**LIMITS), np.random.default_rng(n)
    finder = WholeObjectFinder(leg(), config, facing=facing)
    kin = finder.surface.kinematics
    through = ThroughMiddles(finder.surface, config, facing=facing)
    q = rng.uniform(kin.lower, kin.upper)[None]
    true = Poses(np.diag([1.0, -1.0, -1.0])[None], np.array([[0.0, 0.0, camera.focal_px / 100]]), q)
    patches = finder.surface.markers
    at = through.places(true, patches)[0]
    middles = Middles(patches, project(camera, at), camera.focal_px / at[:, 2])
    found = through.of(camera, Poses(true.R, true.t, kin.middle[None]), middles)
    assert len(found) and np.abs(found.q - q).max(axis=1).min() < 0.1
    assert np.all((found.q >= kin.lower) & (found.q <= kin.upper))


def test_no_pose_goes_through_what_is_too_far_apart():
    config = settings(**LIMITS)
    finder = WholeObjectFinder(leg(), config, facing=True)
    through, camera = ThroughMiddles(finder.surface, config, facing=True), Camera.facing(SIZE)
    start = Poses(np.diag([1.0, -1.0, -1.0])[None], np.array([[0.0, 0.0, camera.focal_px / 100]]), np.zeros((1, 2)))
    at = np.array([[60.0, 60.0], [155.0, 60.0], [400.0, 250.0], [420.0, 250.0]])
    assert not len(through.of(camera, start, Middles(finder.surface.markers, at, np.full(4, 100.0))))
