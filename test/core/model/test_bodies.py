"""Bodies that were measured a little too large end beneath their markers."""

from dataclasses import replace

import numpy as np
import pytest
from solids import BODY, truck

from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.model.bodies import beneath_markers
from artrec_ros.core.model.objects import Box, Component


def torso(scale, turn=(0.0, 0.0, 0.0)):
    """The truck's torso in a box that many times as large, markers where they are; all of it turned together."""
    part = truck().required
    T = Pose(rotation_from_rotvec(turn), np.array([0.02, -0.01, 0.3]))
    (box,) = part.bodies
    markers = tuple(replace(m, T_component_marker=T @ m.T_component_marker) for m in part.markers)
    return replace(part, bodies=(Box(T @ box.T_component_box, scale * box.size),), markers=markers)


def above(part: Component):
    """How far each marker lies above the side of the box that it is on."""
    (box,) = part.bodies
    out = {}
    for m in part.markers:
        in_box = box.T_component_box.inverse() @ m.T_component_marker
        axis = int(np.argmax(np.abs(in_box.rotation[:, 2])))
        out[m.name] = abs(in_box.position[axis]) - box.size[axis] / 2
    return out


@pytest.mark.parametrize("turn", [(0.0, 0.0, 0.0), (0.3, -1.0, 2.0)])
@pytest.mark.parametrize("scale", [1.05, 1.15, 1.4])
def test_a_box_that_is_too_large_ends_beneath_its_markers(scale, turn):
    given = torso(scale, turn)
    assert max(above(given).values()) < 0
    part, cut = beneath_markers(given)
    assert cut == ("right", "left", "front") and part.body_label == BODY
    assert all(0 < height < 1e-4 for height in above(part).values())
    (before,), (after,) = given.bodies, part.bodies
    assert after.size[2] == before.size[2]  # no marker lies on its upper and lower side
    assert beneath_markers(part) == (part, ())


def test_boxes_that_fit_and_markers_deep_within_stay():
    fits = torso(1.0)
    assert beneath_markers(fits)[1] == () and beneath_markers(fits)[0].bodies == fits.bodies
    (box,) = fits.bodies
    deep = replace(fits, bodies=(Box(box.T_component_box, 4 * box.size),))  # a mistake of another kind, which is told
    assert beneath_markers(deep) == (deep, ())
    beside = replace(fits, bodies=(Box(Pose.from_xyz_rpy((0, -0.03, 1.0)), box.size),))
    assert beneath_markers(beside) == (beside, ())
