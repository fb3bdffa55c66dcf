"""The scale at which marked images show objects, by the lengths in them that are known; and how large they show
markers beside what object files have."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from ...core.geometry.transforms import Array
from ...core.learning.fixed_distances import Distances, Key, fixed_distances
from ...core.model.found import Instance
from ...core.model.objects import ObjectModel
from ...core.model.target import Target
from .annotations import AnnotatedObject, Annotations, load_coco
from .marked_objects import label_of, what_is_shown


def marked_scales(paths: Sequence[str | Path], targets: Sequence[Target]) -> Array:
    """(n,) pixels per metre of each annotated object, as its markers' axes and the distances between them tell."""
    fixed = {t.name: fixed_distances(t.model) for t in targets}
    return np.array([_scale_of(t.model, fixed[t.name], own) for _, t, own in _shown(paths, targets) if own])


def beyond_marks_px(paths: Sequence[str | Path], targets: Sequence[Target]) -> dict[int, float]:
    """Class label -> pixels by which outlines of object files are larger than marked ones on each side, below 0 where
    they are smaller: the median of its markers, at the scale that distances between markers tell.

    Of flat objects alone, with markers whose distance no joint changes.
    """
    fixed, found = {t.name: fixed_distances(t.model) for t in targets}, defaultdict[int, list[float]](list)
    for o, target, own in _shown(paths, targets):
        apart = list(_apart(fixed[target.name], own))
        classes = what_is_shown(o, targets)[1]
        for key, place in own.items() if apart else ():
            marker, component = target.model.markers[key], target.model.component(key[0])
            half_m = 2 * marker.area / marker.perimeter  # so far a side is from the middle: of a disc its radius
            label = label_of(component, target.label, classes.get(component.name), o)
            found[label].append(half_m * (_median(apart) - place.scale))
    return {label: float(np.median(px)) for label, px in found.items()}


def marked_discs(model: ObjectModel, shown: Sequence[Mapping[Key, Instance]]) -> dict[float, float]:
    """Radius of discs in the object file -> how many times as large they are marked, at the scale that distances
    between markers tell (median); as of `beyond_marks_px`.

    :param shown: markers of each annotated object.
    """
    fixed, found = fixed_distances(model), defaultdict[float, list[float]](list)
    for own in shown:
        apart = list(_apart(fixed, own))
        for key, place in own.items() if apart else ():
            if (radius := model.markers[key].disc_radius) is not None:
                found[radius].append(place.scale / _median(apart))
    return {radius: float(np.median(times)) for radius, times in found.items()}


def _shown(
    paths: Sequence[str | Path], targets: Sequence[Target]
) -> Iterator[tuple[AnnotatedObject, Target, Mapping[Key, Instance]]]:
    """Each annotated object with its markers whose axes are annotated."""
    annotations = load_coco(paths)
    for o in annotations.objects:
        target, _ = what_is_shown(o, targets)
        yield o, target, Annotations({o.category: annotations.categories[o.category]}, (o,)).examples(target.model)[0]


def _scale_of(model: ObjectModel, fixed: Distances, shown: Mapping[Key, Instance]) -> float:
    """What all lengths tell: a disc's radius is the worst known of all."""
    axes = [(model.markers[key].axis_length, place.scale) for key, place in shown.items()]
    return _median([*((metres, metres * scale) for metres, scale in axes), *_apart(fixed, shown)])


def _apart(fixed: Distances, shown: Mapping[Key, Instance]) -> Iterator[tuple[float, float]]:
    """Distances between markers, metres and pixels."""
    for (a, b), metres in fixed.items():
        if a in shown and b in shown:
            yield metres, float(np.hypot(shown[a].x - shown[b].x, shown[a].y - shown[b].y))


def _median(lengths: Sequence[tuple[float, float]]) -> float:
    """Pixels per metre, the median of lengths in metres and pixels, each counting by its length: a click is as far off
    at the ends of a long one."""
    metres, pixels = np.array(lengths).T
    order = np.argsort(pixels / metres)
    half = int(np.searchsorted(metres[order].cumsum(), metres.sum() / 2))
    return float((pixels / metres)[order][half])
