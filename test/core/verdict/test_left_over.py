"""How sure a pose is that leaves blobs unexplained which may be the object's own."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from legs import ANKLE, KNEE, PX_PER_M, SHANK, SIZE, THIGH, TOE, leg, picture, places
from settings import settings

from artrec_ros.core.base.config import ImageConfig, TrackingConfig
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.found import Detection, ImagePose
from artrec_ros.core.model.frame_result import FrameResult
from artrec_ros.core.model.objects import ObjectModel
from artrec_ros.core.pose.apart import Apart
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.tracking.tracker import Tracker
from artrec_ros.core.verdict.left_over import LeftOver, LeftOvers

LIMITS = {"time_budget_ms": 60000.0, "min_scale": 85.0, "max_scale": 118.0}
CAMERA = Camera.pinhole(SIZE, 600.0)
ANGLES = [(0.9, -0.3, 1.2), (1.3, -1.0, 1.5), (1.6, -0.6, 1.0), (2.0, -1.2, 1.7)]


def found_in(labels, camera=None):
    engine = Recognizer((leg(),), settings(**LIMITS), Segmenter(ImageConfig()), calibrated=camera is not None)
    (detection,) = engine.recognize(labels, camera).detections
    return detection


def true_joints(angles):
    return {"knee_angle": angles[1], "ankle_angle": angles[2]}


@pytest.mark.parametrize("camera", [None, CAMERA], ids=["flat", "space"])
@pytest.mark.parametrize("angles", ANGLES)
def test_of_a_shank_that_swings_out_of_the_plane_nothing_wrong_is_told_for_sure(angles, camera):
    """No pose explains all four discs: one that lies on three says of the fourth that it is not to be seen."""
    found = found_in(picture(places(0.5, *angles)), camera)
    joints = true_joints(angles)
    off = {name: abs(q - joints[name]) for name, q in found.joints.items()}
    turned = abs(np.angle(np.exp(1j * (found.image.theta - angles[0]))))
    assert max([turned, *off.values()]) > 0.2 or found.missing
    assert found.score < 0.8 and found.as_told < 0.85 and found.there > 0.6
    for name, deviation in found.joint_deviations.items():
        assert off[name] < 4 * deviation


@pytest.mark.parametrize("camera", [None, CAMERA], ids=["flat", "space"])
@pytest.mark.parametrize("angles", ANGLES)
def test_what_lies_unexplained_is_told(angles, camera):
    at = places(0.5, *angles)
    found = found_in(picture(at), camera)
    names = [c.name for c in leg().model.components]
    assert any(m.state == "elsewhere" for m in found.missing)
    for m in found.missing:
        if m.state == "elsewhere":
            assert np.hypot(*(at[names.index(m.component)] - (m.x, m.y))) < 1.5


@pytest.mark.parametrize("hidden", [(), (KNEE,), (ANKLE,), (TOE,)])
def test_one_that_leaves_nothing_is_as_sure_as_before(hidden):
    found = found_in(picture(places(), hidden))
    assert found.as_told == 1 and found.score == found.there > 0.8
    assert all(m.state != "elsewhere" for m in found.missing)


@pytest.mark.parametrize("stray", [(KNEE, (40, 290)), (TOE, (450, 290)), (ANKLE, (30, 30))])
def test_what_lies_beyond_reach_is_none_of_its_own(stray):
    hidden = (stray[0],)
    found = found_in(picture(places(), hidden, [stray]))
    assert found.there > 0.8 and all(m.state != "elsewhere" for m in found.missing)


def test_what_is_much_larger_or_smaller_than_its_marker_is_not_its_own():
    labels = picture(places(0.5, *ANGLES[0]))
    doubted = found_in(labels)
    (lost,) = [m for m in doubted.missing if m.state == "elsewhere"][:1]
    label = 1 + [c.name for c in leg().model.components].index(lost.component)
    small, (y, x) = labels.copy(), np.mgrid[: SIZE[1], : SIZE[0]]
    small[(labels == label) & (np.hypot(x - lost.x, y - lost.y) > 4)] = 0
    assert all(m.component != lost.component or m.state != "elsewhere" for m in found_in(small).missing)


def test_what_is_borne_out_more_than_once_stands_but_not_for_sure():
    """Of solids in space a wrong pose may explain many numbers, too."""
    few, many, more = (LeftOver({1: None}, spare).share(settings()) for spare in (0.0, 4.0, 20.0))
    assert few < 0.8 < 0.9 < many == more < 0.95 and LeftOver({}, 0.0).share(settings()) == 1


def test_reach_is_how_far_apart_joints_let_components_be():
    config = settings(**LIMITS)
    reach = Apart(SpatialModel(leg().model, leg().label, config.votes), config)._reach
    assert np.allclose(reach, reach.T) and np.allclose(np.diag(reach), 0)
    assert reach[0, 1] == pytest.approx(THIGH) and reach[1, 2] == pytest.approx(SHANK)
    assert THIGH + SHANK - 0.02 < reach[0, 2] <= THIGH + SHANK + 1e-9


def test_spare_numbers_are_those_that_joints_leave():
    left = LeftOvers(WholeObjectFinder(leg(), settings(**LIMITS), facing=True))
    assert [left._spare(frozenset(seen)) for seen in ((0, 1), (0, 1, 2), (0, 1, 2, 3), (0, 2, 3))] == [0, 1, 2, 0]


def test_over_time_a_pose_is_no_surer_than_each_frame_has_it():
    """That the object is there many frames tell together; how it lies each one tells alike, rightly or wrongly."""
    tracker, leg_at = Tracker(TrackingConfig()), ImagePose(100.0, 80.0, 0.3, PX_PER_M)
    for n in range(20):
        at = replace(leg_at, x=leg_at.x + 6 * n)
        seen = Detection("leg", 0, 0.9 * 0.4, at, (), as_told=0.4)
        (told,) = tracker.update(n * 33_000_000, FrameResult(SIZE, (seen,))).detections
    assert told.there > 0.97 and told.score == pytest.approx(0.4 * told.there) and told.as_told == 0.4


def test_the_only_blob_of_a_class_that_one_component_has_is_that_component():
    left_overs = LeftOvers(WholeObjectFinder(leg(), settings(**LIMITS), facing=True))
    assert left_overs.may_be_sure({3}) and not left_overs.may_be_sure(())
    at = places()
    alone, two = (find_blobs(picture(at, (), strays), [TOE], settings()) for strays in ((), [(TOE, (40, 290))]))
    assert left_overs.is_sure(LeftOver({3: alone[0]}, 5.0), alone)
    assert not left_overs.is_sure(LeftOver({3: alone[0]}, 5.0), two)


def test_of_several_components_of_one_class_none_is_sure():
    target = leg()
    knee, toe = (replace(c, label=KNEE) for c in (target.model.components[1], target.model.components[3]))
    parts = target.model.components[0], knee, target.model.components[2], toe
    alike = replace(target, model=ObjectModel("leg", parts))
    left_overs = LeftOvers(WholeObjectFinder(alike, settings(**LIMITS), facing=True))
    assert not left_overs.may_be_sure({1, 3}) and left_overs.may_be_sure({2})
