"""Where hypotheses come to rest: finer, and with all that speaks for them."""

import numpy as np
import pytest
from settings import DEFAULTS
from squares import TEAM, Placing, gate, rendered

from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose import resting
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.surface_model import Poses

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
    monkeypatch.setattr(resting, "fit_poses", lambda *args, **options: elsewhere)
    rested = FINDER.rest.settled(FRAME, poses, used)
    np.testing.assert_array_equal(rested.q, elsewhere.q if taken else poses.q)
    votes = [FINDER.voter.votes(FRAME, at, occlusion=True)[0] for at in (poses, elsewhere)]
    assert votes[1] > DEFAULTS.search.settled_votes * votes[0]  # of all votes enough are left


def test_a_marker_that_did_not_speak_for_it_before_is_none_to_lose(monkeypatch):
    poses = AT.pose(FRAME.camera)
    off, elsewhere = (Poses(poses.R, poses.t, poses.q + bend) for bend in (0.8, -0.8))
    assert not (FINDER.voter.supports(FRAME, off).all() or FINDER.voter.supports(FRAME, elsewhere).all())
    used = np.ones((1, len(FINDER.surface.markers)), bool)
    monkeypatch.setattr(resting, "fit_poses", lambda *args, **options: elsewhere)
    np.testing.assert_array_equal(FINDER.rest.settled(FRAME, off, used).q, elsewhere.q)
