"""Distances of marks that no joint changes: of three dots on a plate and one on an arm, seen from above."""

from __future__ import annotations

import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import Array, Pose
from artrec_ros.core.learning.marked_views import Marks
from artrec_ros.core.learning.varying_distances import varying_distances
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, Joint, ObjectModel

PLACES = {"base": (0.0, 0.0), "left": (0.0, 0.2), "ahead": (0.3, 0.0), "hand": (0.2, 0.0)}
AROUND = np.exp(2j * np.pi * np.arange(24) / 24)
DOT = 0.02 * np.column_stack([AROUND.real, AROUND.imag])


def plate() -> ObjectModel:
    parts = []
    for name, (x, y) in PLACES.items():
        T = Pose(np.eye(3), np.array([x, y, 0.0]))
        marker = Marker("dot", DOT, np.array([-0.02, 0.0]), np.array([0.02, 0.0]), 0.02, T)
        hinge = Joint("base", Pose(np.eye(3), np.array([0.1, 0.1, 0.0])), np.array([0.0, 0.0, 1.0]), -1.0, 1.0)
        parts.append(Component(name, (marker,), required=name == "base", joint=hinge if name == "hand" else None))
    return ObjectModel("plate", tuple(parts))


def marks(scale: Array, slide_px: Array) -> list[Marks]:
    """Of images at some scales, px/m, in which `ahead` slides along x; the arm bends, and clicks are a pixel off."""
    rng, out = np.random.default_rng(0), []
    for n, (s, slide) in enumerate(zip(scale.tolist(), slide_px.tolist(), strict=True)):
        at = s * np.array(list(PLACES.values())) + [[0, 0], [0, 0], [slide, 0], [0, 40 * np.sin(n)]]
        turn = np.exp(0.7j * n) * (at @ (1, 1j))
        ends = np.column_stack([turn.real, turn.imag])[:, None] + [[-5, 0], [5, 0]]
        out.append(Marks(np.arange(4), ends + 200 + rng.normal(0, 1, ends.shape), f"{n}.png"))
    return out


STILL, MOVING = np.full(12, 500.0), np.linspace(400, 700, 12)


@pytest.mark.parametrize("scale", [STILL, MOVING])
def test_what_is_rigid_varies_by_what_clicks_are_off(scale: Array) -> None:
    assert varying_distances(plate(), marks(scale, np.zeros(12))) == []


def test_what_slides_is_told_with_both_of_its_distances() -> None:
    found = varying_distances(plate(), marks(STILL, np.linspace(-30, 30, 12)))
    assert [(v.first[0], v.second[0]) for v in found] == [("base", "ahead"), ("left", "ahead")]
    assert (found[0].least, found[0].most) == (pytest.approx(0.8, abs=0.03), pytest.approx(1.2, abs=0.03))
    assert found[0].images == 12 and 6 <= found[0].off <= 11 and found[0].place in ("0.png", "11.png")


def test_a_mark_that_is_wrong_is_told_with_its_image() -> None:
    slide = np.zeros(12)
    slide[7] = 40
    for scale in (STILL, MOVING):
        found = varying_distances(plate(), marks(scale, slide))
        assert {v.place for v in found} == {"7.png"} and {v.off for v in found} == {1}
        assert scale is MOVING or all("ahead" in (v.first[0], v.second[0]) for v in found)  # which, scales alone tell


def test_of_few_images_nothing_is_said() -> None:
    assert varying_distances(plate(), marks(STILL, np.linspace(-30, 30, 12))[:3]) == []
