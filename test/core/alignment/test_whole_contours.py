import cv2
import numpy as np
import pytest
from scene import Placed, draw, flag

from artrec_ros.core.alignment.shapes import SAMPLES, Shape
from artrec_ros.core.alignment.whole_contours import WholeContours
from artrec_ros.core.base.config import RecognizerConfig
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.model.marker import Marker

CONFIG = RecognizerConfig()
SIZE = (640, 480)
ZERO = np.array([0])


def notched_disc() -> Marker:
    """Of which a slot alone tells the turn: 0.06 of its radius wide, 0.3 deep."""
    angle = np.linspace(0.03, 2 * np.pi - 0.03, 200)
    rim = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    return Marker("wheel", np.vstack([rim, [[0.7, -0.03], [0.7, 0.03]]]), np.array([-0.5, 0.0]), np.array([0.5, 0.0]))


def blobs_of(marker, placed, size=SIZE):
    labels = np.zeros(size[::-1], np.uint8)
    draw(labels, marker, placed, 1)
    return find_blobs(labels, {1}, CONFIG)


@pytest.mark.parametrize("turn", [0.0, 0.4, 1.9, -2.5])
@pytest.mark.parametrize("scale", [25.0, 200.0])
def test_a_slot_tells_the_turn_of_a_disc(turn, scale):
    placed, shape = Placed(310, 240, turn, scale), Shape.from_marker(notched_disc())
    true = blobs_of(notched_disc(), placed)
    t, z = WholeContours(true).laid([shape], ZERO, ZERO, 12)
    assert abs(np.angle(z[0, 0] * np.exp(-1j * turn))) < max(0.03, 1 / scale)  # 1 px at the rim: refinement follows
    assert abs(t[0, 0] - (310 + 240j)) < 1.5 and abs(abs(z[0, 0]) / scale - 1) < 0.02 + 0.5 / scale


def test_the_best_ways_are_those_of_all_couples_of_points():
    """Against least squares of each couple by itself."""
    blobs = [b for turn in (0.3, 2.0) for b in blobs_of(flag(), Placed(200, 200, turn, 80))]
    other, shape, contours = Shape.from_marker(notched_disc()), Shape.from_marker(flag()), WholeContours(blobs)
    t, z = contours.laid([other, shape], np.array([1, 0, 1]), np.array([1, 1, 1]), 5)
    assert np.array_equal(t[0], t[2]) and np.array_equal(z[0], z[2]) and not np.array_equal(z[0], z[1])
    points = shape.points
    for row, blob in zip((1, 0), (0, 1), strict=True):
        contour = blobs[blob].contour @ np.array([1, 1j])
        along = np.abs(np.diff(np.append(contour, contour[0])))
        ends = np.concatenate([[0], np.cumsum(along)])
        at = (np.arange(SAMPLES) + 0.5) * ends[-1] / SAMPLES
        even = np.interp(at, ends, np.append(contour, contour[0]))
        left = []
        for k in range(SAMPLES):
            A = np.stack([points, np.ones(SAMPLES)], axis=1)
            solution, residual, *_ = np.linalg.lstsq(A, np.roll(even, -k), rcond=None)
            left.append((float(np.abs(residual[0])), complex(solution[0])))
        best = min(left, key=lambda r: r[0])[1]
        assert abs(z[row, 0] - best) < 0.05 * abs(best)  # no farther than to the next couple


def test_what_is_no_local_optimum_has_no_size():
    outline = np.array([[0.0, 0.0], [3.0, -0.5], [3.2, 0.0], [3.0, 0.5]])
    marker = Marker("drop", outline, np.zeros(2), np.array([1.0, 0.0]))
    blobs = blobs_of(marker, Placed(200, 200, 0.5, 60))
    t, z = WholeContours(blobs).laid([Shape.from_marker(marker)], ZERO, ZERO, 60)
    real = np.abs(z[0]) > 0
    assert 1 <= real.sum() < 20 and not real[real.sum() :].any() and np.isfinite(t).all()


def test_contours_of_any_length_are_sampled():
    labels = np.zeros((60, 60), np.uint8)
    labels[10:12, 10:12] = 1
    cv2.circle(labels, (40, 40), 12, 1, -1)
    config = RecognizerConfig(min_blob_px=3)
    blobs = find_blobs(labels, {1}, config)
    assert len(blobs) == 2
    t, z = WholeContours(blobs).laid([Shape.from_marker(flag())], np.arange(2), np.zeros(2, int), 4)
    assert np.isfinite(t).all() and np.isfinite(z).all() and np.abs(z[0, 0]) > np.abs(z[1, 0])
