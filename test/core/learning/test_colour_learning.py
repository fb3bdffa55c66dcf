"""Reference colours learned from samples: known colours, wrong samples, several colours, backgrounds."""

from __future__ import annotations

import numpy as np
import pytest

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.learning.colour_learning import learn_colours, sample_colours

RED, BLUE, GREEN, WHITE = (200, 40, 45), (40, 65, 170), (50, 140, 45), (215, 215, 215)


def shown(
    rgb: tuple[int, ...], count: int = 2000, seed: int = 0, light: tuple[float, float] = (0.6, 1.2)
) -> np.ndarray:
    """(n, 3) BGR of a colour in changing light, with noise."""
    rng = np.random.default_rng(seed)
    bgr = rng.uniform(*light, (count, 1)) * np.array(rgb[::-1]) + rng.normal(0, 4, (count, 3))
    return np.clip(np.rint(bgr), 0, 255).astype(np.uint8)


def direction(rgb: object) -> np.ndarray:
    vector = np.asarray(rgb, float)
    return vector / np.linalg.norm(vector)


def test_a_colour_is_found_again_in_the_light_that_is_usual() -> None:
    learned = learn_colours({"red": shown(RED), "blue": shown(BLUE)}, {"red": 3, "blue": 2}, ImageConfig())
    for name, rgb in (("red", RED), ("blue", BLUE)):
        reference = learned.image.classes[name].rgb
        assert len(reference) == 3
        assert direction(reference) @ direction(rgb) > np.cos(np.deg2rad(2))
        assert np.linalg.norm(reference) == pytest.approx(0.9 * np.linalg.norm(rgb), rel=0.1)
        assert learned.confusion[name][name] > 0.99
    assert learned.image.kind == "colour" and learned.image.background == ()


def test_what_was_learned_bears_shade_that_was_never_shown() -> None:
    learned = learn_colours({"red": shown(RED), "blue": shown(BLUE)}, {"red": 3, "blue": 2}, ImageConfig())
    deep = shown(RED, light=(0.4, 0.5), seed=4)
    assert (Segmenter(learned.image).labels(deep[None]) == 3).mean() > 0.98


def test_wrong_samples_do_not_pull_a_reference() -> None:
    mixed = np.concatenate([shown(RED), shown(GREEN, 400, seed=1), np.zeros((500, 3), np.uint8)])
    clean = learn_colours({"red": shown(RED)}, {"red": 3}, ImageConfig()).image.classes["red"].rgb
    first = learn_colours({"red": mixed}, {"red": 3}, ImageConfig()).image.classes["red"].rgb[:3]
    np.testing.assert_allclose(first, clean, atol=5)


def test_a_class_of_two_colours_gets_two_references() -> None:
    both = np.concatenate([shown(RED), shown(GREEN, 1500, seed=1)])
    rgb = learn_colours({"accent": both}, {"accent": 3}, ImageConfig()).image.classes["accent"].rgb
    references = np.reshape(rgb, (-1, 3))
    assert len(references) == 2
    assert direction(references[0]) @ direction(RED) > 0.999 and direction(references[1]) @ direction(GREEN) > 0.999


def test_what_is_no_class_becomes_background_unless_it_is_a_class_colour() -> None:
    floor = (120, 90, 60)
    samples = {"red": shown(RED), "label 0": np.concatenate([shown(floor), shown(RED, seed=7)])}
    learned = learn_colours(samples, {"red": 3}, ImageConfig(), doubtful=["label 0"])
    assert len(learned.image.background) == 3
    assert direction(learned.image.background) @ direction(floor) > 0.999


def test_a_background_keeps_the_classes_from_its_colour() -> None:
    brown = (150, 70, 60)
    alone = learn_colours({"red": shown(RED)}, {"red": 3}, ImageConfig())
    beside = learn_colours({"red": shown(RED), "wood": shown(brown)}, {"red": 3}, ImageConfig())
    image = shown(brown, seed=9)[None]
    taken = [(Segmenter(learned.image).labels(image) == 3).mean() for learned in (alone, beside)]
    assert taken[1] < 0.02 < taken[0]
    assert beside.confusion["red"]["red"] > 0.98


@pytest.mark.parametrize("pixels, words", [(0, "'red': 0 pixels"), (5, "'red': 5 pixels")])
def test_a_class_that_is_hardly_seen_is_refused(pixels: int, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        learn_colours({"red": shown(RED, pixels)}, {"red": 3}, ImageConfig())


def test_a_class_of_black_pixels_is_refused() -> None:
    with pytest.raises(ConfigError, match="'black'.*too dark"):
        learn_colours({"black": np.full((500, 3), 4, np.uint8)}, {"black": 3}, ImageConfig())


def test_samples_leave_out_edges_and_numbers_without_a_name() -> None:
    labels = np.zeros((30, 40), np.uint8)
    labels[10:20, 10:20] = 3
    labels[25:28, 30:33] = 9
    image = np.repeat(labels[..., None], 3, axis=2) * 10
    image[10, 10:20] = 255  # an edge
    found = sample_colours(image, labels, {0: "rest", 3: "red"}, np.random.default_rng(0))
    assert sorted(found) == ["red", "rest"]
    assert len(found["red"]) == 8 * 8 and (found["red"] == 30).all()
    assert (found["rest"] == 0).all()
