"""Searching an image blob by blob: short looks before long ones, pixels taken at once, time kept."""

import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, StubJudge, camera_of, pose, render, truck

from artrec_ros.core.base.config import RecognizerConfig
from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.spatial_search import SpatialSearch
from artrec_ros.core.verdict.acceptance_curves import LIKELY, SURE

CAMERA = camera_of()
TRUCK = truck()
LEFT = pose(-0.25, 0, 1.0, 0.3, model=TRUCK)
RIGHT = pose(0.25, 0.02, 1.1, -0.4, model=TRUCK, joints={"hind": 0.3})


@pytest.fixture(scope="module")
def finder():
    return WholeObjectFinder(Target("truck", TRUCK, RED), DEFAULTS)


@pytest.fixture
def looks(monkeypatch):
    """Areas of the blobs that a long look is taken at."""
    areas, guesses = [], WholeObjectFinder.guesses

    def counted(self, frame, blob):
        areas.append(blob.area_px)
        return guesses(self, frame, blob)

    monkeypatch.setattr(WholeObjectFinder, "guesses", counted)
    return areas


def search(finder, trust, budget_s=float("inf")):
    """Candidates for two trucks side by side, and the number of blobs they make."""
    labels = render(CAMERA, [(TRUCK, LEFT, RED), (TRUCK, RIGHT, RED)])
    blobs = find_blobs(labels, {RED}, RecognizerConfig())
    frame = ImageFrame(LabelField(labels), CAMERA, Deadline(budget_s))
    return SpatialSearch(frame, StubJudge(given=lambda verdict: trust), DEFAULTS.search).run([finder], blobs), blobs


def nearest(poses, truth):
    return np.linalg.norm(poses.t - truth.t, axis=1).min()


def test_blobs_that_sure_objects_explain_get_no_long_look(finder, looks):
    ((_, poses),), blobs = search(finder, trust=1.0)
    assert len(blobs) > 2
    assert not looks
    assert len(poses) < 10 and nearest(poses, LEFT) < 0.02 and nearest(poses, RIGHT) < 0.02


def test_where_there_is_doubt_every_blob_gets_a_long_look(finder, looks):
    ((_, poses),), blobs = search(finder, trust=0.5)
    assert sorted(looks) == sorted(b.area_px for b in blobs)
    assert nearest(poses, LEFT) < 0.02 and nearest(poses, RIGHT) < 0.02


def test_other_blobs_of_likely_objects_get_no_long_look_either(finder, looks):
    ((_, poses),), blobs = search(finder, trust=(LIKELY + SURE) / 2)
    assert len(looks) == 2 < len(blobs)
    assert nearest(poses, LEFT) < 0.02 and nearest(poses, RIGHT) < 0.02


def test_without_time_nothing_is_looked_at(finder, looks):
    found, blobs = search(finder, trust=0.5, budget_s=0.0)
    assert blobs and not looks
    assert not found


def test_blobs_of_other_classes_are_not_asked(looks):
    other = WholeObjectFinder(Target("other", TRUCK, RED + 1), DEFAULTS)
    found, _ = search(other, trust=0.5)
    assert not found and not looks
