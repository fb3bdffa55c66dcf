"""Whether images are of the kind and the classes that parameters speak of, and calibrated where that matters."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from ...core.base.errors import ImageError
from ...core.image.segmentation import Segmenter
from ...core.model.target import Target
from ...core.ways import SPACE, way_of
from ...io.images.folders import LOSSY
from ...io.inventory.contents import Sample
from ...io.parameters.parameter_file import Setup
from .nothing_left import nothing_left

_COLOURS = 3  # channels
_EXCHANGED = "; some have it when red and blue are exchanged: does the encoding, or image.classes, have them so?"


def image_problems(
    parameters: Path, setup: Setup, source: Path, samples: Sequence[Sample], calibrated: bool
) -> Iterator[str]:
    """A line for each.

    :param parameters: the file of `setup`. :param source: the bag or folder that the samples are of.
    :param calibrated: whether there is a calibration beside them.
    """
    wanted = 1 if setup.image.kind == "labels" else 3
    fitting = [s for s in samples if s.channels == wanted]
    if samples and not fitting:
        shown = ", ".join(f"{s.name}: {s.channels or 'no readable'} channel(s)" for s in samples)
        kind = f"image.kind '{setup.image.kind}' of {parameters}"
        way_out = (
            "" if wanted == 3 else "; of colour images image.kind is colour, and artrec learn-colours finds the classes"
        )
        yield f"{source}: no images of {wanted} channel(s), which {kind} needs ({shown}){way_out}"
    if len(fitting) > 1:
        names = ", ".join(s.name for s in fitting)
        yield f"{source}: {len(fitting)} topics fit image.kind '{setup.image.kind}': {names}; choose one with --topic"
    for sample in fitting:
        if setup.image.kind == "labels" and sample.lossy:
            yield f"{_where(source, sample)}: {LOSSY}"
        yield from _labels(parameters, setup, source, sample)
        ways = {t.name: way_of(t, setup.recognizer, calibrated=True) for t in setup.targets if not t.model.is_flat}
        spatial = [name for name, way in ways.items() if way == SPACE]
        if sample.camera is None and not calibrated and spatial:
            reason = sample.camera_problem or "no calibration: name a calibration file beside it"
            yield f"{_where(source, sample)}: {reason}: no poses in space of {', '.join(spatial)}"


def _where(source: Path, sample: Sample) -> str:
    """The topic of a bag, or the folder, which has one sample of its own name."""
    return str(source) if sample.name == source.name else f"{source}: {sample.name}"


def _labels(parameters: Path, setup: Setup, source: Path, sample: Sample) -> Iterator[str]:
    if setup.image.is_uncoloured:
        return
    where = _where(source, sample)
    try:
        seen = _seen(setup, sample)
    except ImageError as error:
        yield f"{where}: {error}"
        return
    yield from (f"{where}: {line}" for line in nothing_left(setup, sample))
    expected = [(label, what) for target in setup.targets for label, what in _expected(target).items()]
    missing = [(label, what) for label, what in expected if label not in seen]
    exchanged = _seen(setup, sample, exchanged=True) if missing and sample.channels == _COLOURS else set[int]()
    for label, what in missing:
        shown = ", ".join(map(str, sorted(seen)))
        yield (
            f"{where}: no pixel has label {label}, {what} of {parameters}, in {len(sample.images)} "
            f"images looked at (labels there: {shown}){_EXCHANGED if label in exchanged else ''}"
        )


def _seen(setup: Setup, sample: Sample, exchanged: bool = False) -> set[int]:
    """The labels of all its images. :param exchanged: as if red and blue were. :raises ImageError: none can be told."""
    segmenter = Segmenter(setup.image)
    shown = (np.ascontiguousarray(image[..., ::-1]) if exchanged else image for image in sample.images)
    return {label for image in shown for label in np.unique(segmenter.labels(image)).tolist()}


def _expected(target: Target) -> dict[int, str]:
    """label -> what has it."""
    expected: dict[int, str] = {}
    for c in target.model.components:
        if c.classes:
            pass  # any of them will do
        elif c.label is None:
            expected.setdefault(target.label, f"that of '{target.name}'")
        else:
            expected.setdefault(c.label, f"that of '{target.name}', component '{c.name}'")
        for label in c.body_labels:
            expected.setdefault(label, f"that of '{target.name}', the body of '{c.name}'")
    return expected
