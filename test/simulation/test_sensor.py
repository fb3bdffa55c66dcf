import numpy as np
import pytest

from artrec_ros.simulation.config import SensorConfig
from artrec_ros.simulation.render import Renderer
from artrec_ros.simulation.scene import Floor, Scene
from artrec_ros.simulation.sensor import (
    add_speckle,
    add_spots,
    colour_image,
    label_image,
    majority_labels,
    palette,
    segment,
)

from .test_render import plate

ALL = tuple(range(8))


@pytest.fixture
def rendering(camera):
    scene = Scene((), (plate(0, 0, 1.0, 0.3, 3),), Floor(np.array([0, -1.0, 0]), -0.3, 1))
    return Renderer(camera).render(scene)


def test_a_pixel_bears_the_class_that_fills_most_of_it():
    samples = np.zeros((6, 6), np.uint8)
    samples[:3, :2] = 4  # two thirds of the first pixel
    samples[3:, 3:4] = 4  # one third of the last
    assert majority_labels(samples).tolist() == [[4, 0], [0, 0]]


@pytest.mark.parametrize("gain", [0.65, 1.0, 1.1])
def test_segmentation_bears_light(gain):
    image = np.clip(palette()[None, 1:8] * gain, 0, 255).astype(np.uint8)
    assert segment(image, ALL).tolist() == [[1, 2, 3, 4, 5, 6, 7]]


def test_a_colour_of_no_class_is_unknown():
    assert segment(np.array([[[200, 0, 255]]], np.uint8), ALL).tolist() == [[0]]


def test_classes_have_different_colours():
    assert len(np.unique(palette()[:64], axis=0)) == 64


def test_an_ideal_sensor_shows_the_majority(rendering):
    ideal = SensorConfig().scaled(0)
    rng = np.random.default_rng(0)
    image = colour_image(rendering, ideal, rng)
    assert np.array_equal(label_image(rendering, image, ideal, rng), majority_labels(rendering.sample_labels))


def test_a_real_sensor_errs_mostly_at_edges(rendering):
    rng = np.random.default_rng(1)
    config = SensorConfig(light=0.0, blur_px=0.6, pixel_noise=0.02, speckle=0.0)
    labels = label_image(rendering, colour_image(rendering, config, rng), config, rng)
    truth = majority_labels(rendering.sample_labels)
    inner = np.zeros_like(truth, bool)
    inner[1:-1, 1:-1] = np.all(
        [truth[1 + i : 119 + i, 1 + j : 159 + j] == truth[1:-1, 1:-1] for i in (-1, 0, 1) for j in (-1, 0, 1)], axis=0
    )
    wrong = labels != truth
    assert wrong[inner].mean() < 0.01 < wrong[~inner].mean()


def test_speckle_hits_the_share_asked_for():
    labels = np.full((200, 200), 9, np.uint8)
    hit = add_speckle(labels, 0.05, (1, 2), np.random.default_rng(2)) != 9
    assert hit.mean() == pytest.approx(0.05, abs=0.005)


def test_light_varies_slowly_and_noise_fast(rendering):
    dark = colour_image(rendering, SensorConfig(0.5, 0, 0, 0), np.random.default_rng(3)).astype(float)
    grain = colour_image(rendering, SensorConfig(0, 0, 0.05, 0), np.random.default_rng(3)).astype(float)
    floor = np.s_[-30:, :, 1]
    steps = [np.abs(np.diff(i[floor], axis=1)).mean() for i in (dark, grain)]
    assert steps[0] < 4 < steps[1]
    assert dark[floor].std() > 5


def test_motion_smears_along_one_direction_and_keeps_the_light(rendering):
    still = colour_image(rendering, SensorConfig().scaled(0), np.random.default_rng(4)).astype(float)
    config = SensorConfig(0, 0, 0, 0, motion_blur_px=12.0)
    moved = colour_image(rendering, config, np.random.default_rng(4)).astype(float)
    assert moved.mean() == pytest.approx(still.mean(), rel=0.01)
    steps = [np.abs(np.diff(i, axis=0)).max() for i in (still, moved)]
    assert steps[1] < steps[0]


def test_spots_are_a_few_discs_of_known_classes():
    labels = np.full((300, 400), 9, np.uint8)
    counts = [np.mean(add_spots(labels, 5, (1, 2), np.random.default_rng(seed)) != 9) for seed in range(60)]
    assert min(counts) == 0 and 0.001 < np.mean(counts) < 5 * np.pi * 8.5**2 / labels.size
    spotted = add_spots(labels, 50, (1, 2), np.random.default_rng(1))
    assert set(np.unique(spotted)) == {1, 2, 9} and (labels == 9).all()
