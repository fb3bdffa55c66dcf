"""How much of one placed outline another covers."""

import itertools

import cv2
import numpy as np
import pytest
from cranes import placed_points
from scene import disc, rectangle

from artrec_ros.core.alignment.matching import Matches
from artrec_ros.core.alignment.overlap import overlap_matrix
from artrec_ros.core.alignment.placements import Evidence, Placements
from artrec_ros.core.alignment.shapes import Shape
from artrec_ros.core.base.deadline import Deadline

pytestmark = pytest.mark.uncompiled


def test_overlap_is_that_of_the_polygons():
    rng = np.random.default_rng(2)
    shapes = [Shape.from_marker(rectangle("bar", 1.0, 0.5)), Shape.from_marker(disc("d", 0.4))]
    n, none = 12, np.zeros(12, np.int32)
    t = rng.uniform(0, 50, (n, 2)) @ np.array([1, 1j])
    z = 30 * np.exp(rng.normal(0, 0.3, n) + 1j * rng.uniform(-3, 3, n))
    placed = Placements.similarities(t, z, np.arange(n, dtype=np.int32) % 2, none, none).replace(w=0.2 * np.conj(z))
    overlap = overlap_matrix(shapes, placed, np.zeros(n, int))
    for i, j in itertools.product(range(n), range(n)):
        a, b = (placed_points(placed, k, shapes[k % 2].corners) for k in (i, j))
        a, b = (np.stack([p.real, p.imag], axis=1).astype(np.float32) for p in (a, b))
        common = cv2.intersectConvexConvex(a, b)[0] / min(cv2.contourArea(a), cv2.contourArea(b))
        assert overlap[i, j] == pytest.approx(common, abs=0.06)
    assert (np.triu(overlap, 1) > 0.3).any() and (overlap == 0).any()


class _Looks(Deadline):
    """Over after so many looks at the clock."""

    def __init__(self, most: int) -> None:
        super().__init__()
        self.left = most

    @property
    def expired(self) -> bool:
        self.left -= 1
        return self.left < 0


def test_where_time_is_short_the_strongest_are_related_as_they_would_be_among_all():
    rng = np.random.default_rng(3)
    n, none = 100, np.zeros(100, np.int32)
    t = rng.uniform(0, 200, (n, 2)) @ np.array([1, 1j])
    placed = Placements.similarities(t, np.full(n, 30 + 0j), none, none, none).replace(score=rng.uniform(0, 1, n))
    found = Evidence(np.ones(n), np.ones(n), np.ones(n), np.zeros((n, 1), np.int32))
    matches = Matches([Shape.from_marker(rectangle("bar", 1.0, 0.5))], placed, np.zeros(n, int), found)
    everyone = matches.related(Deadline())
    assert (everyone.placed.t == placed.t).all()
    assert (everyone.overlap == overlap_matrix(matches.shapes, placed, matches.labels)).all()
    few = matches.related(_Looks(2))
    strongest = np.sort(np.argsort(-placed.score)[: len(few)])
    assert 0 < len(few) < n and (few.placed.t == placed.t[strongest]).all()
    assert (few.overlap == everyone.overlap[np.ix_(strongest, strongest)]).all() and (few.overlap > 0).sum() > len(few)
    assert not len(matches.related(_Looks(0)))
