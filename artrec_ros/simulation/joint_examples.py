"""Examples for training without any image: from the declared places and joints, over a range of views."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..core.geometry.camera import Camera
from ..core.model.found import Instance
from ..core.model.target import Target
from ..io.learned.annotations import Key, instance_from_axis
from .config import SceneConfig
from .records import LEAST_FACING
from .scene import PlacedObject, require_places, sample_scene
from .truth import axis_ends


def joint_examples(
    target: Target, camera: Camera, scene: SceneConfig, seed: int, count: int
) -> Iterator[dict[Key, Instance]]:
    """For each of so many views, where the markers that face the camera lie, as somebody would annotate them.

    What bodies hide counts as seen: what is learned are places, not who hides whom. View i depends on the seed and i
    alone.

    :raises ConfigError: a marker's place is not known.
    """
    require_places(target.model)
    for child in np.random.SeedSequence(seed).spawn(count):
        made = sample_scene([target], camera, scene, np.random.default_rng(child))
        for placed in made.objects:
            yield _example(placed, camera)


def _example(placed: PlacedObject, camera: Camera) -> dict[Key, Instance]:
    ends = axis_ends(placed, camera)
    example = {}
    for surface in placed.surfaces():
        ahead = surface.corners[:, 2].min() > 0
        if surface.owner is not None and ahead and surface.facing >= LEAST_FACING:
            component, name = surface.owner
            tail, head = ends[surface.owner]
            marker = placed.target.model.component(component).marker(name)
            example[surface.owner] = instance_from_axis(component, marker, tail, head)
    return example
