"""Images to whole objects in space: clean scenes of known truth, and images without any."""

from pathlib import Path

import numpy as np
import pytest
from solids import (
    BACKGROUND,
    BENT,
    BLUE,
    BODY,
    RATIONAL,
    RED,
    camera_of,
    chain,
    marker,
    pose,
    rectangle,
    render,
    sign,
    slide,
    truck,
    turn_between,
)

from artrec_ros.core.base.config import FloorConfig, GuessesConfig, ImageConfig, RecognizerConfig
from artrec_ros.core.base.config import SceneConfig as KnownScene
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import rotation_from_rotvec
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.poses import Poses
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.simulator import pinhole_camera, simulate

CAMERA = camera_of()
EXCAVATOR = Path(__file__).parents[2] / "config" / "objects" / "excavator.yaml"


def recognizer(*targets, **options):
    config = RecognizerConfig(**{"time_budget_ms": 60000.0, **options})
    return Recognizer(targets, config, Segmenter(ImageConfig()))


def found(model, scene, camera=CAMERA, background=BACKGROUND, label=RED):
    """Detections of one model in a picture of (pose of that model) each."""
    labels = render(camera, [(model, at, label) for at in scene], background)
    return recognizer(Target(model.name, model, label)).recognize(labels, camera)


def agrees(model, detection, at, place=0.06, turn_deg=15.0, joint=0.25):
    """Whether a detection lies on a true pose: place as a share of the depth; `joint` of the joints shown (rad)."""
    if np.linalg.norm(detection.pose.position - at.t[0]) > place * at.t[0, 2]:
        return False
    if np.degrees(turn_between(detection.pose.rotation, at.R[0])) > turn_deg:
        return False
    shown = {c.component for c in detection.components}
    for n, c in enumerate(model.joint_components):
        scale = 1.0 if c.joint.kind == "revolute" else 0.1
        if c.name in shown and abs(detection.joints[c.name] - at.q[0, n]) > joint * scale:
            return False
    return True


def assert_found(model, scene, result, **tolerances):
    assert len(result.detections) == len(scene), [r.reason for r in result.rejected]
    for at in scene:
        assert sum(agrees(model, d, at, **tolerances) for d in result.detections) == 1
    assert [d.id for d in result.detections] == list(range(len(scene)))
    for d in result.detections:
        assert d.object == model.name and 0 <= d.score <= 1
        seen = {c.component for c in d.components}
        moving = {c.name for c in model.joint_components}
        assert seen & moving <= set(d.joints) <= moving  # joints of what is in view, and of what carries it
        np.testing.assert_allclose(d.pose.rotation @ d.pose.rotation.T, np.eye(3), atol=1e-6)
        np.testing.assert_allclose(d.pose_covariance, d.pose_covariance.T, atol=1e-12)
        assert np.linalg.eigvalsh(d.pose_covariance).min() > 0


TRUCK = truck()
PAIR = [
    pose(-0.22, 0, 0.9, 0.3, model=TRUCK, joints={"fore": 0.4}),
    pose(0.25, 0.05, 1.1, np.pi + 0.4, model=TRUCK, joints={"hind": -0.5}),
]


@pytest.mark.parametrize("bodies", [True, False])
def test_two_objects_side_by_side_one_from_either_side(bodies):
    model = truck(bodies)
    result = found(model, PAIR)
    assert_found(model, PAIR, result)
    assert result.complete and result.timing_ms["pose"] > 0
    for d in result.detections:  # which flank it is tells where it heads
        right = d.pose.rotation[0, 0] > 0
        assert d.components[0].marker == ("right" if right else "left")
        assert all(c.marker == ("outer_right" if right else "outer_left") for c in d.components[1:])


def test_what_is_reported_of_a_component_is_what_the_image_shows():
    (at,) = scene = [pose(0.05, 0, 0.7, 0.2, model=TRUCK, joints={"fore": 0.4, "hind": -0.3})]
    labels = render(CAMERA, [(TRUCK, at, RED)])
    (d,) = found(TRUCK, scene).detections
    ys, xs = np.nonzero(labels == RED)
    inside = next(c for c in d.components if c.component == "torso")
    assert {c.component for c in d.components} == {"torso", "fore", "hind"}
    assert (d.image.x, d.image.y, d.image.theta) == (inside.x, inside.y, inside.theta)
    for c in d.components:
        assert labels[round(c.y), round(c.x)] == RED
        assert 0.5 < c.score <= 1
        assert c.contour.shape[1] == 2
        assert xs.min() - 3 < c.contour[:, 0].min() and c.contour[:, 1].max() < ys.max() + 3
        assert c.scale == pytest.approx(300 / at.t[0, 2], rel=0.15)


@pytest.mark.parametrize(
    "limits, wanted",
    [({"max_range_m": 1.0}, 0), ({"min_range_m": 1.0}, 1), ({"min_scale": 300.0}, 0), ({"max_scale": 300.0}, 1)],
    ids=str,
)
def test_of_two_objects_the_one_in_reach_is_found(limits, wanted):
    """One at 0.9 m, one at 1.1 m; the other is not made up somewhere in reach."""
    labels = render(CAMERA, [(TRUCK, at, RED) for at in PAIR])
    result = recognizer(Target("truck", TRUCK, RED), **limits).recognize(labels, CAMERA)
    (detection,) = result.detections
    assert agrees(TRUCK, detection, PAIR[wanted])
    assert any(next(iter(limits)) in r.reason for r in result.rejected)


def test_fewer_components_than_wanted_are_no_object():
    labels = render(CAMERA, [(TRUCK, PAIR[0], RED)])
    labels[(labels == RED) & (np.arange(240)[:, None] > 133)] = BODY  # the legs are covered
    engine = [recognizer(Target("truck", TRUCK, RED), min_components=n, min_probability=0.0) for n in (0, 2)]
    alone, none = (e.recognize(labels, CAMERA) for e in engine)
    assert len(alone.detections) == 1 and not none.detections
    assert any("of its components confirmed, 2 are wanted" in r.reason for r in none.rejected)


@pytest.mark.parametrize("lens", [BENT, RATIONAL], ids=len)
def test_a_lens_that_bends_the_image(lens):
    camera = camera_of(distortion=lens)
    scene = [pose(-0.28, 0.15, 0.9, 0.3, model=TRUCK, joints={"fore": 0.4})]
    assert_found(TRUCK, scene, found(TRUCK, scene, camera))


@pytest.mark.parametrize("background", [BACKGROUND, 0])
def test_a_prismatic_joint(background):
    model = slide()
    for shift in (-0.07, 0.06):
        scene = [pose(0, 0, 0.6, 0.5, 0.4, model, {"bar": shift})]
        assert_found(model, scene, found(model, scene, background=background), place=0.09, turn_deg=20)


def test_a_chain_of_joints():
    model = chain()
    scene = [pose(-0.1, 0, 0.6, 0.2, 0, model, {"arm": 0.2, "rod": 0.05, "finger": 0.4})]
    assert_found(model, scene, found(model, scene))


def board(columns=3, rows=4, pitch=0.12):
    """Equal squares in rows, seen from in front."""
    parts = [
        Component(
            f"s{i}{j}",
            (marker("m", rectangle(0.094, 0.094), np.eye(3), (i * pitch, j * pitch, 0)),),
            required=(i, j) == (1, 1),
        )
        for i in range(columns)
        for j in range(rows)
    ]
    return ObjectModel("board", tuple(parts))


@pytest.mark.parametrize("heading, tilt", [(0.1, 0.5), (1.5, 0.3), (-0.7, 0.6)])
def test_of_twelve_equal_squares_one_board_is_told(heading, tilt):
    """Turned by a quarter nine of twelve squares lie on squares: that one was called sure, and the other three another
    board."""
    model = board()
    R = rotation_from_rotvec([0.0, 0.0, heading]) @ rotation_from_rotvec([tilt, 0.0, 0.0]) @ np.diag([1.0, -1.0, -1.0])
    middle = np.array([0.12, 0.18, 0.0])
    at = Poses(R[None], (np.array([0.02, -0.03, 1.1]) - R @ middle)[None], np.zeros((1, 0)))
    (detection,) = found(model, [at], background=0).detections
    assert len(detection.components) == 12 and detection.score > 0.9
    half = np.diag([-1.0, -1.0, 1.0])  # which the squares cannot tell
    assert min(turn_between(detection.pose.rotation @ S, R) for S in (np.eye(3), half)) < 0.05
    np.testing.assert_allclose(detection.pose.apply(middle[None])[0], (0.02, -0.03, 1.1), atol=0.02)


def test_legs_that_another_object_hides_are_not_missing():
    """An object of which another one hides most but the required component is found."""
    near = pose(0.13, 0.1, 0.62, 0.0, model=TRUCK)
    far = pose(0.05, 0.02, 1.0, 0.1, model=TRUCK)
    labels = render(CAMERA, [(TRUCK, near, BLUE), (TRUCK, far, RED)])
    result = recognizer(Target("red", TRUCK, RED), Target("blue", TRUCK, BLUE)).recognize(labels, CAMERA)
    assert sorted(d.object for d in result.detections) == ["blue", "red"]


def test_an_object_of_one_component():
    # turned so far that a flat marker's mirrored turn shows: by 0.3 rad both look alike to half a pixel
    scene = [pose(-0.15, 0, 0.6, 0.4, 0.4), pose(0.15, 0.05, 0.6, -0.5, 2.4)]
    assert_found(sign(), scene, found(sign(), scene), place=0.1, turn_deg=20)


def test_objects_cut_by_the_border_are_found_where_they_are():
    scene = [pose(-0.44, 0, 0.9, 0.2, model=TRUCK, joints={"fore": 0.3})]
    labels = render(CAMERA, [(TRUCK, scene[0], RED)])
    assert (labels[:, 0] != BACKGROUND).any()
    result = found(TRUCK, scene)
    assert_found(TRUCK, scene, result, place=0.1, turn_deg=25, joint=0.5)
    for c in result.detections[0].components:  # the centre of what is seen
        assert -0.5 <= c.x <= 319.5


def test_a_nearer_object_hides_part_of_another():
    scene = [pose(0.0, 0, 0.7, 0.2, model=TRUCK), pose(0.28, 0, 1.0, 0.1, model=TRUCK, joints={"fore": 0.3})]
    result = found(TRUCK, scene)
    assert any(agrees(TRUCK, d, scene[0]) for d in result.detections)
    assert len(result.detections) <= 2


def test_two_teams_are_told_apart_by_their_class_alone():
    labels = render(CAMERA, [(TRUCK, PAIR[0], RED), (TRUCK, PAIR[1], BLUE)])
    result = recognizer(Target("red", TRUCK, RED), Target("blue", TRUCK, BLUE)).recognize(labels, CAMERA)
    assert [(d.object, d.id) for d in result.detections] == [("red", 0), ("blue", 0)]
    for d, at in zip(result.detections, PAIR, strict=True):
        assert agrees(TRUCK, d, at)


def test_the_shipped_excavator_in_simulated_scenes():
    model = load_object(EXCAVATOR, None)
    target = Target("excavator", model, BLUE)
    engine = recognizer(target)
    clean = SensorConfig().scaled(0)
    close = SceneConfig(size=(0.45, 0.6), distractors=2)
    wanted = right = invented = 0
    for frame in simulate([target], pinhole_camera((200, 150), 60), close, clean, seed=3, frames=2):
        detections = engine.recognize(frame.labels, frame.camera).detections
        poses = [t.placed.T_camera_object for t in frame.truths]
        wanted += len(poses)
        near = [
            any(
                np.linalg.norm(d.pose.position - T.position) < 0.1 * T.position[2]
                and turn_between(d.pose.rotation, T.rotation) < 0.4
                for d in detections
            )
            for T in poses
        ]
        right += sum(near)
        invented += max(0, len(detections) - len(poses))
    assert wanted == 2 and right >= 1 and invented == 0


def test_the_same_image_gives_the_same_answer():
    model = slide()
    scene = [pose(0, 0, 0.6, 0.5, 0.4, model, {"bar": 0.03})]
    first, again = found(model, scene), found(model, scene)
    np.testing.assert_array_equal(first.detections[0].pose.position, again.detections[0].pose.position)
    assert first.detections[0].score == again.detections[0].score


@pytest.mark.parametrize("value", [0, BACKGROUND, RED, BODY])
def test_plain_images_hold_nothing(value):
    result = recognizer(Target("truck", TRUCK, RED)).recognize(np.full((60, 80), value, np.uint8), CAMERA)
    assert result.detections == () and result.complete


@pytest.mark.parametrize("share", [0.05, 0.1])
def test_noise_holds_nothing(share):
    engine = recognizer(Target("truck", TRUCK, RED), Target("slide", slide(), BLUE))
    rest = (1 - 2 * share) / 3
    labels = np.random.default_rng(0).choice(
        [0, BACKGROUND, BODY, BLUE, RED], (96, 128), p=[rest, rest, rest, share, share]
    )
    result = engine.recognize(labels.astype(np.uint8), camera_of((128, 96), 120.0))
    assert result.detections == ()
    assert all(r.reason and "\n" not in r.reason for r in result.rejected)


def test_a_lone_patch_is_rejected_with_the_component_that_came_nearest():
    labels = render(CAMERA, [(sign(), pose(0, 0, 0.7, 0.2), RED)])
    result = recognizer(Target("truck", truck(bodies=False), RED)).recognize(labels, CAMERA)
    assert result.detections == ()
    reasons = [r.reason for r in result.rejected]
    assert reasons and all("fore" in r or "hind" in r for r in reasons)
    assert all(r.object == "truck" and 0 <= r.score < 0.5 for r in result.rejected)


@pytest.mark.parametrize("shape", [(1, 1), (3, 400), (17, 2)])
def test_tiny_images(shape):
    engine = recognizer(Target("truck", TRUCK, RED))
    for value in (RED, BACKGROUND):
        result = engine.recognize(np.full(shape, value, np.uint8), CAMERA)
        assert result.size == shape[::-1]
        assert result.detections == ()


def test_a_spent_budget_ends_the_search_and_says_so():
    labels = render(CAMERA, [(TRUCK, at, RED) for at in PAIR])
    engine = recognizer(Target("truck", TRUCK, RED), time_budget_ms=1.0)
    result = engine.recognize(labels, CAMERA)
    assert result.ended_by == ("recognizer.time_budget_ms",) and not result.complete
    for d in result.detections:
        assert d.pose is not None


def test_without_calibration_there_are_no_poses_in_space():
    labels = render(CAMERA, [(TRUCK, PAIR[0], RED)])
    result = recognizer(Target("truck", TRUCK, RED)).recognize(labels)
    assert all(d.pose is None and d.pose_covariance is None for d in result.detections)


def test_a_camera_of_another_size_still_gives_an_answer():
    """CameraInfo and image may disagree; the image's own size counts."""
    camera = Camera(CAMERA.matrix, CAMERA.distortion, (640, 480))
    labels = render(CAMERA, [(TRUCK, PAIR[0], RED)])
    result = recognizer(Target("truck", TRUCK, RED)).recognize(labels, camera)
    assert result.size == (320, 240)
    assert agrees(TRUCK, result.detections[0], PAIR[0])


def test_what_does_not_stand_on_the_floor_is_no_object():
    """Of two alike one hangs in the air, another leans: without a floor all are found, with it the one that stands."""
    scene = [
        pose(-0.25, 0.15, 1.0, 0.3, model=TRUCK),
        pose(0.25, -0.2, 1.0, 0.3, model=TRUCK),
        pose(0.1, 0.15, 1.3, 0.3, 0.7, model=TRUCK),
    ]
    labels = render(CAMERA, [(TRUCK, at, RED) for at in scene])
    target = Target(TRUCK.name, TRUCK, RED)
    assert len(recognizer(target).recognize(labels, CAMERA).detections) == 3
    floor = FloorConfig(camera_height_m=0.3, object_height_m=0.15, height_tolerance_m=0.1)
    result = recognizer(target, scene=KnownScene(floor=floor)).recognize(labels, CAMERA)
    assert_found(TRUCK, scene[:1], result)
    strict = recognizer(target, scene=KnownScene(floor=floor), guesses=GuessesConfig(standing_slack=100.0))
    reasons = [r.reason for r in strict.recognize(labels, CAMERA).rejected]
    assert any("m above the floor, not 0.15 m" in r for r in reasons) and any("leans by" in r for r in reasons)
