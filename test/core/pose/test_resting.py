"""Where hypotheses come to rest: finer, and with all that speaks for them."""

from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS
from squares import TEAM, Placing, gate, rendered

from artrec_ros.core.base.config import FloorConfig
from artrec_ros.core.geometry.floor import Floor
from artrec_ros.core.geometry.scene import Scene
from artrec_ros.core.geometry.transforms import rotation_from_rotvec
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose import resting
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses

AT = Placing(72.3, 58.4, 0.7, 330.0, "gr", arm=0.3)
FINDER = WholeObjectFinder(Target("gate", gate(), TEAM), DEFAULTS, facing=True)
FRAME = ImageFrame(LabelField(rendered(AT))).faced()


@pytest.mark.parametrize(("bend", "taken"), [(0.05, True), (0.8, False)])
def test_no_rest_leaves_a_marker_that_spoke_for_what_rests(bend, taken, monkeypatch):
    """An arm that a fit bends off its label, while all else stays."""
    poses = AT.pose(FRAME.camera)
    used = FINDER.voter.supports(FRAME, poses)
    assert used.all()
    elsewhere = Poses(poses.R, poses.t, poses.q + bend)
    monkeypatch.setattr(resting.Fit, "of", lambda *args, **options: elsewhere)
    rested = FINDER.rest.settled(FRAME, poses, used)
    np.testing.assert_array_equal(rested.q, elsewhere.q if taken else poses.q)
    votes = [FINDER.voter.votes(FRAME, at, occlusion=True)[0] for at in (poses, elsewhere)]
    assert votes[1] > DEFAULTS.search.settled_votes * votes[0]  # of all votes enough are left


@pytest.mark.parametrize(("bend", "taken"), [(0.05, True), (0.8, False)])
def test_no_colours_take_a_marker_off_its_label(bend, taken, monkeypatch):
    """An arm that a fit to colours bends off what bears its class, while all else stays."""
    frame, poses = replace(FRAME, image=np.zeros((1, 1, 3), np.uint8)), AT.pose(FRAME.camera)
    elsewhere = Poses(poses.R, poses.t, poses.q + bend)
    monkeypatch.setattr(FINDER.rest._to_colours, "fitted", lambda *args: elsewhere)
    rested = FINDER.rest.on_colours(frame, poses, FINDER.voter.supports(FRAME, poses))
    np.testing.assert_array_equal(rested.q, elsewhere.q if taken else poses.q)


def test_a_marker_that_did_not_speak_for_it_before_is_none_to_lose(monkeypatch):
    poses = AT.pose(FRAME.camera)
    off, elsewhere = (Poses(poses.R, poses.t, poses.q + bend) for bend in (0.8, -0.8))
    assert not (FINDER.voter.supports(FRAME, off).all() or FINDER.voter.supports(FRAME, elsewhere).all())
    used = np.ones((1, len(FINDER.surface.markers)), bool)
    monkeypatch.setattr(resting.Fit, "of", lambda *args, **options: elsewhere)
    np.testing.assert_array_equal(FINDER.rest.settled(FRAME, off, used).q, elsewhere.q)


@pytest.mark.parametrize(("lean_deg", "taken"), [(5.0, True), (9.0, False)])
def test_no_rest_leans_more_than_what_stands_on_the_floor(lean_deg, taken, monkeypatch):
    """A fit to labels, and one to colours."""
    finder = WholeObjectFinder(Target("gate", gate(), TEAM), DEFAULTS)
    at = AT.pose(FRAME.camera)
    upright, over = (rotation_from_rotvec(np.radians([[90.0 + by, 0, 0]])) for by in (0.0, lean_deg))
    stood, leans = Poses(upright, at.t, at.q), Poses(over, at.t, at.q)
    height = 10.0
    floor = FloorConfig(camera_height_m=height, object_height_m=height, height_tolerance_m=height, max_tilt_deg=8.0)
    frame = replace(FRAME, scene=Scene(floor=Floor.of(floor)), image=np.zeros((1, 1, 3), np.uint8))
    used = np.zeros((1, len(finder.surface.markers)), bool)
    monkeypatch.setattr(resting.Fit, "of", lambda *args, **options: leans)
    monkeypatch.setattr(finder.rest._to_colours, "fitted", lambda *args: leans)
    monkeypatch.setattr(finder.voter, "total", lambda scores: np.ones(len(scores.votes)))
    expected = leans if taken else stood
    np.testing.assert_array_equal(finder.rest.settled(frame, stood, used).R, expected.R)
    np.testing.assert_array_equal(finder.rest.on_colours(frame, stood, used).R, expected.R)
