"""Limits of the scale that say nothing, for a plane is known."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...core.base.config import RecognizerConfig
from ...core.base.errors import ConfigError
from ...core.geometry.scene import Scene


def wide_limits(config: RecognizerConfig) -> Iterator[str]:
    """A line where limits of the scale leave all that the plane's scales do, at the points that give it."""
    least, most = config.min_scale, config.max_scale or np.inf
    if not (config.scene.plane.is_given and (least > 0 or most < np.inf)):
        return
    try:
        at_points = Scene.of(config.scene).scale_limits(np.reshape(config.scene.plane.image_points, (-1, 2)))
    except ConfigError:  # that is said where the images are looked at
        return
    low, high = float(at_points.min()), float(at_points.max())
    if least <= low and high <= most:
        yield (
            f"recognizer.min_scale {config.min_scale:.4g} and max_scale {config.max_scale:.4g} say nothing beside "
            f"scene.plane, by which objects have {low:.3g} to {high:.3g} px/m (scale_tolerance "
            f"{config.scene.plane.scale_tolerance:g} counted); lower scale_tolerance or narrow the limits to say more"
        )
