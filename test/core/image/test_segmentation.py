"""Images to class labels: known truth, laws of the colour table, refusals."""

from __future__ import annotations

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.config import ClassConfig, ImageConfig
from artrec_ros.core.base.errors import ConfigError, ImageError
from artrec_ros.core.image.segmentation import Segmenter

RED = ClassConfig(label=2, hue=(340, 20), saturation=(0.5, 1), value=(0.3, 1))
GREEN = ClassConfig(label=3, hue=(90, 150), saturation=(0.5, 1), value=(0.3, 1))
PALE = ClassConfig(label=1, saturation=(0, 0.3), value=(0.5, 1))


def colour(**options: object) -> Segmenter:
    return Segmenter(ImageConfig(kind="colour", classes={"red": RED, "green": GREEN, "pale": PALE}, **options))


def scene(brightness: float = 1.0) -> np.ndarray:
    """Dark floor with a pale bar that covers a tenth, a red and a green square on it."""
    image = np.full((200, 300, 3), 12.0)
    image[80:120, 50:200] = (200, 210, 205)
    image[90:110, 60:80] = (20, 25, 150)
    image[90:110, 150:170] = (40, 120, 30)
    return np.clip(image * brightness + 0.5, 0, 255).astype(np.uint8)


def expected() -> np.ndarray:
    labels = np.zeros((200, 300), np.uint8)
    labels[80:120, 50:200] = 1
    labels[90:110, 60:80] = 2
    labels[90:110, 150:170] = 3
    return labels


def test_labels_pass_through_and_large_numbers_become_unknown():
    image = np.array([[0, 7, 252]], np.uint8)
    assert np.array_equal(Segmenter(ImageConfig()).labels(image), image)
    wide = np.array([[0, 7, 252, 253, 255, 256, 65535]], np.uint16)
    labels = Segmenter(ImageConfig()).labels(wide)
    assert labels.dtype == np.uint8
    assert labels.tolist() == [[0, 7, 252, 0, 0, 0, 0]]


def test_a_read_only_image_is_blanked_in_a_copy():
    image = np.ones((4, 6), np.uint8)
    image.setflags(write=False)
    labels = Segmenter(ImageConfig(blank=(4, 1, 99, 2, 0, 3, 1, 1))).labels(image)
    assert labels.tolist() == [[1] * 6, [1] * 4 + [0] * 2, [1] * 4 + [0] * 2, [0] + [1] * 5]
    assert image.all()


def test_palette_matches_exact_colours_and_its_first_class_wins():
    classes = {
        "field": ClassConfig(label=1, rgb=(0, 90, 0)),
        "team": ClassConfig(label=3, rgb=(255, 0, 0, 200, 0, 10)),
        "late": ClassConfig(label=9, rgb=(255, 0, 0)),
    }
    rgb = np.array([[[0, 90, 0], [255, 0, 0], [200, 0, 10], [254, 0, 0], [0, 0, 255]]], np.uint8)
    bgr = np.ascontiguousarray(rgb[..., ::-1])
    assert Segmenter(ImageConfig(kind="palette", classes=classes)).labels(bgr).tolist() == [[1, 3, 3, 0, 0]]
    near = Segmenter(ImageConfig(kind="palette", classes=classes, tolerance=1))
    assert near.labels(bgr).tolist() == [[1, 3, 3, 3, 0]]


def test_colour_classes_are_found_where_they_are():
    assert np.array_equal(colour().labels(scene()), expected())


def test_the_first_colour_class_wins_where_two_overlap():
    whole, half = ClassConfig(label=5), ClassConfig(label=6, value=(0.5, 1))
    image = np.array([[[255, 255, 255], [10, 10, 10]]], np.uint8)
    first = Segmenter(ImageConfig(kind="colour", classes={"half": half, "whole": whole}))
    assert first.labels(image).tolist() == [[6, 5]]
    last = Segmenter(ImageConfig(kind="colour", classes={"whole": whole, "half": half}))
    assert last.labels(image).tolist() == [[5, 5]]


@pytest.mark.parametrize(
    "hue, hit", [((350, 20), True), ((20, 350), False), ((0, 360), True), ((90, 150, 355, 5), True)]
)
def test_hue_ranges_may_pass_360_and_be_several(hue: tuple[float, ...], hit: bool):
    red = np.full((2, 2, 3), (0, 0, 255), np.uint8)
    labels = Segmenter(ImageConfig(kind="colour", classes={"c": ClassConfig(label=4, hue=hue)})).labels(red)
    assert labels.tolist() == [[4 * hit] * 2] * 2


def test_table_agrees_with_hsv_of_every_pixel_away_from_the_ranges_ends():
    rng = np.random.default_rng(3)
    image = rng.integers(0, 256, (120, 120, 3), dtype=np.uint8)
    h, s, v = cv2.split(cv2.cvtColor(image.astype(np.float32) / 255, cv2.COLOR_BGR2HSV))
    labels = Segmenter(ImageConfig(kind="colour", classes={"green": GREEN})).labels(image)
    well_inside = (np.abs(h - 120) < 20) & (s > 0.6) & (v > 0.4)
    well_outside = (np.abs(h - 120) > 42) | (s < 0.4) | (v < 0.25)
    assert well_inside.sum() > 100
    assert (labels[well_inside] == 3).all()
    assert not labels[well_outside].any()


@pytest.mark.parametrize("brightness", [0.3, 0.6, 1.0, 1.2])
def test_gain_makes_labels_stand_a_change_of_light(brightness: float):
    segmenter = colour(gain_percentile=95.0, gain_level=0.8)
    assert np.array_equal(segmenter.labels(scene(brightness)), expected())
    if brightness < 0.5:
        assert not np.array_equal(colour().labels(scene(brightness)), expected())


def test_gain_does_not_look_at_blanked_pixels():
    image = scene(0.3)
    image[:40, :150] = 255
    options = {"gain_percentile": 95.0, "gain_level": 0.8}
    assert np.array_equal(colour(blank=(0, 0, 150, 40), **options).labels(image), expected())
    assert not np.array_equal(colour(**options).labels(image), expected())


def test_gain_is_limited_so_that_a_black_frame_stays_background():
    noise = np.random.default_rng(1).integers(0, 4, (200, 300, 3)).astype(np.uint8)
    assert not colour(gain_percentile=95.0).labels(noise).any()


def test_smoothing_removes_single_pixels_and_leaves_its_input():
    image = scene()
    image[::5, ::5] = 12
    before = image.copy()
    speckled, smooth = colour().labels(image), colour(smoothing_px=1.0).labels(image)
    inner = np.s_[84:116, 100:140]
    assert (speckled[inner] == 0).any()
    assert (smooth[inner] == 1).all()
    assert np.array_equal(image, before)


@pytest.mark.parametrize(
    "kind, image, words",
    [
        ("labels", np.zeros((4, 4, 3), np.uint8), "3 channels of uint8.* indexed PNG"),
        ("labels", np.zeros((4, 4), np.float32), "1 channel of float32"),
        ("colour", np.zeros((4, 4), np.uint8), "1 channel of uint8"),
        ("colour", np.zeros((4, 4, 4), np.uint8), "4 channels of uint8"),
        ("palette", np.zeros((4, 4), np.uint16), "1 channel of uint16"),
        ("colour", np.zeros((0, 4, 3), np.uint8), "empty"),
    ],
)
def test_an_image_that_does_not_fit_is_refused_in_one_line(kind: str, image: np.ndarray, words: str):
    segmenter = Segmenter(ImageConfig(kind=kind, classes={"c": ClassConfig(label=1, rgb=(1, 2, 3))}))
    with pytest.raises(ImageError, match=words) as error:
        segmenter.labels(image)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "options, words",
    [
        ({"blank": (1, 2, 3)}, "image.blank: 3 numbers"),
        ({"blank": (-1, 2, 3, 4)}, "image.blank: -1"),
        ({"kind": "colour"}, "image.classes: none"),
        ({"kind": "grey"}, "image.kind: 'grey' is none of"),
        ({"classes": {"a": ClassConfig(label=0)}}, "image.a.label: 0 is below"),
        ({"classes": {"a": ClassConfig(label=1, hue=(3,))}}, "image.a.hue"),
        ({"classes": {"a": ClassConfig(label=1, value=(0.5, 0.2))}}, "image.a.value"),
        ({"classes": {"a": ClassConfig(label=1, saturation=(0.5,))}}, "image.a.saturation"),
        ({"kind": "palette", "classes": {"a": ClassConfig(label=1)}}, "image.a.rgb"),
        ({"classes": {"a": ClassConfig(label=1, rgb=(0, 0, 300))}}, "image.a.rgb: 300 is above"),
    ],
)
def test_parameters_that_make_no_sense_are_refused_by_name(options: dict, words: str):
    with pytest.raises(ConfigError, match=words):
        ImageConfig(**options)
