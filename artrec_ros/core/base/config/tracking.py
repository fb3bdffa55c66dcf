"""How objects keep their names from frame to frame."""

from __future__ import annotations

from dataclasses import dataclass

from .existence import ExistenceConfig
from .params import param, room, validate
from .sightings import SightingsConfig


@dataclass(frozen=True)
class TrackingConfig:
    """How an object's id is carried on. Motion is relative to the camera."""

    enabled: bool = param(True, "an object keeps its id from frame to frame; false: ids count anew in each frame")
    max_gap_s: float = param(
        1.0,
        "an object that was not seen for longer is a newcomer when it comes back, and its id is free",
        unit="s",
        low=0,
        high=3600,
    )
    speed: float = param(0.7, "standard deviation of an object's speed along each axis", unit="m/s", low=0, high=100)
    steady_s: float = param(
        0.5, "how long a speed lasts before it is another: time constant", unit="s", low=0.001, high=1000
    )
    turn_rate: float = param(
        2.0, "standard deviation of the rate at which an object turns", unit="rad/s", low=0, high=100
    )
    newcomer_odds: float = param(
        1.0,
        "how many times likelier a new object is than a known one, before its place is looked at; higher: names are "
        "given up sooner",
        low=1e-6,
        high=1e6,
    )
    predict: float = param(
        0.0,
        "an object that is hidden or missed is told so long at most where it is expected, marked as predicted, while "
        "it is likely there, about where it is expected (expert.existence.least); 0: never",
        unit="s",
        low=0,
        high=3600,
    )
    smooth: bool = param(
        False, "poses and joints on topics are those of the filter over time; false: those of each frame alone"
    )
    sightings: SightingsConfig = room(SightingsConfig)
    existence: ExistenceConfig = room(ExistenceConfig)

    def __post_init__(self) -> None:
        validate(self, "tracking.")
