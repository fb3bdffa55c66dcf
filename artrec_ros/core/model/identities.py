"""Which identities an object has."""

from __future__ import annotations

from itertools import product

from .objects import Identity, ObjectModel


def identities_of(model: ObjectModel) -> tuple[Identity, ...]:
    """Those that exist: the ones that are declared, else all combinations of the components' classes, named by them."""
    own = {c.name: c.classes for c in model.components if c.classes}
    if model.identities or not own:
        return model.identities
    return tuple(
        Identity("_".join(classes), dict(zip(own, classes, strict=True))) for classes in product(*own.values())
    )
