"""Objects whose required component cannot be seen: turned away, hidden by another object, out of the image, or without
labels."""

from dataclasses import replace

import numpy as np
import pytest
from settings import settings
from solids import (
    BLUE,
    BODY,
    CAB,
    FRONT,
    GATE,
    RED,
    camera_of,
    chain,
    covered,
    marker,
    pose,
    rectangle,
    render,
    turn_between,
)

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig, TrackingConfig
from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.tracking.tracker import Tracker
from artrec_ros.core.verdict.acceptance import verdicts_of
from artrec_ros.core.verdict.claims import claims_of

CAMERA = camera_of()
BACK = FRONT @ np.diag([-1.0, 1.0, -1.0])
WEDGE = np.array([(-0.05, -0.05), (0.05, -0.05), (-0.05, 0.04)])
FROM_BEHIND, FROM_THE_FRONT = np.pi / 2, -np.pi / 2


def van():
    """A patch in front, and on its back two doors and a plate."""
    front = Component(
        "front",
        (marker("face", GATE * 1.4, FRONT, (0.1105, 0, 0)),),
        required=True,
        bodies=(Box(Pose.identity(), np.array([0.22, 0.26, 0.24])),),
        body_label=BODY,
    )
    plate = Component(
        "plate",
        (marker("face", CAB * 0.8, BACK, (-0.1115, 0.0, -0.07)),),
        joint=Joint("front", Pose.identity(), np.array([0.0, 0.0, 1.0]), 0.0, 0.0, "fixed"),
    )
    doors = [
        Component(
            name,
            (marker("face", shape, BACK, (-0.1115, y, 0.06)),),
            joint=Joint("front", Pose.identity(), np.array([0.0, 1.0, 0.0]), -0.1, 0.1, "prismatic"),
            label=label,
        )
        for name, y, shape, label in (("left", 0.06, WEDGE, None), ("right", -0.06, rectangle(0.06, 0.08), BLUE))
    ]
    return ObjectModel("van", (front, plate, *doors))


def recognizer(model, required):
    config = RecognizerConfig(time_budget_ms=60000.0, required=required)
    return Recognizer([Target(model.name, model, RED)], config, Segmenter(ImageConfig()))


def picture(model, at):
    return render(CAMERA, [(model, at, RED)])


@pytest.mark.parametrize("required", ["strict", "visible"])
def test_an_object_from_behind_is_one_only_where_that_is_asked_for(required):
    model = van()
    at = pose(heading=FROM_BEHIND, z=0.8, model=model)
    result = recognizer(model, required).recognize(picture(model, at), CAMERA)
    if required == "strict":
        assert not result.detections
        return
    (van_,) = result.detections
    assert np.linalg.norm(van_.pose.position - at.t[0]) < 0.03 * at.t[0, 2]
    assert np.degrees(turn_between(van_.pose.rotation, at.R[0])) < 10
    assert {c.component for c in van_.components} == {"plate", "left", "right"}
    assert {"left", "right"} <= set(van_.joints)
    assert abs(van_.image.x - CAMERA.size[0] / 2) < 20 and van_.image.scale > 0
    tracked = Tracker(TrackingConfig(), [Target(model.name, model, RED)]).update(0, result, "camera")
    assert [d.id for d in tracked.detections] == [0]


def beside():
    """A plate with three more in its plane, far from it."""
    at = {"root": (-0.35, 0.0), "a": (0.0, 0.08), "b": (0.05, -0.08), "c": (0.2, 0.02)}
    shapes = {"root": GATE * 1.4, "a": CAB * 0.8, "b": WEDGE, "c": rectangle(0.06, 0.1)}
    up = np.eye(3)
    return ObjectModel(
        "board",
        tuple(
            Component(
                name,
                (marker("face", shapes[name], up, (x, y, 0.0)),),
                name == "root",
                None,
                None if name == "root" else Joint("root", Pose.identity(), np.array([0.0, 0, 1]), 0.0, 0.0, "fixed"),
            )
            for name, (x, y) in at.items()
        ),
    )


def faced(x):
    return Poses(np.diag([1.0, -1.0, -1.0])[None], np.array([[x, 0.0, 0.8]]), np.zeros((1, 0)))


def test_out_of_the_image_it_is_not_missed():
    model, at = beside(), faced(-0.15)
    labels = picture(model, at)
    assert not recognizer(model, "strict").recognize(labels, CAMERA).detections
    (one,) = recognizer(model, "visible").recognize(labels, CAMERA).detections
    assert {c.component for c in one.components} == {"a", "b", "c"} and one.image.x < 0
    assert np.linalg.norm(one.pose.position - at.t[0]) < 0.03 * at.t[0, 2]


def test_behind_another_object_it_is_not_missed():
    model, at = beside(), faced(0.05)
    screen = ObjectModel(
        "screen", (Component("plate", (marker("face", rectangle(0.2, 0.24), np.eye(3), (0, 0, 0)),), True),)
    )
    hides = Poses(np.diag([1.0, -1.0, -1.0])[None], np.array([[-0.225, 0.0, 0.6]]), np.zeros((1, 0)))
    labels = render(CAMERA, [(model, at, RED), (screen, hides, BLUE)])
    targets = [Target("board", model, RED), Target("screen", screen, BLUE)]
    for required, count in (("strict", 0), ("visible", 1)):
        config = RecognizerConfig(time_budget_ms=60000.0, required=required)
        found = Recognizer(targets, config, Segmenter(ImageConfig())).recognize(labels, CAMERA).detections
        assert sum(d.object == "board" for d in found) == count


def test_equal_shapes_of_two_classes_lead_to_it_alike():
    left, right = (
        Component("root", (marker("face", GATE, np.eye(3), (0, 0, 0)),), True),
        [
            Component(n, (marker("face", CAB, np.eye(3), (x, 0, 0)),), label=c)
            for n, x, c in (("a", 0.2, RED), ("b", 0.4, BLUE))
        ],
    )
    finder = WholeObjectFinder(
        Target("pair", ObjectModel("pair", (left, *right)), RED), RecognizerConfig(required="visible")
    )
    assert finder.seed_labels == {RED, BLUE}
    banks = [finder._seeds._guessers[c]._banks[0] for c in (1, 2)]
    assert [bank.look.inside[RED] > 0 for bank in banks] == [True, False]


def test_what_is_in_plain_view_is_told_as_before():
    model = van()
    at = pose(heading=FROM_THE_FRONT + 0.4, z=0.8, model=model)
    strict, visible = (
        recognizer(model, required).recognize(picture(model, at), CAMERA) for required in ("strict", "visible")
    )
    assert [c.component for d in visible.detections for c in d.components] == ["front"]
    assert len(strict.detections) == 1


def test_a_required_component_that_should_be_seen_and_is_not_is_missed():
    """The same pixels, but its marker was on the back, too: who sees the back must see it, and not the body there."""
    model = van()
    front = model.components[0]
    shown = marker("back", rectangle(0.05, 0.05), BACK, (-0.1115, 0.0, 0.0))
    twice = Component("front", (*front.markers, shown), True, None, None, front.bodies, BODY)
    labels = picture(model, pose(heading=FROM_BEHIND, z=0.8, model=model))
    other = ObjectModel("van", (twice, *model.components[1:]))
    assert not recognizer(other, "visible").recognize(labels, CAMERA).detections


def test_a_required_component_whose_labels_are_gone_is_not_missed():
    """A segmenter knows nothing of it, in deep shade; the others lie where it lets them lie."""
    model, at = beside(), faced(0.05)
    labels = picture(model, at)
    labels[:, : CAMERA.size[0] // 2 - 20][labels[:, : CAMERA.size[0] // 2 - 20] == RED] = 0  # the root is on the left
    assert not recognizer(model, "strict").recognize(labels, CAMERA).detections
    (one,) = recognizer(model, "visible").recognize(labels, CAMERA).detections
    (whole,) = recognizer(model, "visible").recognize(picture(model, at), CAMERA).detections
    assert {c.component for c in one.components} == {"a", "b", "c"} and one.score < whole.score
    assert np.linalg.norm(one.pose.position - at.t[0]) < 0.03 * at.t[0, 2]
    assert abs(one.image.x - whole.image.x) < 3 and abs(one.image.y - whole.image.y) < 3


HALF = 0.03
SEEN = np.array([[0.0, 0.0, 0.5]])
SIDES = dict(zip(("red", "green", "blue", "cyan", "white", "mint"), [*np.eye(3), *-np.eye(3)], strict=True))


def cube():
    """Another colour on each side; red is the one in front."""

    def side(normal):
        x, z = np.roll(normal, 1), normal
        return Pose(np.column_stack([x, np.cross(z, x), z]), HALF * 1.01 * z)

    box = (Box(Pose.identity(), np.full(3, 2 * HALF)),)
    parts = []
    for label, (name, normal) in enumerate(SIDES.items(), RED):
        at = side(normal)
        face = marker("face", rectangle(2 * HALF, 2 * HALF), at.rotation, at.position)
        own = (True, None, None, box) if name == "red" else (False, label)
        parts.append(Component(name, (face,), *own))
    return ObjectModel("cube", tuple(parts))


@pytest.mark.parametrize("turn", [0.4, 1.2, 2.4, 4.0, 5.4])
def test_a_cube_is_as_sure_whichever_of_its_sides_is_called_required(turn):
    """That is a name: it is the same cube, as plainly in view."""
    model = cube()
    R = rotation_from_rotvec([0.6, 0.0, 0.0]) @ rotation_from_rotvec([0, turn, 0]) @ rotation_from_rotvec([0.2, 0, 0.3])
    at = Poses(R[None], np.array([[0.01, 0.02, 0.5]]), np.zeros((1, 0)))
    labels = picture(model, at)
    (one,) = recognizer(model, "visible").recognize(labels, CAMERA).detections
    assert one.score > 0.95 and turn_between(one.pose.rotation, at.R[0]) < 0.05
    seen = {c.component for c in one.components}
    strict = recognizer(model, "strict").recognize(labels, CAMERA)
    assert len(strict.detections) == ("red" in seen)
    others = [replace(c, required=c.name == max(seen)) for c in model.components]
    (other,) = recognizer(ObjectModel("cube", tuple(others)), "strict").recognize(labels, CAMERA).detections
    assert one.score == pytest.approx(other.score, abs=0.03)


def test_one_side_of_a_cube_alone_is_six_times_as_easily_clutter():
    """It may be any of six that is looked for in it."""
    model, white = cube(), Poses(np.column_stack([(1, 0, 0), (0, 0, 1), (0, -1, 0)])[None], SEEN, np.zeros((1, 0)))
    frame = ImageFrame(LabelField(picture(model, white)), CAMERA)
    odds, cases = [], []
    for name in ("red", "white"):
        one = ObjectModel("cube", tuple(replace(c, required=c.name == name) for c in model.components))
        finder = WholeObjectFinder(Target("cube", one, RED), settings(required="visible"))
        (verdict,) = verdicts_of(claims_of(finder, white, frame))
        odds.append(verdict.probability / (1 - verdict.probability))
        cases.append(verdict.case)
    assert cases == ["unseen, alone", "alone"]
    assert odds[0] * 6 == pytest.approx(odds[1])


def test_it_is_followed_from_image_to_image():
    model, memory = van(), None
    looks = recognizer(model, "visible")
    for n in range(4):
        at = pose(x=0.01 * n, heading=FROM_BEHIND, z=0.8, model=model)
        result, memory = looks.follow(picture(model, at), CAMERA, n * 33_000_000, memory)
        (one,) = result.detections
        assert np.linalg.norm(one.pose.position - at.t[0]) < 0.03 * at.t[0, 2]
        assert "front" not in {c.component for c in one.components}


@pytest.mark.parametrize(("share", "told"), [(0.6, 1), (0.97, 0)])
def test_part_of_it_will_do_where_others_are_seen(share, told):
    model, camera = chain(), camera_of((640, 480), 600.0)
    at = pose(0, 0, 0.8, 0.3, 0.1, model)
    labels = covered(render(camera, [(model, at, RED)]), camera, at, model, share)
    config = settings(time_budget_ms=60000.0, supported_agree=0.75)  # what is left of it confirms nothing by itself
    found = Recognizer([Target(model.name, model, RED)], config, Segmenter(ImageConfig())).recognize(labels, camera)
    assert len(found.detections) == told
    assert all(np.linalg.norm(d.pose.position - at.t[0]) < 0.02 * at.t[0, 2] for d in found.detections)
