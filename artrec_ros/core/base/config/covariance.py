"""Room `pose`: how uncertain a fit is."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room


@dataclass(frozen=True)
class CovarianceConfig(Room):
    """Room `pose`: how uncertain a fit is."""
