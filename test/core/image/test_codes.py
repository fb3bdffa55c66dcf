"""Codes that say how far a pixel is of each class: laws of coding, and what label images keep."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from artrec_ros.core.base.config import ClassConfig, ImageConfig
from artrec_ros.core.image.codes import EMPTY, LABELS, OUTSIDE, OWNED, UNKNOWN, Codes
from artrec_ros.core.image.colour_table import coded, colour_table
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter

RED, BLUE, GREEN, GREY = (200, 40, 45), (40, 65, 170), (50, 140, 45), (75, 72, 72)
RGB = {"red": (2, RED), "blue": (5, BLUE), "green": (9, GREEN)}
BY_COLOUR = {name: ClassConfig(label=label, rgb=rgb) for name, (label, rgb) in RGB.items()}
CONFIG = ImageConfig(kind="colour", classes=BY_COLOUR, background=GREY)
TABLE = colour_table(CONFIG)


def code565(bgr):
    """Index into a colour table of colours (n, 3), 0..255."""
    b, g, r = np.asarray(bgr, int).T
    return (b >> 3) | (g >> 2) << 5 | (r >> 3) << 11


def shares(rgb):
    """(256,) how far a colour is of each class."""
    table, meaning = TABLE
    return meaning.share[table[code565([rgb[::-1]])[0]]]


def test_a_label_images_codes_are_its_labels() -> None:
    image = np.random.default_rng(0).integers(0, 253, (20, 30), np.uint8)
    segmenter = Segmenter(ImageConfig())
    assert segmenter.meaning is LABELS and np.array_equal(segmenter.codes(image), image)
    assert np.array_equal(LABELS.label, np.arange(256)) and np.array_equal(LABELS.share, np.eye(256))
    field = LabelField(image)
    assert field.labels is field.codes
    votes = np.random.default_rng(1).normal(size=(3, 256))
    np.testing.assert_allclose(LABELS.votes(votes), votes)


@pytest.mark.parametrize("background", [(), GREY])
def test_shares_add_up_and_name_the_class(background: tuple[int, ...]) -> None:
    table, meaning = colour_table(ImageConfig(kind="colour", classes=BY_COLOUR, background=background))
    assert table.shape == (1 << 16,) and table.dtype == np.uint8
    used = np.unique(table)
    assert used.max() < EMPTY  # what is empty, owned or outside has codes of its own
    np.testing.assert_allclose(meaning.share.sum(axis=1), 1.0)
    assert (meaning.share >= 0).all() and (np.count_nonzero(meaning.share, axis=1) <= 2).all()
    assert set(meaning.label[used].tolist()) == {UNKNOWN, 2, 5, 9}
    assert (meaning.share[used, meaning.label[used]] > 0).any()
    for own in (EMPTY, OWNED, OUTSIDE):
        assert meaning.label[own] == own and meaning.share[own, own] == 1


weights = st.integers(0, 2**32 - 1)


@settings(max_examples=30)
@given(weights, st.integers(1, 6))
def test_coding_changes_no_label_and_keeps_shares_to_its_step(seed: int, classes: int) -> None:
    rng = np.random.default_rng(seed)
    labels = np.concatenate([[0], rng.choice(np.arange(1, 253), classes, replace=False)]).astype(np.uint8)
    n = 500
    says = np.exp(rng.uniform(-8, 8, (len(labels), n))).astype(np.float32)
    first = rng.integers(0, len(labels), n)
    code, meaning = coded(first, says, labels)
    assert np.array_equal(meaning.label[code], labels[first])
    rest = np.where(np.arange(len(labels))[:, None] == first, -1.0, says)
    own, other = says[first, np.arange(n)], rest.max(axis=0)
    np.testing.assert_allclose(meaning.share[code, labels[first]], own / (own + other), atol=0.5 / 4 + 1e-6)
    np.testing.assert_allclose(meaning.share[code].sum(axis=1), 1.0)


@pytest.mark.parametrize("classes", [60, 200, 252])
def test_very_many_classes_leave_codes_without_shares(classes: int) -> None:
    rng = np.random.default_rng(classes)
    labels = np.arange(classes + 1, dtype=np.uint8)
    first, says = rng.integers(0, classes + 1, 5000), rng.uniform(0.1, 10, (classes + 1, 5000)).astype(np.float32)
    code, meaning = coded(first, says, labels)
    assert np.array_equal(meaning.label[code], first)
    np.testing.assert_allclose(meaning.share.sum(axis=1), 1.0)


@pytest.mark.parametrize("name", RGB)
def test_a_classs_own_colour_is_sure_in_light_and_in_some_shade(name: str) -> None:
    label, rgb = RGB[name]
    for light in (0.7, 1.0, 1.2):
        assert shares(np.minimum(light * np.array(rgb), 255).astype(int))[label] > 0.9


def test_background_is_sure_to_be_unknown() -> None:
    assert shares(GREY)[UNKNOWN] > 0.9
    assert shares((200, 60, 200))[UNKNOWN] > 0.9  # magenta, like no class


@pytest.mark.parametrize(("name", "other"), [(a, b) for a in RGB for b in ("grey", *RGB) if a != b])
def test_on_the_way_from_one_colour_to_another_the_share_falls_and_is_in_doubt_between(name: str, other: str) -> None:
    label, rgb = RGB[name]
    end = np.array(GREY if other == "grey" else RGB[other][1])
    way = [shares(np.rint(rgb + t * (end - rgb)).astype(int))[label] for t in np.linspace(0, 1, 401)]
    assert way[0] > 0.9 and way[-1] < 0.1
    doubtful = [share for share in way if 0.1 < share < 0.9]
    assert doubtful  # neither class is named for sure all the way
    assert np.diff(way).max() < 0.35  # and it comes back nowhere, but for a step of coding


def test_ranges_are_sure_on_either_side() -> None:
    by_range = {"red": ClassConfig(label=2, hue=(340, 20), saturation=(0.5, 1), value=(0.3, 1))}
    table, meaning = colour_table(ImageConfig(kind="colour", classes=by_range))
    own = meaning.share[table, 2]
    assert set(np.unique(own)) == {0.0, 1.0} and 0 < own.mean() < 0.2


def test_a_field_of_codes_has_labels_owners_and_seams_as_one_of_labels() -> None:
    rng = np.random.default_rng(3)
    image = np.full((60, 80, 3), GREY[::-1], np.uint8)
    image[10:40, 10:40], image[15:50, 42:70] = RED[::-1], BLUE[::-1]
    image = np.clip(image + rng.normal(0, 4, image.shape), 0, 255).astype(np.uint8)
    segmenter = Segmenter(CONFIG)
    coded_field = LabelField(segmenter.codes(image), meaning=segmenter.meaning)
    hard = LabelField(segmenter.labels(image))
    assert np.array_equal(coded_field.labels, hard.labels) and set(np.unique(hard.labels)) == {0, 2, 5}
    for label in (2, 5, 9):
        assert coded_field.seam_px(label) == hard.seam_px(label)
    hull = [np.float32([[5, 5], [30, 5], [30, 30], [5, 30]])]
    assert np.array_equal(coded_field.without(hull).labels, hard.without(hull).labels)
    assert (coded_field.without(hull).labels == OWNED).sum() == pytest.approx(26 * 26, abs=60)
    assert np.array_equal(coded_field.labels, hard.labels)  # the field itself stays
    beyond = np.array([[-3.0, 5.0], [100.0, 5.0]])
    assert (coded_field.meaning.label[coded_field.at(beyond)] == OUTSIDE).all()


def test_blanked_pixels_are_unknown_for_sure() -> None:
    image = np.tile(np.array(RED[::-1], np.uint8), (20, 30, 1))
    blank = Segmenter(ImageConfig(kind="colour", classes=BY_COLOUR, background=GREY, blank=(4, 3, 10, 8)))
    share = blank.meaning.share[blank.codes(image)]
    assert (share[3:11, 4:14, UNKNOWN] == 1).all() and (share[12:, :, 2] > 0.9).all()


def test_a_doubtful_pixel_votes_the_mean_of_what_it_may_be() -> None:
    share = np.eye(256)
    share[7] = 0
    share[7, [2, UNKNOWN]] = 0.25, 0.75
    votes = np.zeros((2, 256))
    votes[:, [2, UNKNOWN]] = [[4.0, -0.4], [-4.0, 0.0]]
    label = np.arange(256, dtype=np.uint8)
    np.testing.assert_allclose(Codes(label, share).votes(votes)[:, 7], [0.25 * 4 - 0.75 * 0.4, -1.0])
