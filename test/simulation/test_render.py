import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.projection import project
from artrec_ros.simulation.render import FLOOR, NOTHING, SUPERSAMPLING, Renderer, polygon_mask, to_pixel
from artrec_ros.simulation.scene import Floor, Scene
from artrec_ros.simulation.surfaces import Surface

TOWARDS = np.array([0.0, 0.0, -1.0])


def plate(x, y, z, side, label):
    corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * side / 2 + (x, y)
    return Surface(np.column_stack([corners, np.full(4, z)]), TOWARDS, label)


def render(camera, *surfaces, floor=None):
    return Renderer(camera).render(Scene((), surfaces, floor))


def test_polygon_mask_covers_the_points_inside():
    mask = polygon_mask(np.array([[0.5, 0.5], [3.5, 0.5], [3.5, 2.5], [0.5, 2.5]]), (5, 6))
    assert np.argwhere(mask).tolist() == [[1, 1], [1, 2], [1, 3], [2, 1], [2, 2], [2, 3]]


def test_polygon_mask_of_a_concave_polygon_leaves_its_notch_free():
    notched = np.array([[0, 0], [20, 0], [20, 20], [12, 20], [12, 10], [8, 10], [8, 20], [0, 20]]) + 0.25
    mask = polygon_mask(notched, (24, 24))
    assert not mask[15, 10] and mask[15, 4] and mask[15, 16] and mask[5, 10]


@settings(deadline=None)
@given(st.tuples(st.floats(2, 58), st.floats(2, 38)))
def test_neighbouring_polygons_share_no_point_and_leave_none(centre):
    """A rectangle cut from an inner point to its corners: every point belongs to exactly one part."""
    frame = np.array([[0.3, 0.3], [59.7, 0.3], [59.7, 39.7], [0.3, 39.7]])
    parts = [np.array([frame[i], frame[(i + 1) % 4], np.array(centre)]) for i in range(4)]
    total = sum(polygon_mask(p, (40, 60)).astype(int) for p in parts)
    assert np.array_equal(total, polygon_mask(frame, (40, 60)).astype(int))


def test_a_polygon_partly_outside_is_cut():
    assert polygon_mask(np.array([[-5.0, -5], [50, -5], [50, 50], [-5, 50]]), (7, 9)).all()


def test_area_and_centre_follow_the_pinhole_model(camera):
    rendering = render(camera, plate(0.03, -0.02, 0.8, 0.2, 3))
    rows, columns = np.nonzero(rendering.index == 0)
    focal = camera.matrix[0, 0]
    assert len(rows) / SUPERSAMPLING**2 == pytest.approx((focal * 0.2 / 0.8) ** 2, rel=0.02)
    centre = project(camera, np.array([0.03, -0.02, 0.8]))
    np.testing.assert_allclose((to_pixel(columns).mean(), to_pixel(rows).mean()), centre, atol=0.2)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_nearer_surface_shows_whatever_the_order(camera, order):
    surfaces = [plate(0, 0, 1.0, 0.2, 3), plate(0.05, 0, 2.0, 0.4, 4)]
    labels = render(camera, *[surfaces[i] for i in order]).sample_labels
    row = labels.shape[0] // 2
    assert labels[row, labels.shape[1] // 2] == 3
    assert set(np.unique(labels)) == {0, 3, 4}


def test_surfaces_that_cross_each_show_on_their_side(camera):
    """Painting whole polygons in the order of their depth would get this wrong."""
    tilted = np.array([[-0.2, -0.1, 0.9], [0.2, -0.1, 1.1], [0.2, 0.1, 1.1], [-0.2, 0.1, 0.9]])
    normal = np.array([0.2, 0, -0.4]) / np.hypot(0.2, 0.4)
    labels = render(camera, plate(0, 0, 1.0, 0.4, 3), Surface(tilted, normal, 4)).sample_labels
    row, middle = labels.shape[0] // 2, labels.shape[1] // 2
    assert labels[row, middle - 20] == 4 and labels[row, middle + 20] == 3


def test_the_floor_ends_at_the_horizon(camera):
    rendering = render(camera, floor=Floor(np.array([0, -1.0, 0]), -0.3, 1))
    height = rendering.index.shape[0]
    assert (rendering.index[: height // 2] == NOTHING).all() and (rendering.index[height // 2 + 1 :] == FLOOR).all()
    assert rendering.sample_labels[-1, 0] == 1 and rendering.sample_labels[0, 0] == 0


def test_an_empty_scene_shows_nothing(camera):
    assert (render(camera).sample_labels == 0).all()


def test_lens_distortion_moves_what_is_seen(camera):
    bent = Camera(camera.matrix, np.array([-0.3, 0.05, 0, 0, 0]), camera.size)
    rendering = render(bent, plate(0.25, 0.2, 0.7, 0.04, 3))
    rows, columns = np.nonzero(rendering.index == 0)
    expected = project(bent, np.array([0.25, 0.2, 0.7]))
    np.testing.assert_allclose((to_pixel(columns).mean(), to_pixel(rows).mean()), expected, atol=0.3)
    assert np.linalg.norm(expected - project(camera, np.array([0.25, 0.2, 0.7]))) > 2
