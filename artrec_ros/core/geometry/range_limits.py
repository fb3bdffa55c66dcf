"""Between which distances, and so at which scales, objects are looked for.

A marker at depth z that no turn shortens has k = f / z pixels per metre: limits of the scale are limits of the
distance where the focal length f (pixels) is known, and the other way round.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..base.config import RecognizerConfig
from ..base.errors import ConfigError
from .camera import Camera
from .transforms import Array

ROUNDING = 1e-6  # share of a limit: a fit that it holds comes to lie on it


class RangeLimits(NamedTuple):
    """Least and greatest depth, metres; infinite: any."""

    near_m: float
    far_m: float


class ScaleLimits(NamedTuple):
    """Least and greatest scale, pixels per metre; infinite: any."""

    least: float
    greatest: float


def range_limits(config: RecognizerConfig, camera: Camera) -> RangeLimits:
    """Of distances along the optical axis: what `min_range_m`, `max_range_m`, `min_scale`, `max_scale` leave together.

    :raises ConfigError: they leave nothing in this camera's images.
    """
    limits = RangeLimits(
        max(config.min_range_m, camera.focal_px / config.max_scale if config.max_scale > 0 else 0.0),
        min(config.max_range_m or math.inf, camera.focal_px / config.min_scale if config.min_scale > 0 else math.inf),
    )
    if limits.near_m > limits.far_m:
        raise ConfigError(
            f"recognizer.min_range_m {config.min_range_m:g}, max_range_m {config.max_range_m:g}, min_scale "
            f"{config.min_scale:g} and max_scale {config.max_scale:g} leave no distance: with a focal length of "
            f"{camera.focal_px:.0f} px it would be {limits.near_m:.3g} m or more, and {limits.far_m:.3g} m or less"
        )
    return limits


def scale_limits(config: RecognizerConfig, camera: Camera | None) -> ScaleLimits:
    """The same as scales; without a camera those of the scale alone.

    :raises ConfigError: they leave nothing in this camera's images.
    """
    if camera is None:
        return ScaleLimits(config.min_scale, config.max_scale or math.inf)
    near_m, far_m = range_limits(config, camera)
    return ScaleLimits(camera.focal_px / far_m, camera.focal_px / near_m if near_m > 0 else math.inf)


def narrowed(limits: ScaleLimits, others: Array) -> ScaleLimits:
    """What is left of limits where one of others (n, 2), n > 0, holds as well; no more than a point if nothing is."""
    low, high = np.clip([others[:, 0].min(), others[:, 1].max()], limits.least, limits.greatest).tolist()
    return ScaleLimits(low, high)
