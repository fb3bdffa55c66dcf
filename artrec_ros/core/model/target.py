"""What is looked for: a model, its class, what was learned of it."""

from __future__ import annotations

from dataclasses import dataclass

from .objects import ObjectModel


@dataclass(frozen=True)
class Target:
    """An object to look for: its name for users, its model, its class label, its learned constraints."""

    name: str
    model: ObjectModel
    label: int
    constraints: object | None = None
