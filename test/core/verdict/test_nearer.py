"""What lies before a marker does not end it: an object rests where it is though another one hides part of it."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from settings import DEFAULTS
from solids import BLUE, RED, camera_of, pose, render, sign, truck

from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.codes import OWNED
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Box
from artrec_ros.core.model.surface import INSIDE_POINTS
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.verdict.acceptance import verdicts_of
from artrec_ros.core.verdict.at_rest import at_rest
from artrec_ros.core.verdict.claims import claims_of, silhouette
from artrec_ros.core.verdict.descriptions import Describer
from artrec_ros.core.verdict.nearer import behind_others, hidden_by_each, met_by_each

CAMERA = camera_of((640, 480), 600.0)
MODEL = truck()
FAR, NEAR = pose(0, 0, 1.4, 0.2, model=MODEL), pose(0.1, 0.02, 0.9, 0.1, model=MODEL)
APART = pose(-0.6, 0, 1.4, 0.2, model=MODEL)


def scene(far: Poses, near: Poses):
    """Two of unlike classes, the verdicts on both, and what shows them."""
    finders = [WholeObjectFinder(Target(MODEL.name, MODEL, label), DEFAULTS) for label in (RED, BLUE)]
    frame = ImageFrame(LabelField(render(CAMERA, [(MODEL, far, RED), (MODEL, near, BLUE)])), CAMERA)
    verdicts = [verdicts_of(claims_of(f, p, frame))[0] for f, p in zip(finders, (far, near), strict=True)]
    return finders, verdicts, frame


def test_only_the_nearer_one_hides_and_only_whom_it_meets():
    _, verdicts, frame = scene(FAR, NEAR)
    behind, before = behind_others(verdicts, verdicts, frame)
    assert (behind.field.codes == OWNED).any() and behind.field.hides
    assert before is frame
    _, verdicts, frame = scene(APART, NEAR)
    assert behind_others(verdicts, verdicts, frame) == [frame, frame]
    assert behind_others(verdicts[:1], verdicts[:1], frame) == [frame]


def test_an_object_is_fitted_without_the_border_of_what_lies_before_it():
    (finder, _), (verdict, other), frame = scene(FAR, NEAR)
    told, alone = (at_rest(finder, [verdict], among, frame) for among in ([verdict, other], [verdict]))
    assert told.frames[0].field.hides and alone.frames[0] is frame
    known, taken = (of.covariances(finder)[0, 2, 2] for of in (told, alone))
    assert known > 1.2 * taken  # fewer edges are its own
    assert np.linalg.norm(told.poses.t[0] - FAR.t[0]) < 4 * np.sqrt(known)


def test_where_all_edges_draw_what_is_hidden_is_known_too():
    """What an object leaves of its rim lies behind it, and comes to rest on it by the edges that both have."""
    (finder, _), (verdict, other), frame = scene(FAR, NEAR)
    apart = verdicts_of(claims_of(finder, APART, frame))[0]
    told, alone = (at_rest(finder, [verdict, apart], [verdict, apart, *more], frame) for more in ([other], []))
    used = finder.voter.supported(verdict.claim.scores)
    np.testing.assert_array_equal(told.drawn.t[:1], finder.rest.at_rest(frame, verdict.claim.poses, used).t)
    np.testing.assert_array_equal(alone.drawn.t, alone.poses.t)


def test_objects_are_told_in_their_order_whoever_hides_some():
    (finder, _), (verdict, other), frame = scene(FAR, NEAR)
    apart = verdicts_of(claims_of(finder, APART, frame))[0]
    told = at_rest(finder, [verdict, apart], [verdict, apart, other], frame)
    assert [f is frame for f in told.frames] == [False, True]
    one = at_rest(finder, [apart], [verdict, apart, other], frame)
    np.testing.assert_array_equal(told.poses.t[1], one.poses.t[0])


def test_what_lies_before_points_hides_them_and_what_lies_behind_does_not():
    _, verdicts, _ = scene(FAR, NEAR)
    labels = verdicts[0].claim.frame.field.labels
    points = [_facing_points(v) for v in verdicts]
    hidden = [hidden_from(v, verdicts, X).any(axis=0) for v, X in zip(verdicts, points, strict=True)]
    x, y = np.rint(project(CAMERA, points[0])).astype(int).T
    assert 0.2 < hidden[0].mean() < 0.9
    assert np.mean(hidden[0] == (labels[y, x] != RED)) > 0.95
    assert not hidden[1].any()
    assert not hidden_from(verdicts[0], verdicts[:1], points[0]).any()


def test_where_it_is_not_sure_what_is_nearer_that_hides_which_took_the_pixels():
    beside = pose(0.1, 0.02, 1.39, 0.1, model=MODEL)
    _, verdicts, _ = scene(FAR, beside)
    for (one, n), owned in product(zip(verdicts, (1, 0), strict=True), (True, False)):
        hidden = hidden_from(one, verdicts, _facing_points(one), owned, slack=0.3)[n]
        assert hidden.any() == owned


@pytest.mark.parametrize("post", [True, False])
def test_a_marker_hides_what_lies_behind_it(post):
    """Be it without a body, or before one that is narrower."""
    model = sign()
    if post:
        box = Box(Pose.from_xyz_rpy((0.0, 0.5, 0.0)), np.array([0.02, 0.2, 0.02]))
        model = replace(model, components=(replace(model.components[0], bodies=(box,)),))
    _, (verdict, _), frame = scene(FAR, NEAR)
    board = verdicts_of(
        claims_of(WholeObjectFinder(Target("s", model, BLUE), DEFAULTS), pose(0, 0, 0.9, model=model), frame)
    )[0]
    middle = project(CAMERA, board.claim.finder.required.anchors(board.claim.poses))[0]
    ray = np.array([*(middle - CAMERA.matrix[:2, 2]) / CAMERA.focal_px, 1.0])
    points = np.stack([ray * 1.2, ray * 0.6, ray * 1.2 + (0.4, 0, 0)])
    assert hidden_from(verdict, [verdict, board], points).tolist() == [[False] * 3, [True, False, False]]


def test_a_component_lies_amid_what_is_seen_of_it_whoever_took_its_pixels_first():
    (_, finder), (verdict, other), frame = scene(FAR, NEAR)
    rest = frame.without(silhouette(other.claim.finder.surface, CAMERA, verdict.claim.poses))
    taken = verdicts_of(claims_of(finder, NEAR, rest))[0]
    whole, behind = (Describer(finder).describe([v], frame, [v, verdict])[0] for v in (other, taken))
    assert taken.claim.scores.area_px.sum() < 0.9 * other.claim.scores.area_px.sum()
    places = [{c.component: (c.x, c.y) for c in d.components} for d in (whole, behind)]
    assert len(places[1]) > 1 and places[1].keys() <= places[0].keys()
    for name in places[1]:
        np.testing.assert_allclose(places[1][name], places[0][name], atol=1.0)


def hidden_from(verdict, among, points: np.ndarray, owned: bool = True, slack: float = 0.03) -> np.ndarray:
    """(N, n) which of N objects hides which of one's points, whose pixels are all another's, or its own."""
    return hidden_by_each(met_by_each([verdict], among, points[None])[:, 0], np.full(len(points), owned), slack)


def _facing_points(verdict) -> np.ndarray:
    """Points (n, 3) of all markers that face the camera and that the object itself does not hide."""
    surface, poses = verdict.claim.finder.surface, verdict.claim.poses
    frames = surface.kinematics.forward(poses.R, poses.t, poses.q)
    out = []
    for p, shown in zip(
        surface.markers.tolist(), surface.shown(frames, surface.markers, INSIDE_POINTS)[0], strict=True
    ):
        R, t = frames.R[0, surface.component[p]], frames.t[0, surface.component[p]]
        X = surface.patches[p].inside[:INSIDE_POINTS] @ R.T + t
        if (R @ surface.normal[p]) @ X.mean(axis=0) < 0:
            out.append(X[shown])
    return np.concatenate(out)
