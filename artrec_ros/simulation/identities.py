"""Which one of several like objects stands in a scene: one of its identities, by chance."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace

import numpy as np

from ..core.model.identities import identities_of
from ..core.model.objects import ObjectModel
from ..core.model.target import Target


def drawn(model: ObjectModel, taken: Collection[str], rng: np.random.Generator) -> str | None:
    """An identity's name; None where the model has none, or is unique and all are taken."""
    names = [i.name for i in identities_of(model) if not (model.unique and i.name in taken)]
    return names[rng.integers(len(names))] if names else None


def all_taken(model: ObjectModel, taken: Collection[str], *, stands: bool) -> bool:
    """Whether there is no other one of an object that occurs once, or in identities that do.

    :param stands: whether one stands there already.
    """
    names = {i.name for i in identities_of(model)}
    return model.unique and (names <= set(taken) if names else stands)


def shown_as(target: Target, identity: str | None) -> Target:
    """The target with the one class of each component that its identity shows. :param identity: None: no change."""
    if identity is None:
        return target
    classes = next(i.classes for i in identities_of(target.model) if i.name == identity)
    components = tuple(
        replace(c, classes={}, label=c.classes[classes[c.name]]) if c.classes else c for c in target.model.components
    )
    return replace(target, model=replace(target.model, components=components, identities=(), unique=False))


def alternative_labels(targets: Sequence[Target]) -> set[int]:
    """Labels of all classes that components may have."""
    return {label for t in targets for c in t.model.components if c.classes for label in c.labels(t.label)}
