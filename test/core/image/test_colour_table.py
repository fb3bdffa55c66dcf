"""Classes given by reference colours: laws of light and shade, noise, and what is like no class."""

from __future__ import annotations

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from artrec_ros.core.base.config import ClassConfig, ImageConfig
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.image.colour_table import colour_table, named
from artrec_ros.core.image.segmentation import Segmenter, _wiener, deblur, filtered, sharpen, unblur

RED, BLUE, GREEN, WHITE, SKY = (200, 40, 45), (40, 65, 170), (50, 140, 45), (215, 215, 215), (75, 180, 230)
CLASSES = {
    name: ClassConfig(label=n, rgb=rgb)
    for n, (name, rgb) in enumerate(
        {"red": RED, "blue": BLUE, "green": GREEN, "white": WHITE, "sky": SKY}.items(), start=1
    )
}
CHROMATIC = [(RED, 1), (BLUE, 2), (GREEN, 3), (SKY, 5)]
GREY = (75, 72, 72)
SEGMENTER = Segmenter(ImageConfig(kind="colour", classes=CLASSES, background=GREY))
BARE = Segmenter(ImageConfig(kind="colour", classes={k: c for k, c in CLASSES.items() if k != "white"}))


def test_few_colours_are_named_as_the_table_names_them() -> None:
    codes = np.random.default_rng(0).integers(0, 1 << 16, 3000).astype(np.uint16)
    gold = ClassConfig(label=7, hue=(40.0, 50.0), saturation=(0.5, 1.0))  # one class of ranges, and two of one label
    twice = ClassConfig(label=2, rgb=(20, 20, 90))
    config = ImageConfig(kind="colour", classes={**CLASSES, "gold": gold, "navy": twice}, background=GREY)
    table, meaning = colour_table(config)
    labels = meaning.label[table]
    assert {*range(8)} - {6} == {*labels.tolist()}
    np.testing.assert_array_equal(named(config, codes), labels[codes])


def test_who_sharpens_otherwise_has_the_same_table() -> None:
    plain, sharpened = (ImageConfig(kind="colour", classes=CLASSES, sharpen_px=radius) for radius in (0, 1))
    assert colour_table(plain)[0] is colour_table(sharpened)[0]
    other = ImageConfig(kind="colour", classes=CLASSES, noise=2 * plain.noise)
    assert (colour_table(other)[0] != colour_table(plain)[0]).any()


def field(rgb: tuple[float, ...], shape: tuple[int, int] = (40, 60)) -> np.ndarray:
    return np.tile(np.array(rgb[::-1], float), (*shape, 1))


def as_image(values: np.ndarray) -> np.ndarray:
    return np.clip(np.rint(values), 0, 255).astype(np.uint8)


@given(st.sampled_from(CHROMATIC), st.floats(0.36, 1.7))
def test_light_and_shade_leave_a_colour_its_label(reference: tuple[tuple[int, ...], int], light: float) -> None:
    rgb, label = reference
    assert (SEGMENTER.labels(as_image(light * field(rgb, (1, 1)))) == label).all()


@pytest.mark.parametrize("rgb, label", CHROMATIC)
def test_a_class_may_be_told_to_bear_deeper_shade(rgb: tuple[int, ...], label: int) -> None:
    image = as_image(0.25 * field(rgb))
    for deepest, hit in ((0.2, True), (0.7, False)):
        cls = ClassConfig(label=label, rgb=rgb, light=(deepest, 1.8))
        assert (Segmenter(ImageConfig(kind="colour", classes={"c": cls})).labels(image) == label * hit).all()


@pytest.mark.parametrize("rgb, label", CHROMATIC)
@pytest.mark.parametrize("light", [0.45, 1.0])
def test_a_shaded_colour_keeps_its_label_under_noise(rgb: tuple[int, ...], label: int, light: float) -> None:
    noise = np.random.default_rng(5).normal(0, 5, (40, 60, 3))
    labels = SEGMENTER.labels(as_image(light * field(rgb) + noise))
    assert (labels == label).mean() > 0.96


@pytest.mark.parametrize("level", [8, 20, 40, 75, 120, 200])
def test_grey_noise_gets_no_chromatic_label(level: int) -> None:
    noise = np.random.default_rng(level).normal(0, 4, (100, 100, 3))
    assert (BARE.labels(as_image(field((level,) * 3, (100, 100)) + noise)) > 0).mean() < 0.005


def test_brightness_alone_tells_white_in_the_shade_from_a_grey_wall() -> None:
    ramp = np.tile(np.arange(30, 256, dtype=np.uint8)[None, :, None], (1, 1, 3))
    white = SEGMENTER.labels(ramp)[0] == 4
    assert np.count_nonzero(np.diff(white.astype(int))) == 1  # dark is grey, bright is white, one border
    border = 30 + int(np.argmax(white))
    assert border == pytest.approx(np.sqrt(72 * 215), rel=0.05)  # equally far from both in light
    without = Segmenter(ImageConfig(kind="colour", classes=CLASSES)).labels(ramp)[0] == 4
    assert np.argmax(without) < np.argmax(white)


def test_a_colour_like_no_class_is_unknown() -> None:
    assert not SEGMENTER.labels(as_image(field((200, 60, 200)))).any()  # magenta


def test_greater_scatter_takes_in_more_colours() -> None:
    classes = [ClassConfig(label=1, rgb=RED, spread=spread) for spread in (0.02, 0.05, 0.08)]
    tables = [colour_table(ImageConfig(kind="colour", classes={"c": cls})) for cls in classes]
    counts = [np.count_nonzero(meaning.label[table]) for table, meaning in tables]
    assert 0 < counts[0] < counts[1] < counts[2]


def test_several_references_are_one_class() -> None:
    accents = Segmenter(ImageConfig(kind="colour", classes={"accent": ClassConfig(label=9, rgb=(*RED, *GREEN))}))
    for rgb, label in ((RED, 9), (GREEN, 9), (BLUE, 0)):
        assert (accents.labels(as_image(0.6 * field(rgb))) == label).all()


def test_ranges_go_before_references() -> None:
    hue = ClassConfig(label=8, hue=(220, 235), saturation=(0.5, 1))
    both = Segmenter(ImageConfig(kind="colour", classes={**CLASSES, "hue": hue}))
    assert (both.labels(as_image(field(BLUE))) == 8).all()
    assert (both.labels(as_image(field(RED))) == 1).all()


def blurred_square(sigma: float) -> tuple[np.ndarray, np.ndarray]:
    """A blue square on white through a lens and JPEG, and its true labels."""
    truth = np.full((60, 80), 4, np.uint8)
    truth[20:40, 30:50] = 2
    sharp = np.where((truth == 2)[..., None], field(BLUE, truth.shape), field(WHITE, truth.shape))
    blurred = as_image(cv2.GaussianBlur(sharp, (0, 0), sigma))
    encoded = cv2.imencode(".jpg", blurred, [cv2.IMWRITE_JPEG_QUALITY, 90])[1]
    return cv2.imdecode(encoded, cv2.IMREAD_COLOR), truth


def test_of_ranges_that_share_colours_the_first_listed_class_wins_be_its_label_anothers() -> None:
    chosen = {"saturation": (0.4, 1.0)}
    green, red = ClassConfig(label=1, hue=(100, 140), **chosen), ClassConfig(label=2, hue=(350, 20), **chosen)
    wider = ClassConfig(label=1, hue=(340, 10), **chosen)
    crimson = np.full((1, 1, 3), (40, 40, 220), np.uint8)
    for classes, label in (({"a": green, "b": red, "c": wider}, 2), ({"a": green, "c": wider, "b": red}, 1)):
        assert Segmenter(ImageConfig(kind="colour", classes=classes)).labels(crimson).item() == label


def test_every_label_there_may_be_can_be_a_colour_before_a_background() -> None:
    colours = cv2.cvtColor(
        np.array([[(i * 0.7 % 180, 255 - i % 4 * 40, 255 - i % 9 * 20) for i in range(252)]], np.uint8),
        cv2.COLOR_HSV2RGB,
    )[0]
    classes = {f"c{i}": ClassConfig(label=i + 1, rgb=tuple(map(int, rgb))) for i, rgb in enumerate(colours)}
    table, meaning = colour_table(ImageConfig(kind="colour", classes=classes, background=(128, 128, 128)))
    assert table.max() < 253 and set(meaning.label[table].tolist()) > set(range(1, 200))


def test_sharpening_undoes_blends_that_look_like_a_third_class() -> None:
    image, truth = blurred_square(0.8)
    plain = SEGMENTER.labels(image)
    sharp = Segmenter(ImageConfig(kind="colour", classes=CLASSES, background=GREY, sharpen_px=1)).labels(image)
    assert (plain == 5).sum() > 40  # sky blue between blue and white
    assert (sharp == 5).sum() < 0.2 * (plain == 5).sum()
    assert (sharp == 2).sum() == pytest.approx((truth == 2).sum(), rel=0.06)


def test_a_ribbon_too_narrow_for_its_colour_gets_its_label() -> None:
    truth = np.zeros((40, 60), bool)
    truth[5:35, 20:22] = truth[18:20, 30:55] = True
    sharp = np.where(truth[..., None], field(BLUE), field(WHITE))
    image = as_image(cv2.GaussianBlur(sharp, (0, 0), 1.0))
    hits = {}
    for amount in (0.0, 0.5):
        options = {"classes": CLASSES, "background": GREY, "sharpen_px": 1, "sharpen_amount": amount}
        hits[amount] = (Segmenter(ImageConfig(kind="colour", **options)).labels(image)[truth] == 2).mean()
    assert hits[0.5] > 0.9 > hits[0.0]


def test_unblurring_keeps_plain_colours() -> None:
    image = as_image(field(BLUE))
    assert np.array_equal(unblur(image, 1, 0.5), image)
    assert np.array_equal(deblur(image, 1.5, 0.03), image)


@pytest.mark.parametrize(("blur_px", "side_px"), [(1.5, 4), (2.0, 5)])
def test_a_known_blur_is_undone(blur_px: float, side_px: int) -> None:
    """Patches too small to reach their colour have it again, and are as large as they are."""
    truth = np.zeros((48, 48), bool)
    for y in range(4, 44, 12):
        for x in range(4, 44, 12):
            truth[y : y + side_px, x : x + side_px] = True
    sharp = np.where(truth[..., None], np.float32((190, 40, 45)), np.float32(90))[..., ::-1]
    image = as_noisy(cv2.GaussianBlur(sharp, (0, 0), blur_px))
    inside = cv2.erode(truth.astype(np.uint8), np.ones((3, 3), np.uint8)) > 0
    error = {px: np.abs(deblurred(image, px).astype(float) - sharp)[inside].mean() for px in (0.0, blur_px)}
    assert error[blur_px] < 0.6 * error[0.0]
    assert np.abs(np.mean(deblurred(image, blur_px) - image.astype(float))) < 1


@pytest.mark.parametrize("blur_px", [0.5, 0.9, 1.5, 2.0, 4.0])
@pytest.mark.parametrize("noise", [0.001, 0.03, 0.1, 1.0])
def test_the_filter_is_wieners_at_all_frequencies(blur_px: float, noise: float) -> None:
    taps = _wiener(blur_px, noise)
    reach, n = len(taps) // 2, 512
    spread = np.zeros(n)
    spread[: reach + 1], spread[-reach:] = taps[reach:], taps[:reach]
    blurred = np.exp(-2 * (np.pi * blur_px * np.fft.fftfreq(n)) ** 2)
    wanted = blurred / (blurred**2 + noise * (1 - blurred**2))
    assert np.abs(np.fft.fft(spread).real - wanted).max() < 0.02 * wanted.max() + 0.02


def lit_square(blur_px: float, noise: float) -> tuple[np.ndarray, np.ndarray]:
    """A bright red square on a dark ground, whose light a lens blends and a camera tells as values, and where it is."""
    truth = np.zeros((60, 60), bool)
    truth[18:42, 18:42] = True
    light = np.where(truth[..., None], np.float64((200, 60, 60)), 50.0)[..., ::-1] / 255
    values = 255 * cv2.GaussianBlur(light**2.2, (0, 0), blur_px) ** (1 / 2.2)
    noisy = values + np.random.default_rng(0).normal(0, noise, values.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8), truth


def test_undone_blur_brings_no_noise_of_bright_things_into_the_dark() -> None:
    image, truth = lit_square(1.5, 2.0)
    plain, undone = (filtered(image, ImageConfig(blur_px=px, gamma=2.2)).astype(float) for px in (0.0, 1.5))
    beside = (cv2.dilate(truth.astype(np.uint8), np.ones((9, 9), np.uint8)) > 0) & ~truth
    hue = [(v.max(axis=2) - v.min(axis=2))[beside].mean() for v in (plain, undone)]
    assert hue[1] < hue[0]
    assert undone[beside].min() > 20


@pytest.mark.parametrize("blur_px", [0.8, 1.2])
def test_edges_are_sharpened_where_half_of_the_light_is(blur_px: float) -> None:
    """A bright half of a dark image, its edge at a slant."""
    y, x = np.mgrid[:480, :480] / 8
    covered = cv2.resize((x + 0.3 * y < 39).astype(np.float64), (60, 60), interpolation=cv2.INTER_AREA)
    light = cv2.GaussianBlur(covered * (0.8**2.2 - 0.2**2.2) + 0.2**2.2, (0, 0), blur_px)
    image = np.repeat(np.rint(255 * light ** (1 / 2.2)).astype(np.uint8)[..., None], 3, axis=2)
    off_px = [((sharpen(image, 2, 0.16, gamma)[..., 0] > 127).sum() - covered.sum()) / 60 for gamma in (1.0, 2.2)]
    assert off_px[0] > 0.3
    assert abs(off_px[1]) < 0.1


def deblurred(image: np.ndarray, blur_px: float) -> np.ndarray:
    return filtered(image, ImageConfig(blur_px=blur_px))


def as_noisy(colours: np.ndarray) -> np.ndarray:
    noisy = colours + np.random.default_rng(0).normal(0, 2, colours.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8)


def test_sharpening_keeps_sharp_edges_and_its_input() -> None:
    image = as_image(np.kron(np.random.default_rng(2).integers(0, 256, (1, 9, 3)), np.ones((20, 6, 1))))
    before = image.copy()
    assert np.array_equal(sharpen(image, 1, 0.1), image)
    assert np.array_equal(image, before)


def test_sharpening_leaves_steps_below_its_limit() -> None:
    ramp = np.repeat(np.arange(0, 200, 4, dtype=np.uint8)[None, :, None], 3, axis=2).repeat(5, axis=0)
    assert np.array_equal(sharpen(ramp, 1, 0.16), ramp)
    assert not np.array_equal(sharpen(ramp, 1, 0.02), ramp)


@pytest.mark.parametrize(
    "options, words",
    [
        ({"background": (1, 2)}, "image.background: 2 numbers"),
        ({"classes": {"a": ClassConfig(label=1, rgb=(1, 2))}}, "image.a.rgb"),
        ({"classes": {"a": ClassConfig(label=1, rgb=RED, light=(1.5, 0.5))}}, "image.a.light"),
        ({"classes": {"a": ClassConfig(label=1, rgb=RED, hue=(0, 20))}}, "image.a.rgb: give a class either"),
        ({"classes": {"a": ClassConfig(label=1, rgb=RED, value=(0.1, 1.0))}}, "image.a.rgb: give a class either"),
        ({"noise": 0.0, "classes": {"a": ClassConfig(label=1, rgb=RED)}}, "image.noise: 0.0 is below"),
    ],
)
def test_values_that_make_no_sense_are_refused_by_name(options: dict, words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        ImageConfig(**{"kind": "colour", **options})
