"""Room `tracking`: how exactly a detection tells where an object is."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param


@dataclass(frozen=True)
class SightingsConfig(Room):
    """What tracking takes a detection to be worth: uncertainties beyond those that a fit tells."""

    misturned: float = param(
        0.1,
        "share of detections whose turn is wrong: mirrored, or by a marker's symmetry",
        low=0.001,
        high=0.999,
        origin="rendered quadrupeds: one in ten",
    )
    turn_rad: float = param(
        0.1,
        "least uncertainty of a turn",
        unit="rad",
        low=0.001,
        high=3,
        origin="rotation errors of 3 to 6 degrees",
    )
    range_share: float = param(
        0.01,
        "least uncertainty of a place in space, as a share of its range",
        low=0.0001,
        high=1,
        origin="position errors of 0.4 to 1.1 % of the range",
    )
    place_px: float = param(
        1.5,
        "uncertainty of a place in the image",
        unit="px",
        low=0.01,
        high=100,
        origin="a blob that is cut or merged moves by so much from frame to frame",
    )
    scale_share: float = param(
        0.05,
        "uncertainty of a scale in the image, as a share",
        low=0.001,
        high=1,
        origin="a pixel at each end of a marker of 40",
    )
    missed_per_seen: float = param(
        2.0,
        "frames in a row that an object may be missed, for each that it was seen in",
        low=0,
        high=1000,
        origin="what was seen once or twice was perhaps nothing",
    )
    identity_memory: float = param(
        0.8,
        "what earlier sightings say of which one of several like objects it is, times this for each frame since",
        low=0,
        high=1,
        origin="five frames count: light and blur are alike from one frame to the next, and prove nothing twice",
    )
