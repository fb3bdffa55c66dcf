"""Polygon checks, discs, and silhouettes against shapes of known size."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.objects.outlines import crossing_edges, disc_outline, folded_corner, silhouette_outline

SQUARE = np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]])


def _area(outline: np.ndarray) -> float:
    x, y = outline.T
    return abs(float(np.sum(x * np.roll(y, -1) - np.roll(x, -1) * y))) / 2


@pytest.mark.parametrize(
    ("outline", "expected"),
    [
        (SQUARE, None),
        (SQUARE[::-1], None),
        (SQUARE[[0, 2, 1, 3]], (0, 2)),  # bow tie
        (np.array([[0, 0], [4, 0], [4, 4], [2, 0], [0, 4.0]]), (0, 2)),  # a corner that touches an edge
        (np.array([[0, 0], [2, 0], [2, 2], [3, 2], [3, 3], [0, 3.0]]), None),
        (np.array([[0, 0], [4, 0], [4, 1], [1, 1], [1, -1], [0, -1.0]]), (0, 3)),
    ],
)
def test_crossing_edges(outline: np.ndarray, expected: tuple[int, int] | None) -> None:
    assert crossing_edges(outline) == expected
    assert crossing_edges(outline * 1e-3 + 5) == expected


def test_random_star_shapes_do_not_cross_until_two_corners_swap() -> None:
    rng = np.random.default_rng(3)
    for _ in range(20):
        angle = np.arange(12) * 2 * np.pi / 12
        star = (rng.uniform(0.5, 1.5, 12) * np.array([np.cos(angle), np.sin(angle)])).T
        assert crossing_edges(star) is None
        star[[2, 7]] = star[[7, 2]]
        assert crossing_edges(star) is not None


def test_folded_corners() -> None:
    assert folded_corner(SQUARE) is None
    assert folded_corner(np.insert(SQUARE, 1, SQUARE[1], axis=0)) == 1
    assert folded_corner(np.array([[0, 0], [2, 0], [1, 0], [1, 1.0]])) == 1
    assert folded_corner(np.array([[0, 0], [1, 0], [2, 0], [2, 2.0]])) is None  # straight on is no fold


def test_disc_has_its_radius_and_nearly_its_area() -> None:
    outline = disc_outline(0.02)
    assert np.allclose(np.linalg.norm(outline, axis=1), 0.02)
    assert _area(outline) == pytest.approx(np.pi * 0.02**2, rel=2e-3)


def _draw(path: Path, outline_px: np.ndarray, size: tuple[int, int], shape: int, ground: int, soft: bool) -> None:
    """A polygon, pixel centres at integers; soft: edge pixels hold the share that is covered."""
    fine = 8 if soft else 1
    big = np.full((size[1] * fine, size[0] * fine), ground, np.uint8)
    points = (outline_px + 0.5) * fine - 0.5
    cv2.fillPoly(big, [np.round(points * 256).astype(np.int32)], shape, cv2.LINE_8, 8)
    cv2.imwrite(str(path), cv2.resize(big, size, interpolation=cv2.INTER_AREA))


@pytest.mark.parametrize(
    ("shape", "ground", "soft"), [(255, 0, True), (20, 230, True), (255, 0, False), (0, 255, False)]
)
def test_silhouette_has_its_width_and_area_in_either_polarity(
    tmp_path: Path, shape: int, ground: int, soft: bool
) -> None:
    corners = np.array([[20.3, 30.2], [120.6, 30.2], [120.6, 60.7], [70.1, 60.7], [70.1, 90.4], [20.3, 90.4]])
    _draw(tmp_path / "l.png", corners, (150, 120), shape, ground, soft)
    outline = silhouette_outline(tmp_path / "l.png", 0.2)
    assert np.ptp(outline[:, 0]) == pytest.approx(0.2)
    assert outline.min(axis=0) == pytest.approx(-outline.max(axis=0))
    metres_per_px = 0.2 / 100.3
    assert _area(outline) == pytest.approx(_area(corners) * metres_per_px**2, rel=0.02)
    assert crossing_edges(outline) is None
    upper = outline[outline[:, 1] > 0.02]  # y up: the L's long bar is at the image's top
    assert np.ptp(upper[:, 0]) == pytest.approx(0.2, rel=0.02)


def test_silhouette_takes_the_largest_shape_and_the_alpha_channel(tmp_path: Path) -> None:
    image = np.zeros((80, 100, 4), np.uint8)
    image[20:60, 10:70, 3] = 255
    image[5:9, 90:96, 3] = 255
    cv2.imwrite(str(tmp_path / "a.png"), image)
    outline = silhouette_outline(tmp_path / "a.png", 0.6)
    assert np.ptp(outline[:, 1]) == pytest.approx(0.4, rel=0.01)


def test_silhouette_may_touch_the_border(tmp_path: Path) -> None:
    image = np.zeros((60, 80), np.uint8)
    image[20:40, 0:40] = 255
    cv2.imwrite(str(tmp_path / "b.png"), image)
    outline = silhouette_outline(tmp_path / "b.png", 0.4)
    assert np.ptp(outline[:, 1]) == pytest.approx(0.2, rel=0.01)


def test_large_silhouettes_keep_their_shape(tmp_path: Path) -> None:
    image = np.zeros((2500, 4000), np.uint8)
    image[500:1500, 400:3600] = 255
    cv2.imwrite(str(tmp_path / "large.png"), image)
    outline = silhouette_outline(tmp_path / "large.png", 3.2)
    assert np.ptp(outline[:, 1]) == pytest.approx(1.0, rel=2e-3)


def test_bad_silhouettes_are_refused(tmp_path: Path) -> None:
    (tmp_path / "text.png").write_text("no image")
    cv2.imwrite(str(tmp_path / "plain.png"), np.full((40, 40), 9, np.uint8))
    speck = np.zeros((40, 40), np.uint8)
    speck[10:13, 10:13] = 255
    cv2.imwrite(str(tmp_path / "speck.png"), speck)
    for name, reason in (
        ("none", "no such file"),
        ("text", "image"),
        ("plain", "one colour"),
        ("speck", "larger image"),
    ):
        with pytest.raises(ConfigError, match=f"{name}.png.*{reason}"):
            silhouette_outline(tmp_path / f"{name}.png", 0.1)
