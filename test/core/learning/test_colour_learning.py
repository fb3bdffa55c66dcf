"""Reference colours learned from samples: known colours, wrong samples, several colours, backgrounds."""

from __future__ import annotations

import itertools

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.config import ClassConfig, ImageConfig, LearningConfig
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.image.colour_table import colour_table
from artrec_ros.core.image.segmentation import Segmenter, packed
from artrec_ros.core.learning import colour_learning
from artrec_ros.core.learning.colour_counts import worth
from artrec_ros.core.learning.colour_learning import (
    _Draw,
    choose_sharpening,
    learn_colours,
    sample_beside,
    sample_colours,
)

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
    assert direction(first) @ direction(clean) > np.cos(np.deg2rad(1.5))


def test_a_class_of_two_colours_gets_two_references() -> None:
    both = np.concatenate([shown(RED), shown(GREEN, 1500, seed=1)])
    rgb = learn_colours({"accent": both}, {"accent": 3}, ImageConfig()).image.classes["accent"].rgb
    references = np.reshape(rgb, (-1, 3))
    assert len(references) == 2
    assert direction(references[0]) @ direction(RED) > 0.999 and direction(references[1]) @ direction(GREEN) > 0.999


def test_a_white_sheet_is_no_half_class() -> None:
    """Though many of a class' own pixels are nearly grey: a background's reference need not reach into the shade."""
    green = np.concatenate([shown((121, 185, 112), 60), shown((165, 178, 160), 120, seed=1)])
    sheet = np.full((3000, 3), 255, np.uint8)
    samples = {"green": green, "red": shown(RED, 100), "sheet": sheet, "floor": shown((90, 68, 45), seed=3)}
    learned = learn_colours(samples, {"green": 1, "red": 2}, ImageConfig())
    table, meaning = colour_table(learned.image)
    white, own = (meaning.share[table[packed(colours[None])[0]]][:, 1].mean() for colours in (sheet, green))
    assert white < 0.05 and own > 0.85
    assert learned.confusion["sheet"].get("green", 0.0) == pytest.approx(white, abs=0.02)
    assert learned.confusion["green"]["green"] == pytest.approx(own, abs=0.02)


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


def test_where_a_lens_blurs_samples_keep_farther_from_edges() -> None:
    labels = np.zeros((60, 60), np.uint8)
    labels[20:40, 20:40] = 3
    depth = cv2.distanceTransform((labels == 3).astype(np.uint8), cv2.DIST_C, 3)
    away = cv2.distanceTransform((labels == 0).astype(np.uint8), cv2.DIST_C, 3)
    image = np.repeat(np.where(labels == 3, depth, away).astype(np.uint8)[..., None], 3, axis=2)
    least = {}
    for blur_px in (0.0, 2.0):
        found = sample_colours(image, labels, {0: "floor", 3: "red"}, np.random.default_rng(0), blur_px)
        beside = sample_beside(image, labels, 255, np.random.default_rng(0), blur_px)
        least[blur_px] = [int(colours.min()) for colours in (found["red"], found["floor"], beside)]
    assert (np.subtract(least[2.0], least[0.0]) >= 1).all(), least


def test_what_lies_beside_markers_is_sampled_by_itself() -> None:
    """Not an edge's blur, nor what lies farther off than a third of a marker's width, nor what is beside what is
    ignored."""
    labels = np.zeros((60, 120), np.uint8)
    labels[15:45, 15:45] = 3
    labels[15:45, 80:110] = 255
    image = np.repeat(np.where(labels == 0, 90, 10).astype(np.uint8)[..., None], 3, axis=2)
    off = cv2.distanceTransform((labels != 3).astype(np.uint8), cv2.DIST_L2, 5)
    image[off > 10] = 200
    image[(off > 0) & (off <= 2)] = 30
    found = sample_beside(image, labels, 255, np.random.default_rng(0))
    assert len(found) > 500 and (found == 90).all()
    labels[15:45, 15:45] = 0
    assert len(sample_beside(image, labels, 255, np.random.default_rng(0))) == 0


def test_a_grey_floor_is_kept_and_stays_background_in_the_shade() -> None:
    """Grey has no colour of its own, yet keeps a pale class from eating the floor."""
    pale, grey = (190, 190, 150), (110, 108, 100)
    samples = {"pale": shown(pale, light=(0.9, 1.1)), "floor": shown(grey, light=(0.7, 1.2), seed=5)}
    learned = learn_colours(samples, {"pale": 3}, ImageConfig())
    assert learned.image.background
    assert (Segmenter(learned.image).labels(shown(grey, light=(0.7, 1.2), seed=6)[None]) == 3).mean() < 0.03
    assert learned.confusion["pale"]["pale"] > 0.9


def test_a_class_in_several_lights_is_told_in_each_whatever_the_first_was() -> None:
    """Yellow that a bright frame clips is no yellow ray in more light; wood is warmer than either."""
    dull, clipped, wood = (150, 165, 80), (250, 245, 205), (120, 100, 80)
    lights = [shown(dull, 600, light=(0.9, 1.1)), shown(clipped, 600, light=(0.95, 1.0), seed=1)]
    floor = shown(wood, light=(0.5, 1.3), seed=2)
    for order in (lights, lights[::-1]):
        samples = {"yellow": np.concatenate(order), "floor": floor}
        learned = learn_colours(samples, {"yellow": 1}, ImageConfig())
        segmenter = Segmenter(learned.image)
        assert [(segmenter.labels(seen[None]) == 1).mean() > 0.9 for seen in lights] == [True, True]
        assert (segmenter.labels(floor[None]) == 1).mean() < 0.03
        assert len(learned.image.classes["yellow"].rgb) >= 6


def test_patches_without_any_pixel_off_their_edge_give_their_deepest() -> None:
    labels = np.zeros((30, 40), np.uint8)
    for x in range(3, 36, 6):
        labels[5:7, x : x + 4] = 3
        labels[20:23, x : x + 3] = 3
    found = sample_colours(np.repeat(labels[..., None], 3, axis=2), labels, {3: "red"}, np.random.default_rng(0))
    assert len(found["red"]) >= 6 and (found["red"] == 3).all()


@pytest.mark.parametrize("blur, width, sharpened", [(0.0, 8, 0), (0.0, 102, 1), (1.1, 8, 1), (1.1, 102, 1)])
def test_sharpening_is_chosen_by_what_it_brings(blur: float, width: int, sharpened: int) -> None:
    """Blue on white, whose blends are sky blue: sharp patches have nothing to gain, and size decides."""
    labels = np.zeros((80, 120), np.uint8)
    for y in range(6, 70, 14):
        labels[y : y + 6, 8 : 8 + width] = 2
    rgb = np.where(labels[..., None] == 2, BLUE, WHITE).astype(np.float32)
    if blur:
        rgb = cv2.GaussianBlur(rgb, (0, 0), blur)
    image = np.clip(np.rint(rgb[..., ::-1] + np.random.default_rng(1).normal(0, 3, rgb.shape)), 0, 255).astype(np.uint8)
    classes = {"blue": ClassConfig(label=2, rgb=BLUE), "sky": ClassConfig(label=7, rgb=(127, 140, 192))}
    config = ImageConfig(kind="colour", classes=classes, background=WHITE)
    chosen = choose_sharpening(config, [(image, labels)], {0: 0, 2: 2})
    assert chosen.sharpen_px == sharpened


class WorseIfSharpened:
    """A segmenter that knows what is marked, and less of some classes in a sharpened image."""

    worse: tuple[int, ...] = ()

    def __init__(self, config: ImageConfig) -> None:
        self._lost = config.sharpen_px > 0

    def labels(self, image: np.ndarray) -> np.ndarray:
        read = image[..., 0].copy()
        if self._lost:
            read[:, ::3] = np.where(np.isin(read[:, ::3], self.worse), 9, read[:, ::3])
        return read


@pytest.mark.parametrize(
    "width, around, worse, sharpened",
    [(8, 255, (0,), 0), (60, 255, (0,), 1), (60, 255, (2,), 0), (8, 0, (0, 2), 0), (60, 0, (0, 2), 0)],
)
def test_where_nobody_has_told_the_edges_size_decides_on_sharpening(
    monkeypatch: pytest.MonkeyPatch, width: int, around: int, worse: tuple[int, ...], sharpened: int
) -> None:
    """What is inside of a region says nothing of where the marker ends, but that it becomes speckled."""
    monkeypatch.setattr(colour_learning, "Segmenter", WorseIfSharpened)
    monkeypatch.setattr(WorseIfSharpened, "worse", worse)
    marked = np.full((120, 100), around, np.uint8)
    marked[10 : 10 + width, 8 : 8 + width] = 2
    marked[100:] = 0  # what is background, elsewhere
    image = np.repeat(np.where(marked == 255, 0, marked)[..., None], 3, axis=2)
    assert choose_sharpening(ImageConfig(), [(image, marked)], {0: 0, 2: 2}).sharpen_px == sharpened


def test_of_several_draws_the_one_is_kept_that_tells_best() -> None:
    """A dull yellow near the floor's colour: some draws of few samples lose half of it, or take the floor for it."""
    samples = {
        "yellow": np.concatenate([shown((190, 170, 60), 3000, light=(0.5, 1.4)), shown((230, 225, 150), 500, seed=3)]),
        "violet": shown((120, 80, 140), 3000, seed=1, light=(0.4, 1.3)),
        "floor": np.concatenate([shown((150, 140, 90), 4000, seed=2, light=(0.5, 1.3)), shown(WHITE, 500, seed=5)]),
    }
    labels = {"yellow": 1, "violet": 2}
    kept = learn_colours(samples, labels, ImageConfig()).image
    tried = itertools.product(range(LearningConfig().draws), LearningConfig().weights_background)
    draws = [
        _Draw.of(samples, labels, ImageConfig(), (), seed).learned(labels, ImageConfig(), weight)
        for seed, weight in tried
    ]
    worths = [each for each, _, _ in draws]
    assert kept == draws[int(np.argmax(worths))][1] and min(worths) < max(worths)


def test_samples_are_looked_at_once_for_all_weights_of_the_background(monkeypatch: pytest.MonkeyPatch) -> None:
    """Their candidates and likelihoods are the same; a table of all colours is for images, not for samples."""
    offers = list[object]()
    of = colour_learning.Offer.of
    monkeypatch.setattr(colour_learning.Offer, "of", lambda *given: offers.append(of(*given)) or offers[-1])
    monkeypatch.setattr(colour_learning, "Segmenter", None)
    learn_colours({"red": shown(RED), "floor": shown(WHITE)}, {"red": 3}, ImageConfig())
    assert len(offers) == LearningConfig().draws


def test_what_is_lost_beside_markers_is_not_made_up_for_elsewhere() -> None:
    """An image has little of it: its outlines are lost while nearly all of the background is told."""
    image = ImageConfig(kind="colour", classes={"red": ClassConfig(1, RED)})

    def told(unmarked: float, beside: float) -> float:
        shares = {"unmarked": 1 - unmarked, "beside markers": 1 - beside, "red": 0.95}
        red, blue = (np.array(rgb[::-1], np.uint8) for rgb in (RED, BLUE))
        samples = {name: np.where(np.arange(100)[:, None] < 100 * share, red, blue) for name, share in shares.items()}
        return worth(samples, image)

    assert told(0.84, 0.85) > told(1.0, 0.70)


@pytest.mark.parametrize("width, sharpened", [(14, 0), (40, 1)])
def test_of_regions_drawn_inside_of_markers_the_markers_are_measured(width: int, sharpened: int) -> None:
    """Small boxes in the middle of large patches once had these taken for small ones."""
    labels = np.zeros((120, 120), np.uint8)
    labels[20 : 20 + width, 20 : 20 + width] = 2
    image = np.where(labels[..., None] == 2, BLUE, WHITE)[..., ::-1].astype(np.uint8)
    marked = np.full_like(labels, 255)
    middle = 20 + width // 2
    marked[middle - 4 : middle + 4, middle - 4 : middle + 4] = 2
    marked[100:] = 0
    config = ImageConfig(kind="colour", classes={"blue": ClassConfig(label=2, rgb=BLUE)}, background=WHITE)
    assert choose_sharpening(config, [(image, marked)], {0: 0, 2: 2}).sharpen_px == sharpened
