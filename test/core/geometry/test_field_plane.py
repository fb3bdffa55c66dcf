"""A plane by points of known places: what it tells of pixels, with and without a lens, and which points make none."""

from __future__ import annotations

import tracemalloc

import fields
import numpy as np
import pytest

from artrec_ros.core.base.config import PlaneConfig
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.geometry.field_plane import FieldPlane

LENS = (-0.25, 0.08, 0.001, -0.002)
SLANT = 35.0


def places(n: int = 40) -> np.ndarray:
    return np.random.default_rng(1).uniform((0, 0), (1.0, 0.8), (n, 2))


@pytest.mark.parametrize("bend", [(), LENS])
def test_pixels_go_to_their_places_and_back(bend: tuple[float, ...]) -> None:
    camera = fields.camera(bend=bend)
    plane = FieldPlane.of(fields.plane(camera, SLANT), camera if bend else None)
    pixels = fields.seen(camera, SLANT, places())
    np.testing.assert_allclose(plane.places(pixels), places(), atol=2e-5)
    np.testing.assert_allclose(plane.pixels(places()), pixels, atol=1e-3)


def test_a_lens_that_is_not_undone_moves_places() -> None:
    camera = fields.camera(bend=LENS)
    plane = FieldPlane.of(fields.plane(camera, SLANT), None)
    assert np.abs(plane.places(fields.seen(camera, SLANT, places())) - places()).max() > 2e-3


@pytest.mark.parametrize("bend", [(), LENS])
def test_jacobian_and_scale_are_those_of_small_steps(bend: tuple[float, ...]) -> None:
    camera = fields.camera(bend=bend)
    plane, step = FieldPlane.of(fields.plane(camera, SLANT), camera), 1e-4
    pixels = fields.seen(camera, SLANT, places())
    ahead = fields.seen(camera, SLANT, places() + (step, 0)) - pixels
    left = fields.seen(camera, SLANT, places() + (0, step)) - pixels
    forward = np.stack([ahead, left], axis=-1) / step  # pixels per metre
    np.testing.assert_allclose(plane.jacobian(pixels) @ forward, np.tile(np.eye(2), (40, 1, 1)), atol=2e-3)
    np.testing.assert_allclose(plane.scales(pixels), np.sqrt(np.abs(np.linalg.det(forward))), rtol=2e-3)


def test_more_points_agree_on_one_plane() -> None:
    """Each is off by half a pixel: twelve tell more than the four of them that are the field's corners."""
    rng, camera = np.random.default_rng(5), fields.camera()
    given = np.concatenate([fields.CORNERS, places(8)])
    exact, errors = fields.seen(camera, SLANT, given), {4: [], 12: []}
    for _ in range(20):
        pixels = exact + rng.normal(0, 0.5, exact.shape)
        for n in errors:
            plane = FieldPlane.of(PlaneConfig(tuple(pixels[:n].ravel()), tuple(given[:n].ravel())), None)
            at = plane.places(fields.seen(camera, SLANT, places()))
            errors[n].append(np.linalg.norm(at - places(), axis=1).mean())
    assert np.mean(errors[12]) < 0.8 * np.mean(errors[4])
    assert plane.errors_px.shape == (12,) and 0.1 < np.sqrt(np.mean(plane.errors_px**2)) < 1.0


def test_hundreds_of_points_take_no_memory_to_speak_of() -> None:
    """Each of them is moved and the plane fitted anew: what that keeps must not grow with their cube."""
    camera, given = fields.camera(), places(200)
    config = PlaneConfig(tuple(fields.seen(camera, SLANT, given).ravel()), tuple(given.ravel()))
    tracemalloc.start()
    plane = FieldPlane.of(config, None)
    most = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert plane.errors_px.max() < 1e-6
    assert most < 1e8  # bytes; the equations themselves, of 400 fits, are 12 MB


def test_errors_of_points_are_told_as_they_are_made() -> None:
    """The deviation that the points' noise makes at a place, over many draws, is the one that is told."""
    rng, camera = np.random.default_rng(7), fields.camera()
    exact = fields.seen(camera, SLANT, fields.CORNERS)
    pixel = fields.seen(camera, SLANT, np.array([[0.3, 0.6]]))[0]
    config = fields.plane(camera, SLANT, point_noise_px=0.7)
    told = FieldPlane.of(config, None).point_errors(pixel)
    drawn = []
    for _ in range(400):
        pixels = exact + rng.normal(0, 0.7, exact.shape)
        plane = FieldPlane.of(PlaneConfig(tuple(pixels.ravel()), config.field_points), None)
        J, J0 = plane.jacobian(pixel[None])[0], FieldPlane.of(config, None).jacobian(pixel[None])[0]
        turned = J @ np.linalg.inv(J0)
        drawn.append([*plane.places(pixel[None])[0], np.arctan2(turned[1, 0] - turned[0, 1], np.trace(turned))])
    np.testing.assert_allclose(np.sqrt((told**2).sum(axis=0)), np.std(drawn, axis=0), rtol=0.15)


def test_there_is_nothing_behind_the_horizon() -> None:
    camera = fields.camera()
    plane = FieldPlane.of(fields.plane(camera, 70.0), None)
    above, below = np.array([[320.0, -900.0]]), np.array([[320.0, 300.0]])
    assert np.isnan(plane.places(above)).all() and plane.scales(above) == 0
    assert np.isfinite(plane.places(below)).all() and plane.scales(below) > 0


SQUARE = (100.0, 400.0, 500.0, 400.0, 460.0, 60.0, 140.0, 60.0)
FIELD = (0.0, 0.0, 1.0, 0.0, 1.0, 1.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("image", "field", "part"),
    [
        (SQUARE[:6], FIELD[:6], "image_points: 3 points are given; a plane takes four or more"),
        (SQUARE[:7], FIELD, "image_points: 7 numbers are given"),
        (SQUARE, (*FIELD, 0.5, 0.5), "image_points has 4 points and field_points 5"),
        ((), FIELD, "image_points has 0 points and field_points 4"),
        ((100.0, 400.0, 300.0, 400.0, 500.0, 400.0, 140.0, 60.0), FIELD, "image_points: all of the points but one"),
        (SQUARE, (0.0, 0.0, 1.0, 0.0, 2.0, 0.0, 3.0, 0.0), "field_points: all of the points but one"),
        ((100.0, 400.0) * 2 + SQUARE[4:], FIELD, "image_points: all of the points but one"),
        (SQUARE, (0.0, 0.0, 1.0, 0.0, 1.0, -1.0, 0.0, -1.0), "the field is mirrored"),
        (SQUARE, FIELD[2:4] + FIELD[:2] + FIELD[4:], "no camera sees the points like this"),
        ((*SQUARE, 300.0, 300.0), (*FIELD, 0.1, 0.9), "the points do not fit together"),
        ((*SQUARE[:7], float("nan")), FIELD, "image_points: nan is below"),
        (SQUARE * 250, FIELD * 250, "image_points: 1000 points are given, more than 500; leave some out"),
    ],
)
def test_points_that_make_no_plane_are_refused_in_one_line(image: tuple, field: tuple, part: str) -> None:
    with pytest.raises(ConfigError) as error:
        FieldPlane.of(PlaneConfig(image, field), None)
    assert part in str(error.value) and "\n" not in str(error.value) and "scene.plane" in str(error.value)
