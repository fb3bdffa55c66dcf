"""The scale at which marked images show objects, by the lengths in them that are known."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from ...core.geometry.transforms import Array
from ...core.learning.fixed_distances import Distances, Key, fixed_distances
from ...core.model.found import Instance
from ...core.model.objects import ObjectModel
from ...core.model.target import Target
from .annotations import Annotations, load_coco
from .marked_objects import what_is_shown


def marked_scales(paths: Sequence[str | Path], targets: Sequence[Target]) -> Array:
    """(n,) pixels per metre of each annotated object, as its markers' axes and the distances between them tell."""
    annotations, fixed = load_coco(paths), {t.name: fixed_distances(t.model) for t in targets}
    scales = []
    for o in annotations.objects:
        target, _ = what_is_shown(o, targets)
        own = Annotations({o.category: annotations.categories[o.category]}, (o,)).examples(target.model)[0]
        scales += [_scale_of(target.model, fixed[target.name], own)] if own else []
    return np.array(scales)


def _scale_of(model: ObjectModel, fixed: Distances, shown: Mapping[Key, Instance]) -> float:
    """The median of what all lengths tell, each counting by its length: a click is as far off at the ends of a long
    one, and a disc's radius is the worst known of all."""
    axes = [(model.markers[key].axis_length, place.scale) for key, place in shown.items()]
    lengths = [(metres, metres * scale) for metres, scale in axes]
    for (a, b), metres in fixed.items():
        if a in shown and b in shown:
            lengths.append((metres, float(np.hypot(shown[a].x - shown[b].x, shown[a].y - shown[b].y))))
    metres, pixels = np.array(lengths).T
    order = np.argsort(pixels / metres)
    half = int(np.searchsorted(metres[order].cumsum(), metres.sum() / 2))
    return float((pixels / metres)[order][half])
