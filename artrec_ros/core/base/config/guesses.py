"""Room `pose`: where hypotheses of whole objects come from."""

from __future__ import annotations

from dataclasses import dataclass

from .params import Room


@dataclass(frozen=True)
class GuessesConfig(Room):
    """Room `pose`: where hypotheses of whole objects come from."""
