"""Boxes that hide points from the camera."""

from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS
from solids import RED, RIGHT_SIDE, facing, frames_of, marker, pose, random_poses, rectangle, truck

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.pose.hiding_kernels import ALL_BOXES, boxes_in_camera, boxes_in_front
from artrec_ros.core.pose.occlusion import BEHIND
from artrec_ros.core.pose.surface_kernels import room_of
from artrec_ros.core.pose.surface_model import SpatialModel

pytestmark = pytest.mark.uncompiled

CORNERS = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T


def test_hidden_points_are_those_behind_a_box():
    """Against points close together along each line of sight."""
    model = truck()
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    poses = random_poses(np.random.default_rng(1), model, 4)
    frames, every = frames_of(surface, poses), np.arange(len(surface.patches))
    towards = facing(surface, frames, every) > 0.1
    found = surface.shown(frames, every, surface.compiled.count.min())
    shares = np.linspace(0, BEHIND, 1500)[:, None]
    hidden = compared = 0
    for h, p in np.argwhere(towards).tolist():
        c = surface.component[p]
        for n, point in enumerate(surface.patches[p].inside[: found.shape[2]]):
            at = frames.R[h, c] @ point + frames.t[h, c]
            depth = -np.inf  # how deep inside of any box the line of sight comes
            for b, on in enumerate(surface.boxes.component):
                if surface.ignored[p, b]:
                    continue
                local = (at * shares - frames.t[h, on]) @ frames.R[h, on]
                local = (local - surface.boxes.t[b]) @ surface.boxes.R[b]
                depth = max(depth, (surface.boxes.half[b] - np.abs(local)).min(axis=1).max())
            if abs(depth) > 1e-3:
                assert found[h, p, n] == (depth < 0)
                compared += 1
                hidden += depth > 0
    assert compared > 150 and 0.05 < hidden / compared < 0.7


@pytest.mark.parametrize("shift", [-0.2, -0.07, 0.0, 0.05, 0.3])
def test_a_slab_across_the_view_hides_what_its_shadow_covers(shift):
    """A plate of 20 by 8 cm, 1 m ahead, and a thin box half way, as large as a quarter of it in the image."""
    box = Box(Pose(np.eye(3), np.array([shift / 2, -0.5, 0.0])), np.array([0.05, 1e-6, 0.2]))
    plate = Component("plate", (marker("face", rectangle(0.2, 0.08), RIGHT_SIDE, (0, 0, 0)),), required=True)
    slab = Component("slab", plate.markers, joint=Joint("plate", Pose.identity(), np.eye(3)[0], 0, 0, "fixed"))
    model = ObjectModel("pair", (plate, replace(slab, bodies=(box,))))
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    shown = surface.shown(frames_of(surface, pose(0, 0, 1.0, model=model)), np.array([0]), 36)[0, 0]
    np.testing.assert_array_equal(shown, np.abs(surface.patches[0].inside[:, 0] - shift) > 0.05)


@pytest.mark.parametrize(("beside", "may_hide"), [(0.01, True), (0.05, False)])
def test_a_box_beside_the_shadow_of_a_slender_patch_is_not_looked_at(beside, may_hide):
    """A strip of 20 by 1 cm, and a thin box half way in front of it: within the patch's length of it, but beside it."""
    box = Box(Pose(np.eye(3), np.array([0.0, -0.5, beside])), np.array([0.01, 1e-3, 0.01]))
    strip = Component("strip", (marker("face", rectangle(0.2, 0.01), RIGHT_SIDE, (0, 0, 0)),), required=True)
    bar = Component("bar", strip.markers, joint=Joint("strip", Pose.identity(), np.eye(3)[0], 0, 0, "fixed"))
    model = ObjectModel("pair", (strip, replace(bar, bodies=(box,))))
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    frames = frames_of(surface, pose(0, 0, 1.0, model=model))
    s, R, t = surface.compiled, frames.R[0], frames.t[0]
    room = room_of(s)
    boxes_in_camera(s, R, t, room.box_rotation, room.eye, room.middle)
    place = R[0], R[0] @ s.normal[0], R[0] @ s.centre[0] + t[0]
    assert boxes_in_front(s, 0, *place, room, ALL_BOXES) == may_hide


def test_nothing_hides_anything_where_no_body_is_declared():
    model = truck(bodies=False)
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    poses = random_poses(np.random.default_rng(2), model, 3)
    assert surface.shown(frames_of(surface, poses), surface.markers, 36).all()


def test_a_face_does_not_hide_itself():
    model = truck()
    surface = SpatialModel(model, RED, DEFAULTS.votes)
    frames, every = frames_of(surface, pose(0.1, 0.05, 0.9, heading=0.5, model=model)), np.arange(len(surface.patches))
    towards = facing(surface, frames, every)[0] > 0.2
    of_torso = surface.component == 0
    assert surface.shown(frames, every, surface.compiled.count.min())[0, of_torso & towards].all()  # legs hang below it


def test_a_box_is_behind_the_patches_of_its_own_faces_and_of_markers_stuck_on_it():
    surface = SpatialModel(truck(), RED, DEFAULTS.votes)
    for p, patch in enumerate(surface.patches):
        for b, component in enumerate(surface.boxes.component):
            corners = surface.boxes.t[b] + CORNERS * surface.boxes.half[b]
            if component != patch.component or not np.allclose(surface.boxes.R[b], np.eye(3)):
                assert component == patch.component or not surface.ignored[p, b]
                continue
            highest = ((corners - patch.inside.mean(axis=0)) @ patch.normal).max()
            assert surface.ignored[p, b] == (highest < 1e-6)
    assert surface.ignored.any() and not surface.ignored.all()
