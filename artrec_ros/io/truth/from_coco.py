"""Truth from COCO keypoint files: the markers' axes that somebody annotated, by image file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from ...core.base.errors import SourceError
from ...core.geometry.transforms import Array, readonly
from ..base.json_files import read_json
from ..base.yaml_files import Value
from ..learned.annotations import IDENTITY, MACHINE, MADE_BY, AnnotatedObject, load_coco
from ..learned.marked_objects import crowds
from ..sources.opening import stamps_by_name
from .records import FrameKey, Told, TrueObject, Truth, keys_by_name


def load_coco_truth(path: Path) -> Truth:
    """Annotated objects by image: by the file's name, or by its stamp where all names are stamps.

    Images with annotations that the recogniser made and nobody has mended are left out: they would praise it for
    agreeing with itself.

    :raises SourceError, ConfigError: no image, a name that is there twice, a file that is no COCO keypoint file.
    """
    annotations = load_coco([path])
    images = _images(read_json(path))
    if not images:
        raise SourceError(f"{path}: images: holds no image")
    keys = dict(zip(images, stamps_by_name(images) or keys_by_name(images, path), strict=True))
    frames: dict[FrameKey, tuple[TrueObject, ...]] = {key: () for key in keys.values()}
    for annotated in annotations.objects:
        if annotated.points:
            frames[keys[annotated.image]] += (_object(annotated),)
    machine_made = {keys[o.image] for o in annotations.objects if o.by_machine}
    kept = {key: objects for key, objects in frames.items() if key not in machine_made}
    if not kept:
        raise SourceError(
            f"{path}: no truth: each image has annotations that the recogniser made (attribute {MADE_BY}: {MACHINE}); "
            "mark some images by hand"
        )
    ignored: dict[FrameKey, tuple[Array, ...]] = {}
    for image, outline in crowds([path], None):
        ignored[keys[image]] = (*ignored.get(keys[image], ()), outline)
    return Truth(kept, str(path), left_out=len(machine_made), crowds=ignored)


def _images(top: Value) -> list[Path]:
    """All images, also those without an object; `load_coco` has checked the file."""
    return [_path(value) for value in top.entries()["images"].items()]


def _path(image: Value) -> Path:
    return image.file.parent / image.entries()["file_name"].text()


def _object(annotated: AnnotatedObject) -> TrueObject:
    stems = {name.rpartition(".")[0] for name in annotated.points}
    axes = {stem: readonly(axis) for stem in sorted(stems) if (axis := annotated.axis(stem)) is not None}
    middle = readonly(np.mean(list(annotated.points.values()), axis=0))
    who = annotated.attributes.get(IDENTITY)
    return TrueObject(None, None, {}, middle, annotated.category, axes=axes, told=Told.LABELLED, identity=who)
