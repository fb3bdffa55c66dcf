"""How the time budget of a frame is shared out."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room, param


@dataclass(frozen=True)
class TimeConfig(Room):
    """Shares of the time that is left, so that later stages get theirs. They matter where the budget ends a search."""

    alignment_share: float = param(
        0.7,
        "what of the time that is left may go into alignment",
        low=0.01,
        high=1,
        paths=("plane", "paper"),
        origin="grouping has to choose among what was found",
    )
    first_pass_share: float = param(
        0.5,
        "what of that may go into the first pass over all hypotheses",
        low=0.01,
        high=1,
        paths=("plane",),
        origin="the rest is for refining what it found",
    )
    overlap_share: float = param(
        0.5,
        "what of the time that is left then may go into which instances share pixels",
        low=0.01,
        high=1,
        paths=("plane",),
        origin="pairs grow with the square of the instances, and the rest is for choosing among them",
    )
