"""What is known of the scene: where objects can be, and how large they are there."""

from __future__ import annotations

import cv2
import fields
import numpy as np
import pytest

from artrec_ros.core.base.config import SceneConfig
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.geometry.scene import Scene

HOOK = (10.0, 10.0, 90.0, 10.0, 90.0, 90.0, 60.0, 90.0, 60.0, 40.0, 10.0, 40.0)  # not convex


def test_the_region_is_what_opencv_says_it_is() -> None:
    scene = Scene.of(SceneConfig(region=HOOK))
    pixels = np.random.default_rng(0).uniform(0, 100, (500, 2))
    polygon = np.reshape(HOOK, (-1, 1, 2)).astype(np.float32)
    expected = [cv2.pointPolygonTest(polygon, p.tolist(), False) > 0 for p in pixels]
    np.testing.assert_array_equal(scene.inside(pixels), expected)
    turned = Scene.of(SceneConfig(region=tuple(np.reshape(HOOK, (-1, 2))[::-1].ravel())))
    np.testing.assert_array_equal(turned.inside(pixels), expected)


def test_what_is_not_known_refuses_nothing() -> None:
    scene, pixels = Scene.of(SceneConfig()), np.array([[5.0, 5.0], [-1e6, 0.0]])
    assert not scene and scene.inside(pixels).all()
    assert scene.reasons(pixels, np.array([1.0, 1e6])) == [None, None]
    assert scene.scale_limits(pixels).tolist() == [[0, np.inf]] * 2


@pytest.mark.parametrize(
    ("region", "part"),
    [
        ((1.0, 2.0, 3.0, 4.0), "4 numbers are given"),
        ((1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0), "7 numbers are given"),
        ((0.0, 0.0, 10.0, 10.0, 20.0, 20.0), "enclose nothing"),
        ((0.0, 0.0, 1e9, 10.0, 20.0, 20.0), "above its greatest"),
    ],
)
def test_regions_that_are_none_are_refused(region: tuple[float, ...], part: str) -> None:
    with pytest.raises(ConfigError, match=r"scene\.region") as error:
        Scene.of(SceneConfig(region=region))
    assert part in str(error.value) and "\n" not in str(error.value)


def test_reasons_name_what_is_wrong() -> None:
    camera = fields.camera()
    config = SceneConfig((50.0, 50.0, 600.0, 50.0, 600.0, 450.0, 50.0, 450.0), fields.plane(camera, 20.0))
    scene = Scene.of(config)
    pixels = np.array([[320.0, 240.0], [320.0, 240.0], [320.0, 240.0], [20.0, 240.0]])
    (known,) = scene.plane.scales(pixels[:1])
    reasons = scene.reasons(pixels, known * np.array([1.0, 1.45, 1 / 1.45, 1.0]))
    assert reasons[0] is None and reasons[3] == "outside scene.region"
    assert all("px/m, but scene.plane has" in reason for reason in reasons[1:3])
    least, most = scene.scale_limits(pixels[:1])[0]
    assert scene.reasons(pixels[:2], np.array([least, most])) == [None, None]
    assert scene.reasons(pixels[:1]) == [None]  # of what is not found flat no scale is asked
