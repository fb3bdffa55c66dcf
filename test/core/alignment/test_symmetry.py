import numpy as np
import pytest
from scene import capsule, disc, flag, polygon, rectangle

from artrec_ros.core.alignment.shapes import SAMPLES, Shape
from artrec_ros.core.alignment.symmetry import ANY_ANGLE
from artrec_ros.core.geometry.polygons import distance_to_outline


def regular(sides):
    a = 2 * np.pi * np.arange(sides) / sides
    return polygon("regular", *zip(np.cos(a), np.sin(a), strict=True))


@pytest.mark.parametrize(
    ("marker", "order"),
    [
        (flag(), 1),
        (rectangle("bar", 1.0, 0.3), 2),
        (capsule("link", 0.1, 0.7), 2),
        (rectangle("square", 1.0, 1.0), 4),
        (regular(3), 3),
        (regular(5), 5),
        (regular(6), 6),
        (disc("sticker", 0.5), ANY_ANGLE),
    ],
)
def test_order_is_found_from_the_outline(marker, order):
    assert Shape.from_marker(marker).symmetry.order(100.0, 0.3) == order


def test_symmetry_depends_on_scale():
    nearly_square = Shape.from_marker(rectangle("patch", 1.0, 0.95)).symmetry
    assert nearly_square.order(6.0, 0.3) == 4
    assert nearly_square.order(100.0, 0.3) == 2
    polygon_of_12 = Shape.from_marker(regular(12)).symmetry
    assert polygon_of_12.order(5.0, 0.3) == ANY_ANGLE
    assert polygon_of_12.order(1000.0, 0.3) == 12


def test_distance_to_outline_is_exact():
    square = np.array([(0, 0), (2, 0), (2, 2), (0, 2)], float)
    points = np.array([(1, 1), (1, 0), (3, 1), (3, 3)], float)
    np.testing.assert_allclose(distance_to_outline(points, square), [1, 0, 1, np.sqrt(2)])


@pytest.mark.parametrize("reverse", [False, True])
def test_shape_samples_run_evenly_the_same_way_round(reverse):
    marker = flag()
    if reverse:
        marker = polygon("flag", *marker.outline[::-1])
    shape = Shape.from_marker(marker)
    p = shape.points
    assert len(p) == SAMPLES
    spacing = np.abs(np.roll(p, -1) - p)
    assert spacing.max() <= shape.perimeter_m / SAMPLES + 1e-9
    assert np.sum(np.imag(np.conj(p) * np.roll(p, -1))) > 0  # the inside on the same side for all
    assert distance_to_outline(np.stack([p.real, p.imag], axis=1), shape.outline).max() < 1e-9


def test_normals_leave_the_shape_and_inside_points_do_not():
    shape = Shape.from_marker(flag())
    out = shape.points + 0.01 * shape.normals
    twice_area = np.sum(np.imag(np.conj(out) * np.roll(out, -1)))
    assert twice_area / 2 > shape.area_m2
    mean_inside = shape.inside.mean()
    assert abs(mean_inside) < 0.05  # spread evenly about the centroid
