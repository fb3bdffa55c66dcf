"""Room `pose`: what a pixel's label says for and against a hypothesis."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room


@dataclass(frozen=True)
class VotesConfig(Room):
    """Room `pose`: what a pixel's label says for and against a hypothesis."""
