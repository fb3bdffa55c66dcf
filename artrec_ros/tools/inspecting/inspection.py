"""Whether files belong together: every way in which they do not, as one line."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

import numpy as np

from ...core.base.errors import ConfigError, SourceError
from ...core.geometry.camera import Camera
from ...core.model.objects import ObjectModel
from ...io.inventory.contents import BagContent, ConstraintContent, Item, ResultContent, Sample, TruthContent
from ...io.inventory.inventory import image_stamps
from ...io.learned.annotations import Annotations
from ...io.learned.constraints import load_constraints
from ...io.parameters.parameter_file import Setup
from ...io.parameters.targets import colourless
from .annotation_problems import annotation_problems
from .camera_report import odd_calibration
from .image_problems import image_problems
from .oddities import buried, odd_units, on_own_colour, unborne
from .scene_problems import scene_problems
from .shared_classes import shared_classes
from .structure import split_sides
from .too_small import too_small
from .wide_limits import wide_limits

T = TypeVar("T")

_LISTED = 4  # topics that are named where images are missing


def problems(items: Sequence[Item]) -> Iterator[str]:
    """What is wrong with each, then what does not fit together."""
    for item in items:
        if item.error is not None:
            yield f"{item.path}: {item.error}"
    for path, bag in _all(items, BagContent):
        yield from _bag_alone(path, bag)
    for path, sample in _all(items, Sample):
        yield from (f"{path}: {p}" for p in sample.problems)
    for name, model in _models(items).items():
        yield from (f"{name}: {line}" for line in (*buried(model), *odd_units(model), *split_sides(model)))
    for path, setup in _all(items, Setup):
        yield from (f"{path}: {t.name}: {line}" for t in setup.targets for line in on_own_colour(t.model, t.label))
    for path, coco in _all(items, Annotations):
        yield from annotation_problems(path, coco, _models(items))
    for path, constraints in _all(items, ConstraintContent):
        yield from _constraints(path, constraints, _models(items))
    for path, setup in _all(items, Setup):
        yield from _setup(path, setup, items)
    for path, camera in _all(items, Camera):
        yield from _calibration(path, camera, items)
    yield from _stamps(items)


def warnings(items: Sequence[Item]) -> Iterator[str]:
    """What works and may not be meant, as `artrec model` says it, too."""
    for path, model in _all(items, ObjectModel):
        yield from (f"{path}: {line}" for line in unborne(model))
    for path, setup in _all(items, Setup):
        said, seen = defaultdict[str, list[str]](list), setup.recognizer  # of one file once, however many go by it
        for t in setup.targets:
            small = too_small(t.model, seen.min_scale, seen.min_blob_px)
            for line in (*unborne(t.model), *shared_classes(t.model, t.label), *small):
                said[line].append(t.name)
        yield from (f"{path}: {', '.join(names)}: {line}" for line, names in said.items())
        yield from (f"{path}: {line}" for line in wide_limits(seen))


def calibrated_images(items: Sequence[Item]) -> bool | None:
    """Whether a calibration comes with images or beside them; None: there are neither images nor a calibration."""
    samples = [s for _, found in _samples(items) for s in found]
    cameras = bool(_all(items, Camera)) or any(s.camera for s in samples)
    return cameras if cameras or samples else None


def _all(items: Sequence[Item], kind: type[T]) -> list[tuple[Path, T]]:
    return [(i.path, i.content) for i in items if isinstance(i.content, kind)]


def _models(items: Sequence[Item]) -> dict[str, ObjectModel]:
    """Objects by the file that tells of them; those of parameters by the parameters' file and the object's name."""
    models = {str(path): model for path, model in _all(items, ObjectModel)}
    return models | {f"{p}: {t.name}": t.model for p, setup in _all(items, Setup) for t in setup.targets}


def _samples(items: Sequence[Item]) -> list[tuple[Path, tuple[Sample, ...]]]:
    bags = [(path, bag.samples) for path, bag in _all(items, BagContent)]
    return bags + [(path, (sample,)) for path, sample in _all(items, Sample)]


def _bag_alone(path: Path, bag: BagContent) -> Iterator[str]:
    yield from bag.problems
    if not bag.samples:
        names = [f"{t.name} ({t.msgtype})" for t in bag.topics] or ["none at all"]
        more = f" and {len(names) - _LISTED} more" if len(names) > _LISTED else ""
        yield f"{path}: holds no image topic (topics: {', '.join(names[:_LISTED])}{more})"
    for s in bag.samples:
        yield from (f"{path}: {s.name}: {p}" for p in s.problems)
        if s.camera is not None and s.size is not None and s.camera.size != s.size:
            (w, h), (cw, ch) = s.size, s.camera.size
            yield f"{path}: {s.name}: images have {w}x{h} pixels, but the calibration beside them is for {cw}x{ch}"
        elif s.camera is not None:
            yield from (f"{path}: {s.name}: {line}" for line in odd_calibration(s.camera))


def _constraints(path: Path, constraints: ConstraintContent, models: Mapping[str, ObjectModel]) -> Iterator[str]:
    named = [m for m in models.values() if m.name == constraints.object]
    if models and not named:
        known = ", ".join(f"'{name}'" for name in dict.fromkeys(m.name for m in models.values()))
        yield f"{path}: these constraints are of object '{constraints.object}', but the objects here are {known}"
    for model in named[:1]:
        try:
            load_constraints(path, model)
        except ConfigError as error:
            yield str(error)


def _setup(path: Path, setup: Setup, items: Sequence[Item]) -> Iterator[str]:
    later = list(colourless(setup.image)) if setup.image.is_uncoloured else []  # learning them is the next step
    lacks = setup.lacks(calibrated_images(items) is not False)
    yield from (f"{path}: {line}" for line in lacks if line not in later)
    yield from (f"{path}: {line}" for line in scene_problems(setup, items))
    used = {t.model.name for t in setup.targets}
    for other, model in _all(items, ObjectModel):
        if model.name not in used:
            yield f"{other}: object '{model.name}' is none of {path}'s ({', '.join(sorted(used))})"
    for other, truth in _all(items, TruthContent):
        labels = {t.label for t in setup.targets}
        if truth.labels and not labels & set(truth.labels):
            shown = ", ".join(map(str, truth.labels))
            yield f"{other}: its objects have labels {shown}; {path} looks for {', '.join(map(str, sorted(labels)))}"
    for other, results in _all(items, ResultContent):
        if foreign := sorted(set(results.objects) - {t.name for t in setup.targets}):
            yield f"{other}: '{foreign[0]}' is no object of {path} ({', '.join(t.name for t in setup.targets)})"
    calibrated = bool(_all(items, Camera))
    for other, samples in _samples(items):
        yield from image_problems(path, setup, other, samples, calibrated)


def _calibration(path: Path, camera: Camera, items: Sequence[Item]) -> Iterator[str]:
    yield from (f"{path}: {line}" for line in odd_calibration(camera))
    for other, samples in _samples(items):
        for s in samples:
            if s.size is not None and s.size != camera.size:
                yield (
                    f"{path}: is for {camera.size[0]}x{camera.size[1]} pixels, but {other}: {s.name} has "
                    f"{s.size[0]}x{s.size[1]}"
                )


def _stamps(items: Sequence[Item]) -> Iterator[str]:
    """Truth and results are matched with images, and with each other, by stamp."""
    stamped = [(p, t.stamps) for p, t in _all(items, TruthContent)]
    stamped += [(p, r.stamps) for p, r in _all(items, ResultContent)]
    for path, bag in _all(items, BagContent) if stamped else ():
        try:
            found = frozenset[int]().union(*(image_stamps(path, s.name) for s in bag.samples))
        except SourceError as error:
            yield str(error)
            continue
        stamped.append((path, found))
    for (first, known), (second, others) in zip(stamped, stamped[1:], strict=False):
        if known and others and not known & others:
            gap = np.abs(np.array(sorted(known))[:, None] - np.array(sorted(others))[None, :]).min()
            yield (
                f"{first}: none of its {len(known)} stamps is one of {second}'s {len(others)}; the nearest two are "
                f"{gap / 1e9:.6g} s apart"
            )
