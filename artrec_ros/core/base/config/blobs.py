"""Room `image`: blobs and their anchors."""

from __future__ import annotations

import math
from dataclasses import dataclass

from ..errors import ConfigError
from .params import Room, param


@dataclass(frozen=True)
class BlobsConfig(Room):
    """Which blobs are looked at, and the anchors of their contours."""

    max_blobs: int = param(
        300,
        "at most so many blobs of a frame are looked at, the largest",
        low=1,
        high=10000,
        origin="bounds the time of a noisy frame; scenes of robots have 10 to 60",
    )
    anchor_tolerances_px: tuple[float, ...] = param(
        (1.0, 2.0),
        "tolerances of the polygonal approximation that gives anchors; the paper uses the first",
        unit="px",
        low=0.3,
        high=20,
        origin="a pixel's staircase, and twice it: small patches need both",
    )
    anchor_tolerance_share: float = param(
        0.012,
        "the tolerances grow on blobs above 1/share pixels wide, in proportion",
        low=0,
        high=0.2,
        origin="silhouettes of 80 px and more keep their number of anchors (MPEG-7 shapes)",
    )
    max_anchors: int = param(
        80,
        "ragged blobs are approximated more coarsely until they have no more anchors",
        low=3,
        high=1000,
        paths=("plane", "paper"),
        origin="bounds the time: couples grow with it",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.anchor_tolerances_px:
            raise ConfigError("expert.blobs.anchor_tolerances_px: none is given; one or more are needed")

    def tolerances_px(self, area_px: float) -> tuple[float, ...]:
        """Tolerances for a blob of so many pixels: small patches need two at once, large silhouettes ones that grow
        with the root of their area."""
        grown = max(1.0, self.anchor_tolerance_share * math.sqrt(area_px))
        return tuple(grown * t for t in self.anchor_tolerances_px)
