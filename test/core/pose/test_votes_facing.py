"""What pixels of no class say of markers that face the camera."""

import numpy as np
import pytest
from settings import settings
from squares import ROBOT, TEAM

from artrec_ros.core.base.config import ClassConfig, ImageConfig
from artrec_ros.core.image.codes import EMPTY, LABELS
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder

RGB = {TEAM: (200, 30, 30), 4: (30, 180, 40), 5: (30, 40, 200)}
COLOURS = ImageConfig(kind="colour", classes={f"c{n}": ClassConfig(label=n, rgb=rgb) for n, rgb in RGB.items()})


@pytest.mark.parametrize(("colour", "facing"), [(True, True), (False, True), (True, False)])
def test_nothing_speaks_as_another_class_where_shade_keeps_a_share_of_its_own(colour, facing):
    """In colour images of flat objects; elsewhere a segmenter leaves of shade what it leaves of nothing."""
    config = settings()
    codes = Segmenter(COLOURS).meaning if colour else LABELS
    surface = WholeObjectFinder(Target("robot", ROBOT["plain"], TEAM), config, codes, facing=facing).surface
    nothing = surface.table[surface.roles.inside(surface.labels[surface.root])][EMPTY]
    own, _, other = config.votes.inside
    assert nothing == pytest.approx(other if colour and facing else config.votes.inside_empty)
    assert np.isclose(nothing, other) == (colour and facing) and own + nothing > 0  # half of one may be blotted out
