"""What faces the camera and is flat is all at one depth: its votes are the same, and take less time."""

from copy import copy
from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS
from squares import ROBOT, TEAM, Placing, gate, hinge, rendered, robot

from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.surface_model import SpatialModel
from artrec_ros.core.pose.voter import Voter


@pytest.mark.parametrize("swollen_px", [0.0, 1.0])
@pytest.mark.parametrize(("name", "arm"), [("plain", None), ("gate", 0.4)])
def test_votes_are_the_same_as_those_of_a_surface_in_space(name, arm, swollen_px):
    rng, at = np.random.default_rng(3), Placing(60.0, 50.0, 0.4, 300.0, arm=arm)
    frame = ImageFrame(LabelField(rendered(at))).faced()
    surface = WholeObjectFinder(Target(name, ROBOT[name], TEAM), DEFAULTS, facing=True).surface.swollen(swollen_px)
    some = rng.uniform((50, 40, 0, 200), (160, 60, 6, 400), (60, 4))
    off = [replace(at, x=x, y=y, turn=turn, scale=scale) for x, y, turn, scale in some]
    poses = Poses.concatenate([p.pose(frame.camera) for p in (at, *off)])
    in_space = copy(surface)
    in_space.limits = surface.limits._replace(level=False)
    assert surface.limits.level
    level, general = (Voter(s, DEFAULTS).judge(frame, poses, occlusion=True, covered=True) for s in (surface, in_space))
    for one, other in zip(level.arrays, general.arrays, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-9)
    assert level.votes[0].sum() > 0


def test_what_can_be_tipped_is_not_level():
    plain = gate()
    (*rest, arm) = plain.components
    tipped = replace(arm, joint=hinge("team", (0.03, 0.0, 0.0), (0, 1, 0)))
    surfaces = [SpatialModel(m, TEAM, DEFAULTS.votes) for m in (robot(), plain, ObjectModel("lid", (*rest, tipped)))]
    assert [s.is_level for s in surfaces] == [True, True, False]
