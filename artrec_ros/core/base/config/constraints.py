"""Room `constraints`: how exactly places are known that constraints and classes compare."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param


@dataclass(frozen=True)
class ConstraintsConfig(Room):
    """Noise of measurements: what was learned is widened by two standard deviations."""

    contour_noise_px: float = param(
        0.5,
        "standard deviation of a contour's place; constraints are widened by two of it",
        unit="px",
        low=0,
        high=10,
        paths=("plane", "space"),
        origin="what a pixel can tell of an edge, and a segmenter's seam",
    )
    model_noise: float = param(
        0.02,
        "the same for what a flat rigid model leaves out, as a share of the shape's radius; of what is found whole "
        "the scale is known no better",
        low=0,
        high=0.5,
        paths=("plane", "space", "facing"),
        origin="slant of ten degrees shortens by 1.5 %; a wide lens wants 0.04 (pendulum)",
    )
    class_noise: float = param(
        0.04,
        "standard deviation of what classes compare, beyond a contour's noise: of joints and angles in radians, of "
        "distances as a share; classes are widened by two of it",
        low=0,
        high=0.5,
        paths=("plane", "space"),
        origin="error of joints that are fitted in space, median 2 degrees",
    )
