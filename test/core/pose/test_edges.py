"""Edges of a class along the normals of a contour's points."""

from dataclasses import replace

import numpy as np
import pytest
from settings import DEFAULTS
from solids import BACKGROUND, BODY, RED, camera_of, sign

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.codes import UNKNOWN
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.objects import Box, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.edge_kernels import edge_room, find_edges
from artrec_ros.core.pose.edges import edge_terms
from artrec_ros.core.pose.surface_model import SpatialModel

CAMERA = camera_of()
HEIGHT, WIDTH = 40, 60


def half_plane(edge, seam=0, outer=BACKGROUND):
    """RED left of x = edge - seam / 2, `outer` right of edge + seam / 2, unknown between; all at pixels' borders."""
    x = np.tile(np.arange(WIDTH), (HEIGHT, 1))
    return np.select([x < edge - seam / 2, x < edge + seam / 2], [RED, UNKNOWN], outer).astype(np.uint8)


def edges(labels, points, normal, reach=5, label=RED, target=None):
    """Signed distances of the edge along the normals of a contour's points, and their weights: (n,) each."""
    target = target or Target("sign", sign(), label)
    model, pixels = SpatialModel(target.model, label, DEFAULTS.votes), np.array(points, float)
    frame = ImageFrame(LabelField(labels, on_bodies=target.on_bodies), CAMERA)
    room = edge_room(len(pixels), reach, 6)
    room.outline[:2], room.outline[2:] = pixels.T, np.broadcast_to(np.array(normal, float), pixels.shape).T
    find_edges(0, edge_terms(model, frame.field, (reach,), DEFAULTS.fit), 0, frame.view, room)
    return room.edge, room.weight


@pytest.mark.parametrize("reach", [5, 8])
@pytest.mark.parametrize("seam", [0, 2, 4])
def test_an_edge_is_where_the_class_ends_or_amid_a_seam(seam, reach):
    """Pixel 30 is the first beyond the edge, or as far to the right of the seam's middle: 29.5."""
    offset = np.random.default_rng(0).uniform(-1, 1, 400)  # a contour's points fall anywhere between pixels
    found, weight = edges(half_plane(30, seam), np.column_stack([29.5 - offset, np.full(400, 20)]), (1, 0), reach)
    assert (weight > 0).all()
    assert (found - offset).mean() == pytest.approx(0, abs=0.05 + 0.12 * seam)
    assert np.abs(found - offset).max() < 0.6 + 0.25 * seam


@pytest.mark.parametrize("offset", [-2.0, -0.7, 0.0, 1.3, 2.0])
def test_edges_are_found_along_any_normal(offset):
    y, x = np.mgrid[:200, :200]
    labels = np.where(np.hypot(x - 100.2, y - 99.7) < 60, RED, BACKGROUND).astype(np.uint8)
    angle = np.linspace(0, 2 * np.pi, 500, endpoint=False)
    normal = np.column_stack([np.cos(angle), np.sin(angle)])
    found, weight = edges(labels, (100.2, 99.7) + (60 + offset) * normal, normal)
    assert (weight > 0).all()
    assert found.mean() == pytest.approx(-offset, abs=0.15)
    assert np.abs(found + offset).max() < 1.3


def test_an_edge_seen_the_wrong_way_round_is_none():
    _, weight = edges(half_plane(30), [(30, 20), (29, 20)], (-1, 0))
    assert not weight.any()


def test_where_no_edge_is_in_reach_there_is_no_say():
    _, weight = edges(half_plane(30), [(15, 20), (45, 20), (22, 20), (37, 20), (-300, 20), (900, 900)], (1, 0))
    assert not weight.any()
    _, weight = edges(half_plane(30), [(29, 20)], (1, 0), label=7)
    assert not weight.any()


def test_a_speck_does_not_move_an_edge_far():
    labels = half_plane(30)
    labels[20, 26] = BACKGROUND
    labels[20, 32] = UNKNOWN
    found, weight = edges(labels, [(29, 20), (30, 20)], (1, 0))
    np.testing.assert_allclose(found, [0.5, -0.5], atol=0.6)
    assert weight.all()


def test_half_the_usual_seam_is_added_where_only_unknown_follows():
    """Elsewhere in the same image the class is followed by another one across a seam."""
    labels = half_plane(30, 2)
    labels[:10, 29:] = UNKNOWN  # red ends at 28.5, nothing known follows
    assert LabelField(labels).seam_px(RED) == pytest.approx(1, abs=0.2)
    found, _ = edges(labels, [(29, 5)], (1, 0))
    assert found[0] == pytest.approx(0.5, abs=0.4)
    alone, _ = edges(half_plane(29, 0, UNKNOWN), [(29, 5)], (1, 0))
    assert alone[0] == pytest.approx(-0.5, abs=0.4)


def on_a_body(label=None):
    """The sign on a plate."""
    (plate,) = sign().components
    bodies = (Box(Pose.identity(), np.array([0.3, 0.001, 0.2])),)
    return Target("sign", ObjectModel("sign", (replace(plate, bodies=bodies, body_label=label),)), RED)


@pytest.mark.parametrize("rim", [1, 2, 4])
def test_a_marker_ends_where_the_body_of_no_class_that_bears_it_begins(rim):
    """Between it and the floor are so many unknown pixels: red ends at 29.5 - rim / 2, and there is no seam."""
    labels, points = half_plane(30, rim), [(29, 20), (28, 20)]
    end = labels[20].tolist().index(UNKNOWN) - 0.5
    found, _ = edges(labels, points, (1, 0), target=on_a_body())
    np.testing.assert_allclose(found, [end - 29, end - 28], atol=0.35)
    amid, _ = edges(labels, points, (1, 0), target=on_a_body(BODY))  # of a body that has a class they are none
    assert (amid - found > rim / 4).all()


def test_where_the_segmenter_leaves_seams_an_unknown_gap_as_wide_is_one_before_a_body_of_no_class_too():
    labels = half_plane(30, 2)
    labels[:20][labels[:20] == RED] = 4  # of nothing that stands on such a body
    found, _ = edges(labels, [(29, 30)], (1, 0), target=on_a_body())
    assert found[0] == pytest.approx(0.5, abs=0.4)
    for rim in (4, 7):  # wider than that
        labels[20:, 31 - rim : 31] = UNKNOWN
        found, _ = edges(labels, [(31 - rim, 30)], (1, 0), target=on_a_body())
        assert found[0] == pytest.approx(-0.5 + 1, abs=0.4)  # and half the seam beyond


def test_unknown_pixels_amid_a_marker_are_none_of_its_body():
    labels = half_plane(30)
    labels[20, 26] = UNKNOWN
    alone, _ = edges(half_plane(30), [(29, 20)], (1, 0), target=on_a_body())
    found, _ = edges(labels, [(29, 20)], (1, 0), target=on_a_body())
    assert found[0] == pytest.approx(alone[0], abs=0.2)


@pytest.mark.parametrize("nearer", [False, True])
def test_what_lies_before_a_marker_does_not_end_it(nearer):
    """The border of another object's pixels is an edge only where that may lie behind."""
    model = SpatialModel(sign(), RED, DEFAULTS.votes)
    hull = np.array([(31, -5), (70, -5), (70, 45), (31, 45)], np.float32)
    frame = ImageFrame(LabelField(half_plane(30)), CAMERA).without([hull], nearer=nearer)
    room = edge_room(2, 5, 6)
    room.outline[:] = np.array([(30.0, 29.0), (20.0, 21.0), (1.0, 1.0), (0.0, 0.0)])
    find_edges(0, edge_terms(model, frame.field, (5,), DEFAULTS.fit), 0, frame.view, room)
    assert (room.weight > 0).all() != nearer
