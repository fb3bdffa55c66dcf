"""Boxes that hide points from the camera."""

import numpy as np
from solids import RED, frames_of, pose, random_poses, truck

from artrec_ros.core.pose.occlusion import BEHIND, SUNK_M
from artrec_ros.core.pose.surface_model import SpatialModel

CORNERS = np.array(np.meshgrid(*[[-1, 1]] * 3)).reshape(3, -1).T


def test_hidden_points_are_those_behind_a_box():
    model = truck()
    surface = SpatialModel(model, RED)
    rng = np.random.default_rng(1)
    poses = random_poses(rng, model, 4)
    frames = frames_of(surface, poses)
    X = poses.t[:, None] + rng.normal(0, 0.15, (4, 120, 3))
    shares = np.linspace(0, BEHIND, 1500)[:, None]
    truth = np.zeros(X.shape[:2], bool)
    clear = np.ones(X.shape[:2], bool)  # of doubt
    for h in range(4):
        for n, point in enumerate(X[h]):
            depth = -np.inf  # how deep inside of any box the line of sight comes
            for c, component in enumerate(model.components):
                for box in component.bodies:
                    local = (point * shares - frames.t[h, c]) @ frames.R[h, c]
                    local = box.T_component_box.inverse().apply(local)
                    depth = max(depth, (box.size / 2 - np.abs(local)).min(axis=1).max())
            truth[h, n] = depth > 0
            clear[h, n] = abs(depth) > 1e-3
    found = surface.boxes.hidden(frames, X, np.zeros((120, len(surface.boxes)), bool))
    assert 0.2 < truth.mean() < 0.8
    np.testing.assert_array_equal(found[clear], truth[clear])


def test_nothing_hides_anything_where_no_body_is_declared():
    model = truck(bodies=False)
    surface = SpatialModel(model, RED)
    poses = random_poses(np.random.default_rng(2), model, 3)
    X = np.tile(poses.t[:, None] * 2, (1, 5, 1))
    assert not surface.boxes.hidden(frames_of(surface, poses), X, np.zeros((5, 0), bool)).any()


def test_a_face_does_not_hide_itself():
    model = truck()
    surface = SpatialModel(model, RED)
    at = pose(0.1, 0.05, 0.9, heading=0.5, model=model)
    frames = frames_of(surface, at)
    everything = np.arange(len(surface.patches))
    cosine, _ = surface.in_camera(frames, everything)
    X = surface.place(frames, surface.points, surface.component[surface.point_patch])
    hidden = surface.boxes.hidden(frames, X, surface.ignored[surface.point_patch])[0]
    of_torso = surface.component[surface.point_patch] == 0
    towards = cosine[0, surface.point_patch] > 0.2
    assert not hidden[of_torso & towards].any()  # legs hang below it


def test_a_box_is_behind_the_patches_of_its_own_faces_and_of_markers_stuck_on_it():
    surface = SpatialModel(truck(), RED)
    for p, patch in enumerate(surface.patches):
        for b, component in enumerate(surface.boxes.component):
            corners = surface.boxes.t[b] + CORNERS * surface.boxes.half[b]
            if component != patch.component or not np.allclose(surface.boxes.R[b], np.eye(3)):
                assert component == patch.component or not surface.ignored[p, b]
                continue
            highest = ((corners - patch.inside.mean(axis=0)) @ patch.normal).max()
            assert surface.ignored[p, b] == (highest < SUNK_M)
    assert surface.ignored.any() and not surface.ignored.all()
