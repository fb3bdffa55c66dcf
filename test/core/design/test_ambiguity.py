import numpy as np
import pytest

from artrec_ros.core.alignment.shapes import Shape
from artrec_ros.core.alignment.symmetry import ANY_ANGLE
from artrec_ros.core.design import ambiguity
from artrec_ros.core.design.ambiguity import find_ambiguities, unlikeness
from artrec_ros.core.design.placement import buried_markers
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Box, Component, ObjectModel

FLAG = np.array([[-0.05, -0.02], [0.05, -0.02], [0.05, 0.0], [-0.01, 0.0], [-0.01, 0.03], [-0.05, 0.03]])
BAR = np.array([[-0.05, -0.01], [0.05, -0.01], [0.05, 0.01], [-0.05, 0.01]])


def marker(name, outline, pose=None, radius=None):
    low, high = outline.min(axis=0), outline.max(axis=0)
    return Marker(name, outline, np.array([low[0], 0.0]), np.array([high[0], 0.0]), radius, pose)


def turned(outline, angle):
    c, s = np.cos(angle), np.sin(angle)
    return outline @ np.array([[c, s], [-s, c]])


def model(*components):
    return ObjectModel(
        "toy",
        tuple(Component(n, tuple(ms), required=i == 0, label=label) for i, (n, label, ms) in enumerate(components)),
    )


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.5, -1.9])
def test_a_turned_copy_is_alike_at_that_turn(angle):
    """Image coordinates point down: what is turned by +a there was turned by -a in the marker's frame."""
    distance, turn = unlikeness(
        Shape.from_marker(marker("a", turned(FLAG, -angle))), Shape.from_marker(marker("b", FLAG))
    )
    assert distance < 1e-3
    assert np.cos(turn - angle) == pytest.approx(1, abs=2e-3)


def test_each_two_shapes_are_compared_once_and_shown_as_they_are(monkeypatch):
    """However many markers have them: forty took nine seconds."""
    compared, pairs = [], []
    monkeypatch.setattr(ambiguity, "unlikeness", lambda a, b: compared.append((a, b)) or unlikeness(a, b))
    parts = [(f"part{n}", None, [marker("flag", FLAG), marker("bar", BAR)]) for n in range(6)]
    find_ambiguities(model(*parts), shown=lambda some: pairs.extend(some) or some)
    assert len(pairs) == 12 * 11 / 2 and len(compared) <= 2 * 4


def test_unlikeness_is_mutual_and_grows_with_size():
    a, b = Shape.from_marker(marker("a", FLAG)), Shape.from_marker(marker("b", BAR))
    assert unlikeness(a, b)[0] == pytest.approx(unlikeness(b, a)[0], rel=0.05)
    big = unlikeness(Shape.from_marker(marker("a", 3 * FLAG)), Shape.from_marker(marker("b", 3 * BAR)))[0]
    assert big == pytest.approx(3 * unlikeness(a, b)[0], rel=1e-6)


def test_symmetry_is_told_by_design_not_by_size():
    disc = np.array([[np.cos(a), np.sin(a)] for a in np.linspace(0, 2 * np.pi, 64, endpoint=False)]) * 0.02
    found = find_ambiguities(
        model(
            ("a", 1, [marker("flag", FLAG)]),
            ("b", 2, [marker("bar", BAR)]),
            ("c", 3, [marker("dot", disc, None, 0.02)]),
        )
    )
    assert {m.marker: m.order for m in found.limits} == {"flag": 1, "bar": 2, "dot": ANY_ANGLE}
    assert {m.marker: np.isfinite(m.turn) for m in found.limits} == {"flag": True, "bar": False, "dot": False}


def test_twice_as_large_is_told_from_twice_as_far():
    small, large = (find_ambiguities(model(("a", None, [marker("flag", k * FLAG)]))).limits[0] for k in (1, 2))
    assert small.found == pytest.approx(2 * large.found)
    assert small.turn == pytest.approx(2 * large.turn, rel=1e-6)


def test_same_shapes_of_one_class_are_the_same_and_mirrored_ones_nearly():
    flip = FLAG[::-1] * (-1, 1)
    (same,) = find_ambiguities(model(("a", 1, [marker("x", FLAG)]), ("b", 1, [marker("y", turned(FLAG, 1.0))]))).alike
    assert same.same and {same.first, same.second} == {("a", "x"), ("b", "y")}
    near = FLAG + np.array([[0, 0], [0, 0], [0, 0.004], [0, 0.004], [0, 0], [0, 0]])
    pairs = find_ambiguities(model(("a", 1, [marker("x", FLAG), marker("z", near)]))).alike
    assert len(pairs) == 1 and not pairs[0].same and np.isfinite(pairs[0].told)
    assert not pairs[0].mirrored
    cab = np.array([[-0.1, -0.03], [0.1, -0.03], [0.1, 0.0], [0.02, 0.03], [-0.1, 0.03]])
    (pair,) = find_ambiguities(model(("a", 1, [marker("r", cab), marker("l", cab[::-1] * (-1, 1))]))).alike
    assert pair.mirrored and not pair.same
    mirrored = find_ambiguities(model(("a", 1, [marker("x", FLAG), marker("m", flip)]))).alike
    assert not any(p.same for p in mirrored)


def test_another_class_or_another_size_is_never_mistaken():
    assert not find_ambiguities(model(("a", 1, [marker("x", FLAG)]), ("b", 2, [marker("y", FLAG)]))).alike
    assert not find_ambiguities(model(("a", 1, [marker("x", FLAG)]), ("b", 1, [marker("y", 3 * FLAG)]))).alike


@pytest.mark.parametrize(("height", "buried"), [(0.0501, False), (0.05, False), (0.03, True), (0.0, True)])
def test_a_marker_within_its_body_is_found(height, buried):
    body = Box(Pose.identity(), np.array([0.2, 0.2, 0.1]))
    place = marker("x", FLAG, Pose(np.eye(3), np.array([0, 0, height])))
    toy = ObjectModel("toy", (Component("a", (place,), required=True, bodies=(body,)),))
    assert buried_markers(toy) == ([("a", "x")] if buried else [])


@pytest.mark.parametrize(("thickness", "gap"), [(0.1, 0.0), (0.012, 0.0005), (0.012, 0.004), (0.003, 0.001)])
def test_a_marker_that_looks_into_its_body_is_found(thickness, gap):
    body = Box(Pose.identity(), np.array([0.2, 0.2, thickness]))
    over = Pose(np.diag([1.0, -1.0, -1.0]), np.array([0, 0, thickness / 2 + gap]))
    toy = ObjectModel("toy", (Component("a", (marker("x", FLAG, over),), required=True, bodies=(body,)),))
    assert buried_markers(toy) == [("a", "x")]
