"""Room `verdict`: what is an object, and how far it is trusted."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param


@dataclass(frozen=True)
class VerdictConfig(Room):
    """What a whole object must have."""

    min_votes: float = param(
        100.0,
        "least votes of the label image for a whole object",
        low=0,
        paths=("space",),
        origin="25 pixels of a marker at 4 votes each",
    )
