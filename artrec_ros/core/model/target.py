"""What is looked for: a model, its class, what was learned of it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

from ..geometry.transforms import Array
from .objects import ObjectModel
from .solids import convex_solids
from .surface import Patch, is_on_unknown, patches_of


@dataclass(frozen=True)
class Target:
    """An object to look for: its name for users, its model, its class label, its learned constraints."""

    name: str
    model: ObjectModel
    label: int
    constraints: object | None = None

    @property
    def labels(self) -> frozenset[int]:
        """Classes that its markers may have."""
        return frozenset(label for c in self.model.components for label in c.labels(self.label))

    @property
    def root_labels(self) -> frozenset[int]:
        """The same of its required component's."""
        return frozenset(self.model.required.labels(self.label))

    @property
    def on_bodies(self) -> frozenset[int]:
        """The same, where a body of no known class may show beyond markers' outlines; else none."""
        if not any(c.bodies and not c.body_labels for c in self.model.components):
            return frozenset()
        closed_in = self.model.is_spatial and not is_on_unknown(self._patches)
        return frozenset() if closed_in else self.labels

    @cached_property
    def solids(self) -> frozenset[str]:
        """Its components that are seen as one: see `convex_solids`."""
        return frozenset(self.model.components[c].name for c in convex_solids(self._patches))

    @cached_property
    def balls(self) -> dict[str, Array]:
        """Its components that are balls, and their centres (3,) in their own frames."""
        return {c.name: c.ball.centre for c in self.model.components if c.ball is not None}

    @cached_property
    def _patches(self) -> list[Patch]:
        return patches_of(self.model, self.label) if self.model.is_spatial else []
