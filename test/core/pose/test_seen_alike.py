"""Placements that lay like markers where others are seen."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS
from squares import TEAM, hinge, robot
from tools_of_two import REACH, TAPE, tool
from wedges import DOT, DOTS, dotted

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.pose.seen_alike import SeenAlike
from artrec_ros.core.pose.surface_model import SpatialModel

THIRDS = 2 * np.pi * np.arange(3) / 3
EVEN = {str(n): (0.05 * np.cos(turn), 0.05 * np.sin(turn)) for n, turn in enumerate(THIRDS)}
ORIGIN = Poses(np.eye(3)[None], np.array([[0.0, 0.0, Camera.facing((100, 100)).focal_px]]), np.zeros((1, 0)))


def alike(model):
    return SeenAlike(SpatialModel(model, TEAM, DEFAULTS.votes))


@pytest.mark.parametrize(
    "seen, turns_deg",
    [((0, 1), [-29, 151, 180]), ((0, 2), [-151, 29, 180]), ((1, 2), [180]), ((0, 1, 2), []), ((0,), []), ((), [])],
)
def test_what_two_of_three_discs_may_be(seen, turns_deg):
    """Turns of all others, whichever way round nothing but the seen ones is laid."""
    found = np.rint(np.degrees(alike(dotted()).of(seen).angle_rad)).astype(int)
    assert sorted(180 if turn == -180 else turn for turn in found.tolist()) == turns_deg


@pytest.mark.parametrize("seen", [(0, 1), (0, 2), (1, 2)])
def test_like_discs_come_where_the_seen_ones_are_and_the_other_one_nowhere_else(seen):
    at = np.array([(*p, 0.0) for p in DOTS.values()])
    laid = alike(dotted()).of(seen).of(ORIGIN)
    for R, t in zip(laid.R, laid.t - ORIGIN.t, strict=True):
        off = np.linalg.norm((at @ R.T + t)[:, None] - at[list(seen)], axis=2)
        assert (off.min(axis=0) < 0.1 * DOT.radius).all() and (off.min(axis=1) > DOT.radius).sum() == 1


def test_turns_onto_itself_are_no_others():
    """Of an even triangle nothing tells its thirds: two discs are those of one other triangle, beyond them."""
    assert len(alike(dotted(EVEN)).of((0, 1))) == 1


def test_parts_of_other_sizes_classes_or_outlines_are_not_alike():
    parts = dotted().components
    large = replace(parts[1].markers[0], outline=1.6 * DOT.outline, disc_radius=None)
    for odd in (replace(parts[1], label=TEAM + 1), replace(parts[1], markers=(large,))):
        assert not len(alike(replace(dotted(), components=(parts[0], odd, parts[2]))).of((0, 1)))
    assert len(alike(robot()).of((0, 1))) == 0


def test_of_what_has_joints_nothing_is_said():
    parts = dotted().components
    swings = replace(parts[2], joint=hinge("front", (0.0, 0.0, 0.0), (0, 0, 1)))
    assert not len(alike(replace(dotted(), components=(*parts[:2], swings))).of((0, 1)))


@pytest.mark.parametrize("slides", [False, True])
def test_a_lone_part_that_looks_the_same_after_half_a_turn_may_be_turned_by_it(slides):
    """About its own middle, whatever joints carry the others; where one carries it that is elsewhere."""
    for seen, middle in ((0, 0.0), (1, 0.13)):
        found = alike(tool(slides=slides)).of((seen,))
        if slides and seen:
            assert not len(found)
            continue
        assert np.degrees(found.angle_rad) % 360 == pytest.approx([180.0])
        pose = ORIGIN if not slides else replace(ORIGIN, q=np.full((1, 1), 0.02))
        laid = found.of(pose)
        assert laid.R[0] @ [middle, 0, 0] + laid.t[0] - ORIGIN.t[0] == pytest.approx([middle, 0, 0], abs=1e-6)


@pytest.mark.parametrize(("corners", "turns"), [(4, 3), (6, 11), (24, 12)])
def test_the_rounder_a_lone_part_is_the_more_ways_it_may_be_turned(corners, turns):
    way = 2 * np.pi * np.arange(corners) / corners
    found = alike(tool(0.03 * np.column_stack([np.cos(way), np.sin(way)]))).of((0,))
    assert turns - 2 <= len(found) <= 12


def test_a_lone_part_whose_outline_tells_its_direction_is_as_it_lies():
    pointed = TAPE * np.array([[1, 1], [1, 0.4], [1, 0.4], [1, 1]])
    assert not len(alike(tool(pointed)).of((0,)))


def test_what_is_the_same_throughout_after_half_a_turn_has_no_other_place():
    """Nothing tells the two, and nothing comes of it."""
    parts = tool().components
    there = replace(parts[1].markers[0], T_component_marker=Pose(np.eye(3), np.array([-REACH, 0.0, 0.0])))
    assert not len(
        alike(replace(tool(), components=(*parts, replace(parts[1], name="nose", markers=(there,))))).of((0,))
    )
