"""Room `pose`: fits of poses and joints to contours."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room


@dataclass(frozen=True)
class FitConfig(Room):
    """Room `pose`: fits of poses and joints to contours."""
