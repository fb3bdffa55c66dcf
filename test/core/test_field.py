"""Flat robots on a field that is seen at a slant, found in rendered label images: where they are told to be."""

from __future__ import annotations

from dataclasses import replace

import fields
import numpy as np
import pytest

from artrec_ros.core.base.config import ImageConfig, PlaneConfig, RecognizerConfig, SceneConfig
from artrec_ros.core.constraints.constraint_set import ConstraintSet
from artrec_ros.core.constraints.intervals import Interval
from artrec_ros.core.constraints.pairs import PairConstraint
from artrec_ros.core.facing_stage import FacingStage
from artrec_ros.core.geometry.scene import Scene
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.found import Detection
from artrec_ros.core.model.frame_result import FrameResult
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.ways import FACING, PLANE, SPACE, all_on_plane, way_of

LENS = (-0.25, 0.08, 0.0, 0.0)
SIDE = 0.04  # 18 px
GRID = np.array([(x, y) for x in (0.1, 0.5, 0.9) for y in (0.1, 0.4, 0.7)])


def robots(seed: int) -> np.ndarray:
    """(9, 3) x, y, yaw."""
    rng = np.random.default_rng(seed)
    return np.column_stack([GRID + rng.uniform(-0.03, 0.03, GRID.shape), rng.uniform(-np.pi, np.pi, len(GRID))])


def target(*, placed: bool = True, above: float = 0.0) -> Target:
    """:param placed: markers have places: it is found as a whole; else by constraints. :param above: the frame."""
    model = fields.robot(SIDE, placed=placed, above=above)
    apart = {"distance_m": Interval(0.04, 0.075)}
    pair = PairConstraint(("team", "patch"), ("accent", "patch"), 9, apart, apart)
    return Target("robot", model, fields.TEAM, None if placed else ConstraintSet(model.name, 0.95, (pair,)))


def found(
    labels: np.ndarray, scene: SceneConfig, camera: object = None, *, placed: bool = True, above: float = 0.0
) -> FrameResult:
    config = RecognizerConfig(scene=scene)
    segmenter = Segmenter(ImageConfig(kind="labels"))
    recognizer = Recognizer((target(placed=placed, above=above),), config, segmenter, calibrated=camera is not None)
    return recognizer.recognize(labels, camera)


def errors(detections: tuple[Detection, ...], truth: np.ndarray, at: tuple[float, float] = (0, 0)) -> np.ndarray:
    """(n, 3) of x, y, yaw. :param at: of the frame that is told, in the robot's."""
    out = []
    for d in detections:
        R, place = d.pose.rotation, d.pose.position
        c, s = np.cos(truth[:, 2]), np.sin(truth[:, 2])
        true = truth[:, :2] + np.stack([c * at[0] - s * at[1], s * at[0] + c * at[1]], axis=1)
        nearest = int(np.argmin(np.linalg.norm(true - place[:2], axis=1)))
        yaw = np.arctan2(R[1, 0], R[0, 0]) - truth[nearest, 2]
        out.append([*(place[:2] - true[nearest]), (yaw + np.pi) % (2 * np.pi) - np.pi])
    return np.array(out)


@pytest.mark.parametrize(
    ("slant", "bend", "degrees"),
    [(0.0, (), 1.2), (20.0, (), 2.0), (20.0, LENS, 2.0), (55.0, (), 2.0), (55.0, LENS, 2.0)],
)
def test_whole_robots_are_placed_to_a_millimetre(slant: float, bend: tuple[float, ...], degrees: float) -> None:
    camera, truth = fields.camera(bend=bend), robots(3)
    scene = SceneConfig(plane=fields.plane(camera, slant))
    result = found(fields.render(camera, slant, SIDE, truth), scene, camera if bend else None)
    assert len(result.detections) == len(truth)
    off = errors(result.detections, truth)
    assert np.linalg.norm(off[:, :2], axis=1).max() < 1.3e-3
    assert np.median(np.linalg.norm(off[:, :2], axis=1)) < 0.45e-3
    assert np.degrees(np.abs(off[:, 2])).max() < degrees
    assert np.degrees(np.median(np.abs(off[:, 2]))) < degrees / 2
    for d in result.detections:
        assert (d.frame_id, d.pose_from) == ("field", "plane")
        assert d.pose.position[2] == pytest.approx(0, abs=1e-6)
        np.testing.assert_allclose(d.pose.rotation[2], (0, 0, 1), atol=1e-6)  # upright


@pytest.mark.parametrize(("larger", "placed"), [(1.0, True), (1.25, True), (1.25, False)])
def test_how_large_robots_look_on_the_plane_is_told(larger: float, placed: bool) -> None:
    camera, truth = fields.camera(), robots(3)
    exact = fields.plane(camera, 20.0)
    plane = replace(exact, field_points=tuple(larger * value for value in exact.field_points))
    result = found(fields.render(camera, 20.0, SIDE, truth), SceneConfig(plane=plane), placed=placed)
    assert len(result.detections) >= len(truth) - 1
    assert [d.plane_scale for d in result.detections] == pytest.approx([larger] * len(result.detections), rel=0.05)


def test_robots_by_constraints_are_placed_by_their_required_marker() -> None:
    camera, truth = fields.camera(), robots(4)
    scene = SceneConfig(plane=fields.plane(camera, 20.0, frame_id="hall"))
    result = found(fields.render(camera, 20.0, SIDE, truth), scene, placed=False)
    assert len(result.detections) >= len(truth) - 1
    off = errors(result.detections, truth, at=(-SIDE / 2, -SIDE / 2))
    assert np.linalg.norm(off[:, :2], axis=1).max() < 2e-3
    assert {(d.frame_id, d.pose_from) for d in result.detections} == {("hall", "plane")}
    quarter = (off[:, 2] + np.pi / 4) % (np.pi / 2) - np.pi / 4  # a square's direction is known by quarters
    assert np.degrees(np.abs(quarter)).max() < 6


def test_covariance_is_as_large_as_the_errors() -> None:
    """Points that are off by half a pixel, over many draws: squared errors are what is told of them."""
    camera, slant, rng = fields.camera(), 20.0, np.random.default_rng(11)
    truth = robots(5)
    labels = fields.render(camera, slant, SIDE, truth)
    exact = fields.plane(camera, slant)
    ratios = []
    for _ in range(6):
        pixels = np.array(exact.image_points) + rng.normal(0, 0.5, 8)
        result = found(labels, SceneConfig(plane=PlaneConfig(tuple(pixels), exact.field_points)))
        off = errors(result.detections, truth)
        for error, d in zip(off, result.detections, strict=True):
            C = d.pose_covariance
            np.testing.assert_allclose(C, C.T)
            assert np.linalg.eigvalsh(C).min() > 0
            mine = C[np.ix_([0, 1, 5], [0, 1, 5])]
            ratios.append(error @ np.linalg.solve(mine, error) / 3)
    assert 0.15 < np.mean(ratios) < 1.5


def test_how_sure_a_place_is_does_not_depend_on_how_high_the_markers_are() -> None:
    """How the object is tilted is not known, but its markers lie on the plane wherever their frame is."""
    camera, truth = fields.camera(), robots(5)
    scene = SceneConfig(plane=fields.plane(camera, 20.0))
    told = []
    for above in (0.0, 0.1):
        result = found(fields.render(camera, 20.0, SIDE, truth), scene, above=above)
        told.append(
            {int(np.argmin(np.abs(truth[:, :2] - d.pose.position[:2]).sum(axis=1))): d for d in result.detections}
        )
    assert len(told[0]) == len(told[1]) == len(truth)
    for n, low in told[0].items():
        high = told[1][n]
        np.testing.assert_allclose(high.pose.position, low.pose.position - (0, 0, 0.1), atol=1e-3)
        deviations = [np.sqrt(np.diag(d.pose_covariance)) for d in (low, high)]
        assert (deviations[1] / deviations[0]).min() > 0.5 and (deviations[1] / deviations[0]).max() < 2
        assert deviations[0][:2].max() < 2e-3


def test_outside_of_the_region_nothing_is_looked_for() -> None:
    camera, truth = fields.camera(), robots(6)
    corners = fields.seen(camera, 20.0, np.array([[-0.1, -0.1], [0.7, -0.1], [0.7, 0.9], [-0.1, 0.9]]))
    labels = fields.render(camera, 20.0, SIDE, truth)
    for placed in (True, False):
        result = found(labels, SceneConfig(region=tuple(corners.ravel())), placed=placed)
        assert len(result.detections) == 6
        assert all(d.pose is None for d in result.detections)  # a region is no plane
        assert sorted(d.id for d in result.detections) == list(range(6))


def test_a_robot_to_which_a_blob_in_the_region_leads_is_refused_with_the_reason() -> None:
    """Whatever made it a candidate: here blobs outside of the region, which the recogniser leaves out, are kept."""
    camera, config = fields.camera(), RecognizerConfig()
    labels = fields.render(camera, 0.0, SIDE, np.array([[0.5, 0.4, 0.0], [0.3, 0.4, np.pi]]))
    border = fields.seen(camera, 0.0, np.array([[0.4, 0.4]]))[0, 0]
    region = SceneConfig(region=(border, 0.0, 640.0, 0.0, 640.0, 480.0, border, 480.0))
    blobs = find_blobs(labels, {fields.TEAM}, config)
    frame = ImageFrame(LabelField(labels), scene=Scene.of(region, None))
    seen = FacingStage((target(),), config).recognize(frame, blobs)
    assert len(seen.detections) == 1 and seen.detections[0].image.x > border
    assert any(r.reason == "outside scene.region" and r.x < border for r in seen.rejected)


@pytest.mark.parametrize("placed", [True, False])
def test_what_has_not_the_planes_scale_is_refused_with_the_reason(placed: bool) -> None:
    """One robot is half as large again as the others: nearer to the camera, or a toy."""
    camera, truth = fields.camera(), robots(8)
    labels = fields.render(camera, 0.0, SIDE, truth[1:])
    large = fields.render(camera, 0.0, 1.6 * SIDE, truth[:1])
    labels[large > 0] = large[large > 0]
    assert len(found(labels, SceneConfig(), placed=placed).detections) == 9
    result = found(labels, SceneConfig(plane=fields.plane(camera, 0.0, scale_tolerance=0.2)), placed=placed)
    assert len(result.detections) == 8
    off = np.linalg.norm([np.subtract((d.image.x, d.image.y), fields.seen(camera, 0.0, truth[:1, :2])[0])
                          for d in result.detections], axis=1)  # fmt: skip
    assert off.min() > 50


def test_the_way_of_flat_objects_is_that_of_the_plane_where_it_is_known() -> None:
    known = RecognizerConfig(scene=SceneConfig(plane=fields.plane(fields.camera(), 20.0)))
    whole, parts = target(), target(placed=False)
    assert way_of(whole, RecognizerConfig(), calibrated=True) == SPACE
    assert way_of(whole, RecognizerConfig(), calibrated=False) == FACING
    assert [way_of(whole, known, calibrated=c) for c in (True, False)] == [FACING, FACING]
    assert way_of(parts, known, calibrated=True) == PLANE
    assert all_on_plane((whole, parts), known) and not all_on_plane((whole, parts), RecognizerConfig())
    assert way_of(whole, replace(known, whole_object=False), calibrated=True) == PLANE


@pytest.mark.parametrize("bend", [(), LENS])
def test_what_is_told_in_pixels_is_the_images_however_the_plane_is_seen(bend: tuple[float, ...]) -> None:
    """Place, direction, size and outlines of the required square of robots at a slant of 50 degrees."""
    camera, truth, slant = fields.camera(bend=bend), robots(5), 50.0
    scene = SceneConfig(plane=fields.plane(camera, slant))
    result = found(fields.render(camera, slant, SIDE, truth), scene, camera if bend else None)
    assert len(result.detections) == len(truth)
    turn = np.stack([np.cos(truth[:, 2]), np.sin(truth[:, 2])], axis=1)
    across = np.stack([-turn[:, 1], turn[:, 0]], axis=1)
    middles = truth[:, :2] - SIDE / 2 * (turn + across)
    at = fields.seen(camera, slant, middles)
    ahead = fields.seen(camera, slant, middles + 1e-3 * turn) - at
    aside = fields.seen(camera, slant, middles + 1e-3 * across) - at
    scales = 1e3 * np.sqrt(np.abs(ahead[:, 0] * aside[:, 1] - ahead[:, 1] * aside[:, 0]))
    for d in result.detections:
        off = np.linalg.norm(at - (d.image.x, d.image.y), axis=1)
        n = int(off.argmin())
        assert off[n] < 1.0
        assert abs(np.angle(np.exp(1j * (d.image.theta - np.arctan2(ahead[n, 1], ahead[n, 0]))))) < 0.06
        assert d.image.scale == pytest.approx(scales[n], rel=0.06)
        corners = [middles[n] + SIDE / 2 * (a * turn[n] + b * across[n]) for a in (-1, 1) for b in (-1, 1)]
        outline = d.components[0].contour
        for corner in fields.seen(camera, slant, np.array(corners)):
            assert np.linalg.norm(outline - corner, axis=1).min() < 2.0


def test_what_is_turned_down_is_told_where_the_image_has_it() -> None:
    camera, slant = fields.camera(), 45.0
    scene = SceneConfig(plane=fields.plane(camera, slant))
    truth = np.array([[0.4, 0.3, 1.0]])
    (rejected, *_) = found(fields.render(camera, slant, 2 * SIDE, truth), scene).rejected
    at = fields.seen(camera, slant, truth[:, :2])[0]
    assert np.linalg.norm(at - (rejected.x, rejected.y)) < 2 * SIDE * 450


def test_limits_of_the_scale_are_those_of_the_image_on_a_plane_too() -> None:
    """At 45 degrees the field has 320 to 500 px/m: what is nearer and larger than 420 is out of the limits."""
    camera, truth, slant = fields.camera(), robots(5), 45.0
    scene = SceneConfig(plane=fields.plane(camera, slant))
    labels = fields.render(camera, slant, SIDE, truth)
    segmenter = Segmenter(ImageConfig(kind="labels"))
    all_of_them = found(labels, scene).detections
    assert len(all_of_them) == len(truth)
    config = RecognizerConfig(scene=scene, max_scale=420.0)
    small = Recognizer((target(),), config, segmenter, calibrated=False).recognize(labels)
    assert 0 < len(small.detections) < len(truth)
    assert all(d.image.scale <= 420 for d in small.detections)
    assert len(small.detections) >= sum(d.image.scale < 410 for d in all_of_them)


def test_another_size_of_images_and_a_changed_scene_have_views_of_their_own() -> None:
    camera, truth, slant = fields.camera(), robots(5), 45.0
    scene = SceneConfig(plane=fields.plane(camera, slant))
    labels = fields.render(camera, slant, SIDE, truth)
    recognizer = Recognizer((target(),), RecognizerConfig(scene=scene), Segmenter(ImageConfig()), calibrated=False)
    assert len(recognizer.recognize(labels).detections) == len(truth)
    cut = recognizer.recognize(np.ascontiguousarray(labels[:, :420])).detections
    assert 0 < len(cut) < len(truth)
    assert len(recognizer.recognize(labels).detections) == len(truth)
    tiny = recognizer.recognize(np.zeros((1, 1), np.uint8))
    assert tiny.detections == ()
