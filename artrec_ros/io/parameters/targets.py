"""An object to look for, from its parameters and the files that they name."""

from __future__ import annotations

import dataclasses
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...core.base.config import ImageConfig, ObjectConfig, RecognizerConfig
from ...core.base.errors import ConfigError
from ...core.constraints.constraint_set import ConstraintSet
from ...core.constraints.pairs import PairConstraint
from ...core.model.kinematics import Kinematics
from ...core.model.target import Target
from ...core.ways import FACING, PAPER, PLANE, way_of
from ..base.shared_files import resolve_path
from ..base.yaml_files import Value
from ..learned.constraints import load_constraints
from ..objects.object_reader import load_object
from .sections import FILES

_RELIEF = 0.05  # of markers' extent: seen at a slant of 45 degrees they are off by so much of it


def with_absolute_paths(config: ObjectConfig, name: str, values: Mapping[str, Value], base_dir: Path) -> ObjectConfig:
    """An object's parameters with absolute file names.

    :param values: parameters by their full names, for errors. :param base_dir: where relative names start.
    :raises ConfigError: a package:// that is not installed.
    """
    paths: dict[str, Any] = {}
    for key in FILES:
        given = getattr(config, key)
        if given or key == "object_file":
            try:
                paths[key] = str(resolve_path(given, base_dir))
            except ConfigError as error:
                raise values[f"{name}.{key}"].error(str(error)) from None
    return dataclasses.replace(config, **paths)


def load_target(name: str, config: ObjectConfig, image: ImageConfig, values: Mapping[str, Value]) -> Target:
    """The object of this name. :raises ConfigError: a file that is missing or not valid, or an unknown label."""
    for key in FILES:
        path = getattr(config, key)
        if path and Path(path).exists() and not Path(path).is_file():
            raise values[f"{name}.{key}"].error(f"{path} is a folder, pipe or device; a file is wanted here")
        if path and not Path(path).is_file():
            way_out = "; artrec train makes it" if key == "constraint_file" else ""
            raise values[f"{name}.{key}"].error(f"there is no file {path}{way_out}")
    labels = dict(image.named_labels)
    if image.kind != "labels" and config.label not in labels.values():
        known = ", ".join(f"{label} ({class_name})" for class_name, label in labels.items())
        raise values[f"{name}.label"].error(f"{config.label} is no label of image.classes (known: {known})")
    model = load_object(config.object_file, labels)
    constraints = load_constraints(config.constraint_file, model) if config.constraint_file else None
    return Target(name, model, config.label, constraints)


def lacking(targets: Sequence[Target], config: RecognizerConfig, calibrated: bool = True) -> Iterator[str]:
    """A line for each object whose components, or some of them, cannot be put together.

    :param calibrated: images come with a calibration.
    """
    fits = config.profile == "default" and config.whole_object
    for target in targets:
        model = target.model
        if len(model.components) == 1:
            continue
        pairs = target.constraints.pairs if isinstance(target.constraints, ConstraintSet) else ()
        way = way_of(target, config, calibrated=calibrated)
        if way == FACING and not config.scene.plane.is_given:
            yield from _in_relief(target, bool(pairs))
        if pairs:
            if way in (PAPER, PLANE):
                yield from _unpaired(target, pairs)
            continue
        missing = "it has no constraint_file" if target.constraints is None else "its constraint_file has no pairs"
        way_out = f"learn constraints with artrec train and name their file in {target.name}.constraint_file"
        if not model.is_spatial:
            where = "not every one of its markers has a pose"
        elif not fits:
            where = "recognizer.profile and recognizer.whole_object keep it in the image plane"
        elif way == PLANE:
            where = "it is not flat, and there is no calibration to find it in space"
            way_out = f"give a calibration, be it a guessed one (docs/camera.md), or {way_out}"
        else:
            continue
        yield f"{target.name}: will not be found: {missing}, and {where}; {way_out}"


def _in_relief(target: Target, learned: bool) -> Iterator[str]:
    """A line where an object is taken for a figure in one plane, and is none seen at a slant. :param learned: it has
    constraints."""
    if (relief := Kinematics(target.model).relief) > _RELIEF:
        own = "; recognizer.whole_object: false goes by its learned pairs instead" if learned else ""
        yield (
            f"{target.name}: its markers stand one above the other, by {relief:.0%} of their extent: without "
            f"calibration it is right only where the camera looks straight at them; give one, be it a guess "
            f"(docs/camera.md){own}"
        )


def _unpaired(target: Target, pairs: Sequence[PairConstraint]) -> Iterator[str]:
    paired = {key[0] for p in pairs for key in (p.first, p.second)}
    if alone := [c.name for c in target.model.components if c.name not in paired]:
        stand = "stands" if len(alone) == 1 else "stand"
        yield (
            f"{target.name}: {', '.join(alone)} {stand} in no pair of its constraint_file: never told beside other "
            "components; learn constraints anew with artrec train"
        )


def colourless(image: ImageConfig) -> Iterator[str]:
    """A line for the classes of colour images that have no colour, if there are any: the first one takes every pixel
    that none before it has."""
    bare = [name for name, c in image.classes.items() if image.kind == "colour" and c.is_bare]
    if bare:
        yield (
            f"image.classes: no colour is given for {', '.join(bare)}, so '{bare[0]}' takes all pixels that no class "
            f"before it has; let artrec learn-colours learn them and give its file as a further parameter file, or set "
            f"image.{bare[0]}.rgb or hue, saturation, value"
        )


def unclassed(targets: Sequence[Target], image: ImageConfig) -> Iterator[str]:
    """A line for each class of markers that no class of colours makes: they will not be seen."""
    if image.kind == "labels":
        return
    known = {label for _, label in image.named_labels}
    for target in targets:
        for label in sorted(target.labels - known):
            of = [c.name for c in target.model.components if label in c.labels(target.label)]
            yield f"{target.name}: image.classes has no class of label {label}: {', '.join(of)} will not be seen"


def same_labels(a: ImageConfig, b: ImageConfig) -> bool:
    """Whether targets read with one are as if read with the other."""
    return a.kind == b.kind and dict(a.named_labels) == dict(b.named_labels)
