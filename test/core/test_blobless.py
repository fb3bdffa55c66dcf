"""Where no blob is left of an image, it is told which parameter left none."""

from __future__ import annotations

from dataclasses import replace

import cv2
import numpy as np
import pytest
from cranes import BLUE, CRANE, RED, crane_examples
from scene import crane, crane_placed, render

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig, SceneConfig
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.learning.pair_learning import learn
from artrec_ros.core.model.objects import ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer

SIZE = (420, 240)
OTHER_RED = RED + 1
EMPTY = np.zeros(SIZE[::-1], np.uint8)
SEEN = render(SIZE, crane(), [crane_placed(150, 110, 0.2, 55)], RED)


@pytest.mark.parametrize(
    ("image", "config", "image_config", "reason"),
    [
        (EMPTY, {}, {}, None),
        (SEEN, {"min_blob_px": 100_000}, {}, "fewer than recognizer.min_blob_px 100000"),
        (SEEN, {"scene": SceneConfig(region=(400, 0, 419, 0, 419, 20))}, {}, "lie outside scene.region"),
        (
            SEEN,
            {"scene": SceneConfig(region=(500, 0, 600, 0, 600, 90))},
            {},
            "scene.region leaves no pixel of the image",
        ),
        (SEEN, {}, {"blank": (0, 0, 200, 240, 200, 0, 220, 240)}, "image.blank leaves no pixel of the image"),
        (SEEN, {}, {"blank": (0, 0, 419, 240)}, None),
    ],
)
def test_what_left_no_blob_is_told(image, config, image_config, reason):
    config = replace(RecognizerConfig(), **config)
    segmenter = Segmenter(replace(ImageConfig(), **image_config))
    result = Recognizer([Target("crane", crane(), RED, CRANE)], config, segmenter).recognize(image)
    assert result.blobless and not result.detections
    if reason is None:
        assert not result.rejected
    else:
        (told,) = result.rejected
        assert told.object == "crane" and reason in told.reason


def test_of_an_image_with_blobs_nothing_is_told():
    result = Recognizer([Target("crane", crane(), RED, CRANE)], RecognizerConfig(), Segmenter(ImageConfig())).recognize(
        SEEN
    )
    assert not result.blobless and len(result.detections) == 1


@pytest.mark.parametrize("required", ["strict", "visible"])
def test_that_only_other_components_show_is_told_where_nothing_is(required):
    base, *bars = crane().components
    model = ObjectModel("crane", (base, *(replace(bar, label=BLUE) for bar in bars)))
    targets = [
        Target("crane", model, RED, learn(model, crane_examples())),
        Target("tower", crane(), OTHER_RED, CRANE),
    ]
    image = EMPTY.copy()
    image[20:60, 20:60], image[20:30, 100:110] = BLUE, BLUE
    config = replace(RecognizerConfig(), required=required)
    recognizer = Recognizer(targets, config, Segmenter(ImageConfig()))
    told = [r.reason for r in recognizer.recognize(image).rejected]
    if required == "visible":
        assert not told
    else:
        assert told == [
            "its required component base does not show; 2 blobs of its others' classes do, the largest of 1600 pixels: "
            "nothing is begun with them (see recognizer.required)"
        ]
    beside = np.where(render(SIZE, crane(), [crane_placed(250, 150, 0.2, 45)], OTHER_RED) > 0, OTHER_RED, image)
    result = recognizer.recognize(beside)
    assert [d.object for d in result.detections] == ["tower"]
    assert not [r for r in result.rejected if r.object == "crane"]


def test_the_pixels_of_what_shows_are_those_of_its_class_and_not_what_it_closes_in():
    base, *bars = crane().components
    model = ObjectModel("crane", (base, *(replace(bar, label=BLUE) for bar in bars)))
    image = EMPTY.copy()
    cv2.rectangle(image, (10, 10), (180, 120), BLUE, 2)  # a frame around much, and a larger patch
    image[40:80, 40:80] = BLUE
    targets = [Target("crane", model, RED, learn(model, crane_examples()))]
    (told,) = Recognizer(targets, RecognizerConfig(), Segmenter(ImageConfig())).recognize(image).rejected
    frame_px = np.count_nonzero(image) - 1600
    assert f"the largest of {max(frame_px, 1600)} pixels" in told.reason


def test_a_required_component_too_small_is_told_beside_blobs_of_others():
    image = np.zeros(SIZE[::-1], np.uint8)
    image[20:60, 20:60], image[100:102, 100:103] = RED, OTHER_RED
    targets = [Target("crane", crane(), RED, CRANE), Target("small", crane(), OTHER_RED, CRANE)]
    result = Recognizer(targets, RecognizerConfig(), Segmenter(ImageConfig())).recognize(image)
    assert not result.blobless
    (told,) = [r for r in result.rejected if r.object == "small"]
    assert "1 blobs of its required component's classes, the largest of 6 pixels, fewer than" in told.reason
    image[100:102, 100:103] = 0
    image[100, 100:103] = OTHER_RED  # noise, within the region and beyond it
    for region in ((), (0, 0, 90, 0, 90, 90, 0, 90)):
        config = replace(RecognizerConfig(), scene=SceneConfig(region=region))
        result = Recognizer(targets, config, Segmenter(ImageConfig())).recognize(image)
        assert not [r for r in result.rejected if r.object == "small"]
