"""The facing way's first alignments: which are kept of a direction, and where they lie."""

import numpy as np
import pytest
from settings import DEFAULTS, settings
from squares import BACK, TEAM, Placing, rendered, robot

from artrec_ros.core.geometry.range_limits import scale_limits
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.pose.facing_guesses import FacingGuesser
from artrec_ros.core.pose.grid_kernels import Kept, keep_apart
from artrec_ros.core.pose.surface_model import SpatialModel

pytestmark = pytest.mark.uncompiled


def kept_of(offered, keep, apart_px):
    T, score = np.zeros((3, keep)), np.full(keep, -np.inf)
    for x, y, k, value in offered:
        keep_apart(Kept(*T, score), x, y, k, value, apart_px)
    return T.T[score > -np.inf], score[score > -np.inf]


@pytest.mark.parametrize("seed", range(40))
def test_what_is_kept_is_apart_and_nothing_better_is_lost_for_nothing(seed):
    rng = np.random.default_rng(seed)
    offered = np.column_stack([rng.uniform(0, 30, (60, 2)), rng.uniform(1, 2, 60), rng.permutation(60)])
    T, score = kept_of(offered, 5, 6.0)
    off = np.linalg.norm(T[:, None, :2] - T[:, :2], axis=2)
    assert (off + 99 * np.eye(len(T)) >= 6.0).all()
    assert 59.0 in score  # the best of all is always there
    for row, value in zip(T, score, strict=True):
        assert (row == offered[offered[:, 3] == value, :3]).all()
    worst = score.min() if len(score) == 5 else -np.inf
    for x, y, _, value in offered:  # each that is left out has a better one near it, or is worse than all that are kept
        near = np.hypot(T[:, 0] - x, T[:, 1] - y) < 6.0
        assert value in score or value < worst or (score[near] > value).any() or _had_better_near(offered, x, y, value)


def _had_better_near(offered, x, y, value):
    near = np.hypot(offered[:, 0] - x, offered[:, 1] - y) < 6.0
    return bool((offered[near, 3] > value).any())


def test_one_that_is_not_taken_takes_none_away():
    """Between two worse ones and near a better one."""
    line = [(0.0, 0.0, 1.0, 1.0), (5.0, 5.0, 1.0, 2.0), (10.0, 0.0, 1.0, 9.0)]
    T, score = kept_of([*line, (5.0, 1.0, 1.0, 5.0)], 4, 5.5)
    assert sorted(score) == [1.0, 2.0, 9.0] and len(T) == 3


def test_one_better_than_all_near_it_takes_their_place():
    line = [(0.0, 0.0, 1.0, 1.0), (5.0, 5.0, 1.0, 2.0), (10.0, 0.0, 1.0, 3.0)]
    T, score = kept_of([*line, (5.0, 1.0, 1.0, 5.0)], 4, 5.5)
    assert sorted(score) == [5.0]
    assert (T == [5.0, 1.0, 1.0]).all()


def test_a_full_list_gives_its_worst_away_and_keeps_it_from_a_worse_one():
    far = [(20.0 * i, 0.0, 1.0, float(i + 1)) for i in range(3)]
    assert sorted(kept_of([*far, (90.0, 0.0, 1.0, 2.5)], 3, 5.0)[1]) == [2.0, 2.5, 3.0]
    assert sorted(kept_of([*far, (90.0, 0.0, 1.0, 0.5)], 3, 5.0)[1]) == [1.0, 2.0, 3.0]


def guesses(labels, config=DEFAULTS, most=None):
    surface = SpatialModel(robot(), TEAM, config.votes)
    frame = ImageFrame(LabelField(labels)).faced()
    blobs = [b for b in find_blobs(labels, {TEAM}, config) if b.label == TEAM]
    guesser = FacingGuesser(robot(), surface, config, surface.root)
    return guesser.guess(frame, blobs, scale_limits(config, None)), frame, len(blobs)


@pytest.mark.parametrize("turn", [-2.0, 0.3, 1.4])
def test_a_guess_comes_near_each_of_several(turn):
    placed = [Placing(40.3, 40.2, turn, 330.0), Placing(100.7, 80.4, turn + 1, 260.0)]
    found, frame, count = guesses(rendered(*placed))
    assert count == 2 and (found.votes > 0).all() and set(found.blob.tolist()) == {0, 1}
    np.testing.assert_allclose(
        found.poses.R @ found.poses.R.transpose(0, 2, 1), np.tile(np.eye(3), (len(found.votes), 1, 1)), atol=1e-12
    )
    np.testing.assert_allclose(found.poses.R[:, 2], [[0, 0, -1]] * len(found.votes), atol=1e-12)  # all face it
    middle = np.array([*BACK.mean(axis=0), 0.0])
    at = np.einsum("hij,j->hi", found.poses.R, middle) + found.poses.t
    uv = at[:, :2] / at[:, 2:] * frame.camera.focal_px + frame.camera.matrix[:2, 2]
    for p in placed:
        truth, R = p.at([BACK.mean(axis=0)])[0], p.pose(frame.camera).R[0]
        turned = np.arccos(np.clip((np.einsum("hij,ij->h", found.poses.R, R) - 1) / 2, -1, 1))
        scale = frame.camera.focal_px / at[:, 2]
        near = (np.linalg.norm(uv - truth, axis=1) < 4) & (turned < 0.25) & (np.abs(np.log(scale / p.scale)) < 0.3)
        assert near.any()


def test_scales_stay_within_their_limits():
    labels = rendered(Placing(60.3, 50.2, 0.4, 330.0))
    for low, high in ((300.0, 340.0), (0.0, 200.0), (500.0, 0.0), (330.0, 330.0)):
        found, frame, _ = guesses(labels, settings(min_scale=low, max_scale=high))
        scale = frame.camera.focal_px / found.poses.t[:, 2]
        assert ((scale >= low * (1 - 1e-6)) & (scale <= (high or np.inf) * (1 + 1e-6))).all(), (low, high)
    assert len(guesses(labels, settings(min_scale=300.0, max_scale=340.0))[0].poses)


def test_of_no_blob_there_is_no_guess():
    found, _, count = guesses(np.zeros((40, 50), np.uint8))
    assert count == 0 and not len(found.poses) and not len(found.votes)
