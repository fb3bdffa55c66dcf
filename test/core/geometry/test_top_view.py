"""A plane as a camera above it would see it: similarities, and the way back."""

import fields
import numpy as np
import pytest

from artrec_ros.core.base.config import SceneConfig
from artrec_ros.core.geometry.range_limits import ScaleLimits
from artrec_ros.core.geometry.scene import Scene
from artrec_ros.core.geometry.top_view import TopView

ANY = ScaleLimits(0.0, np.inf)
LENS = (-0.25, 0.08, 0.001, -0.001)


def view(slant: float, bend=(), region=(), limits=ANY) -> TopView | None:
    camera = fields.camera(bend=bend)
    config = SceneConfig(region=region, plane=fields.plane(camera, slant))
    return TopView.of(Scene.of(config, camera), fields.SIZE, limits)


@pytest.mark.parametrize("bend", [(), LENS])
def test_every_pixel_of_the_view_is_where_the_image_has_it(bend) -> None:
    made = view(40.0, bend)
    assert made is not None
    width, height = made.size
    assert made.columns.shape == made.rows.shape == (height, width)
    rng = np.random.default_rng(2)
    u, v = rng.integers(0, width, 400), rng.integers(0, height, 400)
    pixels = np.column_stack([u, v]).astype(float)
    there = made.in_image(pixels)
    known = np.isfinite(there).all(axis=1) & (np.abs(there) < 1e4).all(axis=1)
    assert known.mean() > 0.5
    mapped = np.column_stack([made.columns[v, u], made.rows[v, u]])
    assert np.abs(mapped - there)[known].max() < 0.05
    np.testing.assert_allclose(made.from_image(there[known]), pixels[known], atol=0.02)


def test_seen_from_above_directions_and_lengths_are_those_of_the_plane() -> None:
    made = view(50.0)
    assert made is not None and made.scene.plane is not None
    corners = made.from_image(fields.seen(fields.camera(), 50.0, fields.CORNERS))
    sides = np.diff(corners, axis=0)
    np.testing.assert_allclose(sides[0], (made.scale, 0), atol=0.01 * made.scale)  # x to the right
    np.testing.assert_allclose(sides[1], (0, -0.8 * made.scale), atol=0.01 * made.scale)  # y up
    np.testing.assert_allclose(made.scene.plane.scales(corners), made.scale, rtol=1e-6)
    np.testing.assert_allclose(made.scene.plane.places(corners), fields.CORNERS, atol=1e-6)


def test_a_direction_is_brought_back_with_its_length() -> None:
    made = view(50.0)
    assert made is not None
    at, theta, larger = made.turned(np.array([[200.0, 150.0], [50.0, 220.0]]), np.array([0.3, -2.0]))
    for n, (pixel, angle) in enumerate((((200.0, 150.0), 0.3), ((50.0, 220.0), -2.0))):
        step = 0.01 * np.array([np.cos(angle), np.sin(angle)])
        ends = made.in_image(np.array([pixel, np.add(pixel, step)]))
        np.testing.assert_allclose(at[n], ends[0], atol=1e-9)
        ahead = ends[1] - ends[0]
        assert np.angle(np.exp(1j * (np.arctan2(ahead[1], ahead[0]) - theta[n]))) == pytest.approx(0, abs=1e-3)
    assert (larger > 0).all()


def test_what_is_seen_straight_on_needs_no_view() -> None:
    assert view(0.0) is None
    assert TopView.of(Scene(), fields.SIZE, ANY) is None


def test_its_scale_lies_within_the_limits_and_its_region_is_the_scenes() -> None:
    wide, narrow = view(40.0), view(40.0, limits=ScaleLimits(480.0, 2000.0))
    assert wide is not None and narrow is not None
    assert wide.scale < 480 <= narrow.scale
    assert narrow.size[1] < 0.8 * wide.size[1]  # what is farther is not looked at
    assert view(40.0, limits=ScaleLimits(20000.0, 1e6)) is None and view(40.0, limits=ScaleLimits(0.0, 2.0)) is None
    region = (200.0, 150.0, 400.0, 150.0, 420.0, 300.0, 190.0, 300.0)
    within = view(40.0, region=region)
    assert within is not None and np.prod(within.size) < np.prod(wide.size) / 2
    pixels = np.array([[300.0, 200.0], [205.0, 160.0], [100.0, 200.0], [300.0, 320.0]])
    assert within.scene.inside(within.from_image(pixels)).tolist() == [True, True, False, False]


def test_codes_are_taken_as_they_are_and_nothing_is_known_beyond_the_image() -> None:
    made = view(40.0)
    assert made is not None
    image = np.arange(fields.SIZE[0] * fields.SIZE[1], dtype=np.int64).reshape(fields.SIZE[::-1]) % 7
    codes = made.codes(image.astype(np.uint8), 255)
    width, height = fields.SIZE
    inside = (made.columns > 0) & (made.columns < width - 1) & (made.rows > 0) & (made.rows < height - 1)
    at = np.rint(made.rows[inside]).astype(int), np.rint(made.columns[inside]).astype(int)
    assert (codes[inside] == image[at]).mean() > 0.98  # halves may be rounded otherwise
    beyond = (made.columns < -1) | (made.columns > width) | (made.rows < -1) | (made.rows > height)
    assert beyond.any() and (codes[beyond] == 255).all()


@pytest.mark.parametrize(
    "region",
    [
        (700.0, 10.0, 900.0, 10.0, 900.0, 400.0, 700.0, 400.0),
        (10.0, 500.0, 600.0, 500.0, 600.0, 900.0, 10.0, 900.0),
        (-300.0, -300.0, -10.0, -300.0, -10.0, -10.0, -300.0, -10.0),
        (639.0, 100.0, 900.0, 100.0, 900.0, 100.5, 639.0, 100.5),
    ],
)
def test_a_region_beyond_the_image_makes_no_view(region) -> None:
    assert view(45.0, region=region) is None


@pytest.mark.parametrize("slant", [60.0, 75.0, 82.0])
def test_a_plane_that_nears_its_horizon_makes_no_huge_view(slant: float) -> None:
    made = view(slant)
    assert made is not None
    assert np.prod(made.size) < 2.2 * np.prod(fields.SIZE) and max(made.size) < 4.1 * max(fields.SIZE)


def test_views_of_very_wide_images_have_no_longer_sides_than_can_be_looked_up() -> None:
    camera = fields.camera()
    scene = Scene.of(SceneConfig(plane=fields.plane(camera, 60.0)), camera)
    made = TopView.of(scene, (20_000, fields.SIZE[1]), ANY)
    assert made is not None and max(made.size) <= 32_766
    assert made.codes(np.zeros((fields.SIZE[1], 20_000), np.uint8), 7).shape == made.columns.shape
    assert TopView.of(scene, (32_767, fields.SIZE[1]), ANY) is None
