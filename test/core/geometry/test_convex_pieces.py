"""Outlines as convex pieces."""

import cv2
import numpy as np
import pytest

from artrec_ros.core.geometry.convex_pieces import convex_pieces

SIZE = 400
TURN = np.linspace(0, 2 * np.pi, 60, endpoint=False)
OPEN = np.concatenate([TURN[4:57], TURN[4:57][::-1]])
SHAPES = {
    "square": [(0, 0), (1, 0), (1, 1), (0, 1)],
    "L": [(0, 0), (1, 0), (1, 0.3), (0.3, 0.3), (0.3, 1), (0, 1)],
    "U": [(0, 0), (1, 0), (1, 1), (0.7, 1), (0.7, 0.3), (0.3, 0.3), (0.3, 1), (0, 1)],
    "cross": [(3, 1), (5, 1), (5, 3), (7, 3), (7, 5), (5, 5), (5, 7), (3, 7), (3, 5), (1, 5), (1, 3), (3, 3)],
    "star": [((1 + n % 2) * np.cos(a), (1 + n % 2) * np.sin(a)) for n, a in enumerate(TURN[::6])],
    "gear": [((5 + n % 4 // 2) * np.cos(a), (5 + n % 4 // 2) * np.sin(a)) for n, a in enumerate(TURN)],
    "comb": [
        *((0, 0), (7, 0), (7, 3), (6, 3), (6, 1), (5, 1), (5, 3), (4, 3)),
        *((4, 1), (3, 1), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)),
    ],
    "L, corners twice": [(0, 0), (1, 0), (1, 0), (1, 0.3), (0.3, 0.3), (0.3, 0.3), (0.3, 1), (0, 1), (0, 0)],
    "hook": [(r * np.cos(a), r * np.sin(a)) for r, a in zip(np.repeat([1, 0.8], 53), OPEN, strict=True)],
}


def _filled(polygons):
    drawn = np.zeros((SIZE, SIZE), np.uint8)
    for polygon in polygons:
        cv2.fillPoly(drawn, [np.rint(polygon * 16).astype(np.int32)], 1, shift=4)
    return drawn > 0


@pytest.mark.parametrize("clockwise", [False, True])
@pytest.mark.parametrize("name", SHAPES)
def test_hulls_of_the_pieces_cover_an_outline_and_hardly_more(name, clockwise):
    outline = np.array(SHAPES[name], float)[:: -1 if clockwise else 1]
    outline = 20 + 340 * (outline - outline.min(axis=0)) / np.ptp(outline, axis=0).max()
    pieces = convex_pieces(outline)
    shown = _filled([outline])
    covered = _filled([cv2.convexHull(p.astype(np.float32))[:, 0] for p in pieces])
    assert not (shown & ~covered).any()
    assert (covered & ~shown).sum() < 0.12 * shown.sum()
    assert (len(pieces) == 1) == (name == "square")


def test_what_is_all_but_convex_stays_one_piece():
    dented = np.array([(0, 0), (1, 0), (1, 1), (0.5, 0.97), (0, 1)])
    assert len(convex_pieces(dented)) == 1


def test_a_polygon_that_touches_itself_is_still_covered():
    twice = np.array([(0, 0), (2, 0), (2, 1), (1, 0), (0, 1)], float)
    assert len(np.unique(np.concatenate(convex_pieces(twice)), axis=0)) == len(twice)
