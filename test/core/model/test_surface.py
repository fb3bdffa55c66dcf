"""Sample points of markers and box faces: where they lie, how evenly, and what they stand for."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
import squares
from solids import BODY, CAB, FRONT, RED, marker, rectangle, sign, truck

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.objects import Box, Component, ObjectModel
from artrec_ros.core.model.stacked import stacks_of
from artrec_ros.core.model.surface import (
    CONTOUR_POINTS,
    contains,
    free_contour,
    patches_of,
    sample_contour,
    sample_polygon,
)

TURN = np.radians(np.arange(64) * 360 / 64)
DISC = 0.03 * np.column_stack([np.cos(TURN), np.sin(TURN)])
COMB = np.array([(0, 0), (7, 0), (7, 3), (6, 3), (6, 1), (4, 1), (4, 3), (3, 3), (3, 1), (1, 1), (1, 3), (0, 3)], float)
THIN = np.array([(0, 0), (1, 1), (1, 1.04), (0, 0.04)])
OUTLINES = {"cab": CAB, "disc": DISC, "comb": COMB, "thin": THIN, "backwards": CAB[::-1]}
each_outline = pytest.mark.parametrize("outline", OUTLINES.values(), ids=OUTLINES)


def area(outline):
    return cv2.contourArea((outline * 1000).astype(np.float32)) / 1e6


@each_outline
def test_inside_is_what_opencv_says(outline):
    rng = np.random.default_rng(0)
    points = rng.uniform(outline.min(axis=0) - 0.01, outline.max(axis=0) + 0.01, (300, 2))
    polygon = (outline * 1000).astype(np.float32)
    theirs = [cv2.pointPolygonTest(polygon, (float(x) * 1000, float(y) * 1000), False) > 0 for x, y in points]
    assert np.mean(contains(outline, points) == theirs) > 0.995  # float32 there


@each_outline
@pytest.mark.parametrize("n", [20, 36])
def test_points_of_a_polygon_lie_in_it_and_fill_it_evenly(outline, n):
    points = sample_polygon(outline, n)
    assert points.shape == (n, 2)
    assert contains(outline, points).all()
    np.testing.assert_array_equal(points, sample_polygon(outline, n))
    for direction in np.radians((0, 45, 90, 135)):
        across = np.array([np.cos(direction), np.sin(direction)])
        many = sample_polygon(outline, 4000) @ across
        for share in (0.25, 0.5, 0.75):  # of the area lies below this line
            assert abs(np.mean(points @ across < np.quantile(many, share)) - share) <= 0.17


def test_many_points_measure_areas():
    points = sample_polygon(COMB, 4000)
    tooth = (points[:, 1] > 1) & (points[:, 0] < 1)
    assert tooth.mean() == pytest.approx(2 / 13, abs=0.01)


def test_points_reach_the_border_of_the_polygon():
    """A model that outgrows its blob must have points that tell."""
    points = sample_polygon(rectangle(2, 2), 36)
    assert np.abs(points).max() > 0.95


@each_outline
def test_a_contours_points_are_evenly_spaced_on_it_and_normals_point_out(outline):
    n = 48
    points, normals = sample_contour(outline, n)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=1), 1.0)
    eps = 1e-6
    assert contains(outline, points - eps * normals).all()
    assert not contains(outline, points + eps * normals).any()
    edges = np.linalg.norm(np.roll(outline, -1, axis=0) - outline, axis=1)
    spacing = edges.sum() / n
    chord = np.linalg.norm(np.roll(points, -1, axis=0) - points, axis=1)
    assert (chord <= spacing * (1 + 1e-9)).all()  # a chord is no longer than the arc
    assert np.mean(chord > spacing * 0.99) > 0.5


def test_a_repeated_corner_changes_nothing():
    doubled = np.insert(CAB, 2, CAB[2], axis=0)
    for got, wanted in zip(sample_contour(doubled, 32), sample_contour(CAB, 32), strict=True):
        np.testing.assert_allclose(got, wanted, atol=1e-12)


def test_markers_patches_lie_in_their_planes():
    model = truck(bodies=False)
    patches = patches_of(model, RED)
    assert [(p.component, p.marker.name) for p in patches] == [
        (c, m.name) for c, component in enumerate(model.components) for m in component.markers
    ]
    for p in patches:
        T = p.marker.T_component_marker
        np.testing.assert_allclose(p.normal, T.rotation[:, 2])
        for points in (p.inside, p.contour):
            np.testing.assert_allclose((points - T.position) @ p.normal, 0, atol=1e-12)
        np.testing.assert_allclose(p.contour_along @ p.normal, 0, atol=1e-12)
        np.testing.assert_allclose(np.linalg.norm(p.contour_along, axis=1), 1.0)
        outwards = T.rotation.T @ np.cross(p.contour_along, p.normal).T
        assert not contains(p.marker.outline, (T.inverse().apply(p.contour).T + 1e-6 * outwards)[:2].T).any()
        assert contains(p.marker.outline, T.inverse().apply(p.inside)[:, :2]).all()
        assert p.area == pytest.approx(area(p.marker.outline), rel=1e-3)
        assert p.labels == (RED,)


def test_labels_are_the_components_own_the_objects_or_unknown():
    plain = sign().components[0]
    box = (Box(Pose.identity(), np.ones(3)),)
    parts = (
        Component("a", plain.markers, required=True, bodies=box, body_label=BODY),
        Component("b", plain.markers, label=7, bodies=box),
    )
    patches = patches_of(ObjectModel("pair", parts), RED)
    found = {(p.component, p.marker is not None): p.labels for p in patches}
    assert found == {(0, True): (RED,), (0, False): (BODY,), (1, True): (7,), (1, False): ()}


def test_a_boxs_faces_are_its_six_sides():
    size, T = np.array([0.3, 0.2, 0.1]), Pose.from_xyz_rpy((0.5, -0.2, 0.1), (0.3, 0.8, -0.4))
    plate = sign().components[0].markers
    model = ObjectModel("box", (Component("a", plate, required=True, bodies=(Box(T, size),), body_label=BODY),))
    faces = [p for p in patches_of(model, RED) if p.marker is None]
    assert len(faces) == 6
    assert sum(p.area for p in faces) == pytest.approx(2 * (0.06 + 0.03 + 0.02))
    np.testing.assert_allclose(sum(p.normal * p.area for p in faces), 0, atol=1e-12)
    for p in faces:
        local = T.inverse().apply(p.inside) / (size / 2)
        np.testing.assert_allclose(np.abs(local).max(axis=1), 1.0)
        assert (p.inside - T.position) @ p.normal == pytest.approx(size / 2 @ np.abs(T.rotation.T @ p.normal))
        assert p.area == pytest.approx(float(np.prod(size) / (size @ np.abs(T.rotation.T @ p.normal))))


def test_a_face_under_a_marker_shows_only_what_is_left():
    def faces(outline, gap):
        patch = marker("patch", outline, FRONT, (0.05 + gap, 0, 0))
        body = (Box(Pose.identity(), np.full(3, 0.1)),)
        model = ObjectModel("box", (Component("a", (patch,), required=True, bodies=body, body_label=BODY),))
        return [p for p in patches_of(model, RED) if p.marker is None]

    front = next(p for p in faces(rectangle(0.05, 0.1, (0.025, 0)), 0.001) if p.normal[0] > 0.9)
    assert front.area == pytest.approx(0.005, rel=0.15)  # the half that is bare
    assert (front.inside[:, 1] < 0).all()
    assert len(faces(rectangle(0.2, 0.2), 0.001)) == 5  # nothing of the front is left
    assert len(faces(rectangle(0.2, 0.2), 0.1)) == 6  # far in front of it: hidden() decides
    assert len(faces(rectangle(0.2, 0.2), -0.01)) == 6  # inside of the box


def ring_of(model, label=RED):
    """Marker name -> (m, 2) its contour's points in the plane of z = 0 and which of them are open."""
    patches = patches_of(model, label)
    markers = [p for p in patches if p.marker is not None]
    out = free_contour(model, patches, stacks_of(patches), own_class=True)
    assert out.shape == (len(markers), CONTOUR_POINTS) and out.dtype == bool
    return {p.marker.name: (p.contour[:, :2], row) for p, row in zip(markers, out, strict=True)}


@pytest.mark.parametrize("shared", [True, False])
def test_where_another_marker_that_may_be_alike_begins_the_ring_says_nothing(shared):
    """Left and right of a robot meet along its middle line; the team's patch meets both, in another class."""
    robots = squares.robot() if shared else squares.robot(alternatives=False)
    found = ring_of(robots, squares.TEAM)
    for name in ("left", "right"):
        points, is_open = found[name]
        middle = np.abs(points[:, 1]) < 1e-9
        inner = middle & (points[:, 0] > 0.004) & (points[:, 0] < 0.033)
        assert inner.sum() >= 5 and (is_open[inner] == (not shared)).all()
        assert is_open[~middle].all()
    assert found["back"][1].all()


def test_markers_that_move_or_lie_apart_or_below_leave_rings_open():
    team, left, right = squares.robot().components
    joint = squares.hinge("team", (0, 0, 0), (0, 0, 1))
    swings = ObjectModel("robot", (team, left, replace(right, joint=joint)))
    lower = squares.patch("right", squares.RIGHT, Pose(np.eye(3), np.array([0, 0, -0.02])))
    sunk = ObjectModel("robot", (team, left, replace(right, markers=(lower,))))
    far = squares.patch("right", squares.RIGHT - (0, 0.02))
    apart = ObjectModel("robot", (team, left, replace(right, markers=(far,))))
    for model in (swings, sunk, apart):
        assert all(is_open.all() for _, is_open in ring_of(model, squares.TEAM).values())


def test_where_any_other_marker_begins_the_contour_is_not_free():
    """Of whichever class: what colours lie around an object begins beyond all of its markers."""
    model = squares.robot()
    patches = patches_of(model, 1)
    alike, any_class = (free_contour(model, patches, stacks_of(patches), own_class=own) for own in (True, False))
    assert (any_class <= alike).all() and any_class.sum() < alike.sum()
    assert any_class.any(axis=1).all()  # each part has an outer side
