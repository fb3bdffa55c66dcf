"""What is told of found objects: the same, alone or together, as the image shows it."""

from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS, settings
from solids import BLUE, CAB, RED, camera_of, frames_of, pose, rectangle, render, sign, truck
from squares import Placing, hinge, patch, rendered

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.image.codes import OUTSIDE
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose import resting as whole_object
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict import at_rest as resting
from artrec_ros.core.verdict.acceptance import verdicts_of
from artrec_ros.core.verdict.claims import claims_of
from artrec_ros.core.verdict.descriptions import Describer
from artrec_ros.core.verdict.judge import Judge
from artrec_ros.core.verdict.parts import part_probabilities

CAMERA = camera_of()


def scene(model, *poses):
    """A describer, the verdicts on true poses, and the image that shows them."""
    frame = ImageFrame(LabelField(render(CAMERA, [(model, p, RED) for p in poses])), CAMERA)
    finder = WholeObjectFinder(Target(model.name, model, RED), DEFAULTS)
    verdicts = list(verdicts_of(claims_of(finder, Poses.concatenate(list(poses)), frame)))
    return Describer(finder), verdicts, frame


MODELS = {"truck": truck(), "bare": truck(bodies=False), "sign": sign()}
PLACES = {  # apart; and half out of the image, half behind the other
    "apart": ((-0.25, 0, 1.0, 0.3), (0.25, 0.02, 1.1, -0.4)),
    "cut and hidden": ((0.02, 0, 0.8, 0.2), (0.2, 0, 1.2, 0.2), (-0.5, 0, 1.0, 0.1)),
}


@pytest.mark.parametrize("places", PLACES)
@pytest.mark.parametrize("name", MODELS)
def test_together_they_are_described_as_one_by_one(name, places):
    model = MODELS[name]
    describer, verdicts, frame = scene(model, *(pose(*p, model=model) for p in PLACES[places]))
    together = describer.describe(verdicts, frame)
    assert [d.id for d in together] == list(range(len(verdicts)))
    scores = [d.score for d in together]
    assert scores == sorted(scores, reverse=True)
    for verdict in verdicts:
        (alone,) = describer.describe([verdict], frame)
        (same,) = (d for d in together if np.allclose(d.pose.position, alone.pose.position, atol=1e-9))
        np.testing.assert_allclose(same.pose.rotation, alone.pose.rotation, atol=1e-9)
        np.testing.assert_allclose(same.pose_covariance, alone.pose_covariance, rtol=1e-6, atol=1e-15)
        assert same.joints == pytest.approx(alone.joints)
        assert [(p.component, p.marker) for p in same.components] == [(p.component, p.marker) for p in alone.components]
        for one, other in zip(same.components, alone.components, strict=True):
            numbers = ((p.x, p.y, p.theta, p.scale, p.score) for p in (one, other))
            np.testing.assert_allclose(*numbers, atol=1e-9)
            np.testing.assert_allclose(one.contour, other.contour, atol=1e-9)


def pixels_of(points, component, detection, surface):
    """(n, 2) of points on a component of a described object."""
    joints = [detection.joints.get(c.name, 0.0) for c in surface.model.joint_components]
    at = Poses(detection.pose.rotation[None], detection.pose.position[None], np.array([joints]))
    frames = frames_of(surface, at)
    return project(CAMERA, points @ frames.R[0, component].T + frames.t[0, component])


def test_a_component_lies_amid_what_is_seen_of_its_marker():
    model = MODELS["truck"]
    whole, cut = pose(0.1, 0, 0.9, 0.1, model=model), pose(-0.5, 0, 1.0, 0.1, model=model)
    describer, verdicts, frame = scene(model, whole, cut)
    surface = verdicts[0].claim.finder.surface
    names = [c.name for c in model.components]
    markers = {(names[p.component], p.marker.name): p for p in surface.patches if p.marker is not None}
    for detection in describer.describe(verdicts, frame):
        assert detection.components
        for part in detection.components:
            patch = markers[part.component, part.marker]
            inside, drawn = (pixels_of(X, patch.component, detection, surface) for X in (patch.inside, patch.drawn))
            seen = inside[(inside > -0.5).all(axis=1) & (inside < (319.5, 239.5)).all(axis=1)]
            expected = seen.mean(axis=0) if len(seen) else drawn[0]
            np.testing.assert_allclose((part.x, part.y), expected, atol=4.0)  # a leg may hide a little of it
            np.testing.assert_allclose(part.contour, drawn[3:], atol=1e-6)


def test_a_component_in_full_view_lies_at_its_outlines_centroid():
    model = MODELS["sign"]
    at = pose(0.03, -0.02, 0.5, 0.4, model=model)
    describer, verdicts, frame = scene(model, at)
    (detection,) = describer.describe(verdicts, frame)
    (part,) = detection.components
    truth = pixels_of(model.components[0].markers[0].centre[None], 0, detection, verdicts[0].claim.finder.surface)
    np.testing.assert_allclose((part.x, part.y), truth[0], atol=1e-6)


def test_scale_is_pixels_per_metre_at_the_outlines_centroid():
    """A front that stands 11 cm before the object's origin, 40 cm away."""
    model = MODELS["bare"]
    at = pose(0, 0, 0.4, -np.pi / 2, model=model)
    describer, verdicts, frame = scene(model, at)
    (detection,) = describer.describe(verdicts, frame)
    surface, focal = verdicts[0].claim.finder.surface, np.sqrt(np.prod(np.diag(CAMERA.matrix)[:2]))
    names, told = [c.name for c in model.components], []
    for part in detection.components:
        patch = next(p for p in surface.patches if (names[p.component], p.marker.name) == (part.component, part.marker))
        told.append(part.marker)
        joints = np.array([[detection.joints.get(c.name, 0.0) for c in model.joint_components]])
        frames = frames_of(surface, Poses(detection.pose.rotation[None], detection.pose.position[None], joints))
        depth = (frames.R[0, patch.component] @ patch.drawn[0] + frames.t[0, patch.component])[2]
        assert part.scale == pytest.approx(focal / depth, rel=1e-6)
        assert abs(part.scale / (focal / 0.4) - 1) > 0.1 or part.marker != "front"
    assert "front" in told


def test_nothing_is_described_by_nothing():
    describer, _, frame = scene(MODELS["sign"], pose(0, 0, 1.0, model=MODELS["sign"]))
    assert describer.describe([], frame) == []


def test_a_fit_that_loses_its_votes_is_not_taken(monkeypatch):
    model = MODELS["truck"]
    poses = Poses.concatenate([pose(x, 0, 1.0, 0.3, model=model) for x in (-0.25, 0.0, 0.25)])
    frame = ImageFrame(LabelField(render(CAMERA, [(model, poses[[n]], RED) for n in range(3)])), CAMERA)
    finder = WholeObjectFinder(Target("truck", model, RED), DEFAULTS)
    fitted = replace(poses, t=poses.t + [[0.001, 0, 0], [0, 0.5, 0], [0.002, 0, 0]])
    # what lost an end is fitted again, by itself
    monkeypatch.setattr(whole_object.Fit, "of", lambda _, __, begun, *___, **____: fitted if len(begun) == 3 else begun)
    settled = finder.rest.settled(frame, poses, np.ones((3, len(finder.surface.markers)), bool))
    np.testing.assert_array_equal(settled.t, [fitted.t[0], poses.t[1], fitted.t[2]])


def test_joints_deviate_by_no_more_than_who_knows_nothing(monkeypatch):
    model = MODELS["truck"]
    describer, verdicts, frame = scene(model, pose(0.02, 0, 0.8, 0.2, model=model))
    monkeypatch.setattr(resting, "pose_covariances", lambda *args, **_: np.eye(8)[None] * 100.0)
    (told,) = describer.describe(verdicts, frame)
    assert told.joint_deviations == pytest.approx({"fore": 1.6 / 12**0.5, "hind": 1.6 / 12**0.5})


def test_where_one_is_there_is_no_other():
    """A candidate beside it comes to rest on it."""
    model = truck()
    at = pose(0, 0, 0.8, 0.2, model=model)
    describer, verdicts, frame = scene(model, at, pose(0.002, 0, 0.81, 0.22, model=model))
    (told,) = describer.describe(verdicts, frame)
    assert np.allclose(told.pose.position, at.t[0], atol=0.01)


PLATE, HAND = CAB * 0.6, rectangle(0.02, 0.02, (0.14, 0.0))


class Reaching(Placing):
    """A plate, and what is at the end of an arm that nobody sees."""

    def patches(self):
        return [(self.at(PLATE), RED), (self.at(HAND), BLUE)]


def test_of_what_faces_the_camera_parts_are_seen_where_it_comes_to_rest():
    """A candidate that is a little too large lies beside what is at the end of a long limb."""
    hand = Component("hand", (patch("hand", HAND),), label=BLUE, joint=hinge("plate", (0, 0, 0), (0, 0, 1)))
    model = ObjectModel("robot", (Component("plate", (patch("plate", PLATE),), required=True), hand))
    finder = WholeObjectFinder(Target("robot", model, RED), DEFAULTS, facing=True)
    at = Reaching(150, 120, 0.4, 500.0)
    frame = ImageFrame(LabelField(rendered(at, size=(320, 240))), None).faced()
    focal, c, s = frame.camera.focal_px, np.cos(at.turn), np.sin(at.turn)
    ray = (np.array([at.x, at.y]) - frame.camera.matrix[:2, 2]) / focal
    R = np.array([[c, -s, 0], [-s, -c, 0], [0, 0, -1.0]])
    too_large = Poses(R[None], focal / (1.05 * at.scale) * np.array([[*ray, 1.0]]), np.zeros((1, 1)))
    verdicts = list(verdicts_of(claims_of(finder, too_large, frame)))
    (before,) = part_probabilities(verdicts)
    assert before[1] < DEFAULTS.min_component_probability
    (told,) = Describer(finder).describe(verdicts, frame)
    assert [part.component for part in told.components] == ["plate", "hand"] and told.missing == ()


def test_what_a_view_from_above_does_not_show_is_out_of_view():
    """Its codes say so, however large it is."""
    at = pose(0, 0, 0.8, 0.2, model=MODELS["truck"])
    describer, _, frame = scene(MODELS["truck"], at)
    (whole,) = describer.describe(list(verdicts_of(claims_of(describer.finder, at, frame))), frame)
    fore = next(part for part in whole.components if part.component == "fore")
    codes = frame.field.codes.copy()
    codes[:, int(fore.contour[:, 0].min()) - 2 :] = OUTSIDE
    cut = ImageFrame(LabelField(codes), CAMERA)
    (told,) = describer.describe(list(verdicts_of(claims_of(describer.finder, at, cut))), cut)
    assert {lack.component: lack.state for lack in told.missing}["fore"] == "out of view"


def rested_at(monkeypatch, elsewhere):
    """Have what is described turned so at rest."""
    monkeypatch.setattr(resting, "likelier_turns", lambda finder, frame, poses: (elsewhere, [None] * len(poses)))


def test_components_are_told_where_the_told_pose_has_them(monkeypatch):
    """A turn that is likelier by all the rest may lay one of them on nothing."""
    model, one = truck(), (-0.05, 0, 0.8, 0.2)
    describer, verdicts, frame = scene(model, pose(*one, model=model))
    (found,) = describer.describe(verdicts, frame, verdicts)
    assert {c.component for c in found.components} == {"torso", "fore", "hind"}
    rested_at(monkeypatch, pose(*one, model=model, joints={"hind": 0.7}))
    (turned,) = describer.describe(verdicts, frame, verdicts)
    assert {c.component for c in turned.components} == {"torso", "fore"}
    assert {m.component for m in turned.missing} == {"hind"}


def test_what_is_judged_anew_does_not_hide_itself(monkeypatch):
    """Its pixels are owned by what it was found as."""
    model, at = truck(), (-0.05, 0, 0.8, 0.2)
    engine = Recognizer((Target("truck", model, RED),), settings(time_budget_ms=60000.0), Segmenter(ImageConfig()))
    rested_at(monkeypatch, pose(-0.05, 0, 0.84, 0.2, model=model))  # behind where it is found
    labels = render(CAMERA, [(model, pose(*at, model=model), RED)])
    (behind,) = engine.recognize(labels, CAMERA).detections
    assert behind.pose.position[2] == pytest.approx(0.84)
    monkeypatch.undo()
    (found,) = engine.recognize(labels, CAMERA).detections
    for one, same in zip(found.components, behind.components, strict=True):
        assert np.hypot(same.x - one.x, same.y - one.y) < 5, one.component


def test_a_likelier_turn_that_would_be_no_object_is_told_beside_what_was_found(monkeypatch):
    """Where an outline is off no pose may be an object that is likelier: what is told is not sure for that."""
    model, one = truck(), (-0.05, 0, 0.8, 0.2)
    off = pose(-0.05, 0, 0.8, 0.8, model=model)
    describer, verdicts, frame = scene(model, pose(*one, model=model))
    monkeypatch.setattr(describer.finder.rest, "at_rest", lambda frame, poses, used: off)  # found a little off
    monkeypatch.setattr(Judge, "reason", lambda judge, verdict: "improbable" if judge.min_probability else None)
    rested_at(monkeypatch, pose(*one, model=model))
    (same,) = describer.describe(verdicts, frame)
    np.testing.assert_allclose(same.pose.rotation, off.R[0])
    np.testing.assert_allclose(same.other_turn.pose.rotation, pose(*one, model=model).R[0])
    assert same.other_turn.probability > 0.9
    monkeypatch.setattr(Judge, "reason", lambda *args: "it can't be there")
    (alone,) = describer.describe(verdicts, frame)
    assert alone.other_turn is None


def test_none_rests_beyond_the_distances_that_are_looked_for():
    """One that lies a little beyond them may be found within; a fit would take it back."""
    model, at = truck(), (-0.05, 0, 0.8, 0.2)
    config = settings(time_budget_ms=60000.0, max_range_m=0.797)
    engine = Recognizer((Target("truck", model, RED),), config, Segmenter(ImageConfig()))
    (found,) = engine.recognize(render(CAMERA, [(model, pose(*at, model=model), RED)]), CAMERA).detections
    assert 0.7 < found.pose.position[2] <= 0.797


def test_what_would_be_no_object_there_is_told_as_it_was_found(monkeypatch):
    model, one = truck(), (-0.05, 0, 0.8, 0.2)
    describer, verdicts, frame = scene(model, pose(*one, model=model))
    (found,) = describer.describe(verdicts, frame)
    rested_at(monkeypatch, pose(0.3, 0.2, 0.8, 0.2, model=model))
    (same,) = describer.describe(verdicts, frame)
    np.testing.assert_allclose(same.pose.position, found.pose.position)
    assert {c.component for c in same.components} == {"torso", "fore", "hind"}
