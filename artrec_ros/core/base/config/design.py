"""Room `design`: what will be told of markers. Offline: not in parameter files."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param


@dataclass(frozen=True)
class DesignConfig(Room):
    """From where on a marker is found and told from others, in `artrec model`."""

    least_long_px: float = param(
        12.0,
        "longer side of a marker that can be found",
        unit="px",
        low=1,
        high=1000,
        origin="below, it has no anchors worth a hypothesis",
    )
    least_area_px: float = param(
        40.0,
        "area of a marker that others support",
        unit="px^2",
        low=1,
        high=100000,
        origin="rendered quadrupeds: legs of less are missed",
    )
    least_seed_px: float = param(
        150.0,
        "area of a marker from which a group grows",
        unit="px^2",
        low=1,
        high=100000,
        origin="measured: 97 % are found above it",
    )
    same_share: float = param(
        0.03,
        "outlines that differ by less than this share of their radius are the same by design",
        low=0,
        high=1,
        origin="half a millimetre of a sticker of 4 cm",
    )
    like_size: float = param(
        1.15,
        "factor between sizes that is not told",
        low=1,
        high=10,
        origin="an object's distance is not known exactly",
    )
    sigmas: float = param(
        2.0,
        "outlines are told where they differ by so many standard deviations of a contour's place",
        low=0,
        high=100,
        origin="one in twenty is confused there",
    )
    much_larger: float = param(
        2.0,
        "ratio of sizes beyond which two markers are not confused",
        low=1,
        high=100,
        origin="an object twice as far is another one",
    )
