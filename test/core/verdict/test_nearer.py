"""What lies before a marker does not end it: an object rests where it is though another one hides part of it."""

import numpy as np
from settings import DEFAULTS
from solids import BLUE, RED, camera_of, pose, render, truck

from artrec_ros.core.image.codes import OWNED
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.surface_model import Poses
from artrec_ros.core.verdict.acceptance import verdicts_of
from artrec_ros.core.verdict.at_rest import at_rest
from artrec_ros.core.verdict.claims import claims_of
from artrec_ros.core.verdict.nearer import behind_others

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
    told, alone = (at_rest(finder, [verdict], among, frame) for among in ([verdict, other], [verdict]))
    used = finder.voter.supported(verdict.claim.scores)
    np.testing.assert_array_equal(told.drawn.t, finder.rest.at_rest(frame, verdict.claim.poses, used).t)
    np.testing.assert_array_equal(alone.drawn.t, alone.poses.t)


def test_objects_are_told_in_their_order_whoever_hides_some():
    (finder, _), (verdict, other), frame = scene(FAR, NEAR)
    apart = verdicts_of(claims_of(finder, APART, frame))[0]
    told = at_rest(finder, [verdict, apart], [verdict, apart, other], frame)
    assert [f is frame for f in told.frames] == [False, True]
    one = at_rest(finder, [apart], [verdict, apart, other], frame)
    np.testing.assert_array_equal(told.poses.t[1], one.poses.t[0])
