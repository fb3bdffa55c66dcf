"""Objects of equal dots made up at random, in space, of one class or of several: what tells them is where dots lie."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from random_flat import DOT_M, THIRD, flat_dots
from random_solids import BODY, LABELS, OTHER, World, random_model

from artrec_ros.core.geometry.transforms import Array
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import ObjectModel
from artrec_ros.core.model.target import Target

BARE = 0.6  # share of those made of other objects that have no bodies
STRANGE = 0.2  # share of the worlds with an object that nobody looks for
FURTHER = (0, 0, 1, 3)  # how many classes there may be beside an object's own
LEAST = 3  # components


def dotted_world(seed: int) -> World:
    """One or two objects of dots, of one class in every third case, and at times a stranger."""
    rng = np.random.default_rng([27, seed])
    label = LABELS[0] if rng.random() < 1 / 3 else LABELS[1]
    both = (Target("one", random_dots("one", rng), LABELS[0]), Target("two", random_dots("two", rng), label))
    stranger = (Target("stranger", random_dots("stranger", rng), LABELS[0]),)
    return World(both[: int(rng.integers(1, 3))], stranger if rng.random() < STRANGE else ())


def random_dots(name: str, rng: np.random.Generator) -> ObjectModel:
    """Dots in a plane, or on the limbs of any other object, in its classes or in up to four."""
    model = flat_dots(name, rng, LABELS[0]) if rng.random() < 0.5 else _dotted(name, rng)
    further = (None, OTHER, THIRD, BODY)[: 1 + int(rng.choice(FURTHER))]
    if len(further) == 1:
        return model
    labels = [c.label if c.body_label is not None else further[rng.integers(len(further))] for c in model.components]
    return replace(
        model,
        components=tuple(replace(c, label=label) for c, label in zip(model.components, labels, strict=True)),
    )


def _dotted(name: str, rng: np.random.Generator) -> ObjectModel:
    """A random object with a dot in each marker's place."""
    while len((model := random_model(name, rng)).components) < LEAST:
        continue
    radius, bare = rng.uniform(0.5, 1) * DOT_M, rng.random() < BARE
    components = (replace(c, markers=tuple(_dot(m, radius) for m in c.markers)) for c in model.components)
    if bare:
        components = (replace(c, bodies=(), body_label=None) for c in components)
    return replace(model, components=tuple(components))


def _dot(marker: Marker, radius: float) -> Marker:
    """A disc where a marker is."""
    turns = 2 * np.pi * np.arange(48) / 48
    circle: Array = marker.outline.mean(axis=0) + radius * np.column_stack([np.cos(turns), np.sin(turns)])
    ends = marker.outline.mean(axis=0) + radius * np.array([[-1.0, 0.0], [1.0, 0.0]])
    return Marker(marker.name, circle, ends[0], ends[1], radius, marker.T_component_marker)
