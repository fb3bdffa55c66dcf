"""Which identities an object has."""

from __future__ import annotations

from itertools import product
from math import prod

from ..base.errors import ConfigError
from .objects import Identity, ObjectModel

MOST_COMBINATIONS = 4096
"""Of classes, each of which is an identity that every object found is held against: beyond it lie minutes a frame, and
soon all memory."""


def identities_of(model: ObjectModel) -> tuple[Identity, ...]:
    """Those that exist: the ones that are declared, else all combinations of the components' classes, named by them.

    :raises ConfigError: none are declared, and there are too many combinations.
    """
    own = {c.name: c.classes for c in model.components if c.classes}
    if model.identities or not own:
        return model.identities
    if (count := prod(map(len, own.values()))) > MOST_COMBINATIONS:
        raise ConfigError(
            f"the classes of {len(own)} components make {count} combinations, of which each counts as an object that "
            f"exists, and {MOST_COMBINATIONS} may be: list those that do under 'identities', or give fewer classes"
        )
    return tuple(
        Identity("_".join(classes), dict(zip(own, classes, strict=True))) for classes in product(*own.values())
    )
