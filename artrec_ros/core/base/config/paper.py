"""The published method's own values."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param


@dataclass(frozen=True)
class PaperConfig(Room):
    """Read by profile `paper` alone."""

    tolerance_px: float = param(
        2.0,
        "half-width of the tolerance area",
        unit="px",
        low=0.5,
        high=15,
        paths=("paper",),
        origin="as published",
    )
    match: float = param(
        0.4,
        "least share of contour points inside the tolerance area",
        low=0,
        high=1,
        paths=("paper",),
        origin="as published",
    )
    scale_ratio: float = param(
        1.5,
        "greatest ratio of scales that is nearly one scale",
        low=1,
        high=10,
        paths=("paper",),
        origin="the paper gives no number; a reading of 'approximately'",
    )
