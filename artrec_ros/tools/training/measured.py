"""What the recogniser measures in the annotated images, beside what the annotations say."""

from __future__ import annotations

import sys
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from ...core.base.errors import ConfigError, ImageError
from ...core.constraints.axis_offsets import AxisOffset, learn_axis_offset
from ...core.constraints.constraint_set import ConstraintSet
from ...core.constraints.pairs import Key
from ...core.geometry.transforms import wrap_angle
from ...core.image.segmentation import Segmenter
from ...core.model.found import Detection, Instance
from ...core.model.objects import ObjectModel
from ...core.recognizer import Recognizer
from ...core.ways import PAPER, PLANE, way_of
from ...io.learned.annotations import AnnotatedObject, Annotations, annotated_image
from ...io.parameters.parameter_file import Setup, setup_from_flat
from ...io.parameters.sections import read_files
from ..getting_ready import progress

_NEAR = 0.5  # farthest detection of an annotated object, in lengths of its required marker's axis
_ENOUGH = 0.9  # share of the annotated markers
_CLEARLY_MORE = 1.02  # times the markers that are found with less noise
_NOISES_PX = (0.75, 1.0, 1.5, 2.0)
_LARGEST_RAD = np.pi / 4  # beyond it an axis was taken for another of the marker's symmetry


@dataclass(frozen=True)
class Measured:
    """Offsets of axes; how many of the annotated objects the recogniser found, and so measured; how many markers."""

    axes: tuple[AxisOffset, ...]
    found: int
    annotated: int
    markers_found: int
    markers: int

    def __str__(self) -> str:
        return (
            f"{self.found} of {self.annotated} annotated objects, with {self.markers_found} of {self.markers} markers"
        )


def load_setup(path: Path, *more: Path) -> Setup:
    """The set-up of a parameter file, or several, without the constraint files, which training is about to write."""
    flat, folder, source = read_files(path, *more)
    return setup_from_flat({k: v for k, v in flat.items() if not k.endswith(".constraint_file")}, folder, source)


def measure_axes(setup: Setup, model: ObjectModel, constraints: ConstraintSet, annotations: Annotations) -> Measured:
    """Runs the recogniser, in the image plane, over the annotated images and learns where axes differ.

    :raises ConfigError: the set-up has no object with this model, or an image cannot be used.
    """
    bare = replace(constraints, axes=(), classes=())
    targets = tuple(replace(t, constraints=bare) for t in setup.targets if t.model.name == model.name)
    if not targets:
        known = ", ".join(f"{t.name} ({t.model.name})" for t in setup.targets)
        raise ConfigError(f"--params-file: none of its objects is a '{model.name}'; it has {known}")
    with progress() as told:
        recognizer = Recognizer(targets, setup.recognizer, Segmenter(setup.image), calibrated=False, told=told)
    examples = annotations.examples(model)
    by_image: dict[Path, list[tuple[AnnotatedObject, dict[Key, Instance]]]] = defaultdict(list)
    for annotated, example in zip(annotations.objects, examples, strict=True):
        by_image[annotated.image].append((annotated, example))
    directions: dict[Key, list[tuple[float, float]]] = defaultdict(list)
    found = markers = 0
    for path, objects in by_image.items():
        detections = _recognized(recognizer, path, objects[0][0])
        for _, example in objects:
            hit = _nearest(detections, example, model)
            found += hit is not None
            markers += sum((c.component, c.marker) in example for c in hit.components) if hit else 0
            for key, pair in _directions(hit, example) if hit else ():
                directions[key].append(pair)
    return Measured(tuple(_learned(model, directions)), found, len(examples), markers, sum(map(len, examples)))


def way_out(
    setup: Setup, model: ObjectModel, constraints: ConstraintSet, annotations: Annotations, measured: Measured
) -> str | None:
    """How most annotated objects would be found where few were, by trying: with how much more noise of contours.

    Annotations may be exact while outlines are not: those of small markers are found too large or too small where lens
    and segmenter blur their edges. None: enough were found.
    """
    if measured.markers_found >= _ENOUGH * measured.markers:
        return None
    print("The recogniser finds few of what is annotated; looking why ...", file=sys.stderr, flush=True)
    now, best = setup.recognizer.constraints.contour_noise_px, (measured, 0.0)
    ways = {way_of(t, setup.recognizer, calibrated=False) for t in setup.targets if t.model.name == model.name}
    for noise in (n for n in _NOISES_PX if n > now and ways & {PAPER, PLANE}):  # others read no constraints
        room = replace(setup.recognizer.constraints, contour_noise_px=noise)
        tried = replace(setup, recognizer=replace(setup.recognizer, constraints=room))
        with_it = measure_axes(tried, model, constraints, annotations)
        if with_it.markers_found > _CLEARLY_MORE * best[0].markers_found:
            best = with_it, noise
    more, noise = best
    if not noise:
        return "What it sees, and why it turns candidates down, shows artrec replay --labels over these images."
    return (
        f"With expert.constraints.contour_noise_px: {noise:g} it finds {more}: outlines in these images are farther "
        f"off than the {now:g} px that are reckoned with. It holds for all objects of a parameter file, and lets in "
        "more that is wrong, too: compare on images that were not trained on (artrec evaluate) before you set it there."
    )


def _recognized(recognizer: Recognizer, path: Path, annotated: AnnotatedObject) -> Sequence[Detection]:
    try:
        return recognizer.recognize(annotated_image(path, annotated.size)).detections
    except ImageError as error:
        raise ConfigError(f"{annotated.place}: {path}: {error}; --images tells where the images lie") from None


def _nearest(detections: Sequence[Detection], example: dict[Key, Instance], model: ObjectModel) -> Detection | None:
    """The detection that lies on an annotated object's required component."""
    for marker in model.required.markers:
        place = example.get((model.required.name, marker.name))
        if place is None or not detections:
            continue
        reach = _NEAR * place.scale * marker.axis_length
        distances = [float(np.hypot(d.image.x - place.x, d.image.y - place.y)) for d in detections]
        if min(distances) <= reach:
            return detections[int(np.argmin(distances))]
    return None


def _directions(detection: Detection, example: dict[Key, Instance]) -> Iterator[tuple[Key, tuple[float, float]]]:
    """Of each marker that was found and is annotated: the axis' direction as fitted and as annotated."""
    for instance in detection.components:
        key = (instance.component, instance.marker)
        if key in example and abs(wrap_angle(example[key].theta - instance.theta)) < _LARGEST_RAD:
            yield key, (instance.theta, example[key].theta)


def _learned(model: ObjectModel, directions: dict[Key, list[tuple[float, float]]]) -> Iterator[AxisOffset]:
    for key, marker in model.markers.items():
        pairs = np.array(directions.get(key, []), float).reshape(-1, 2)
        if marker.disc_radius is None and len(pairs):  # a disc's axis has no direction
            axis = learn_axis_offset(key, marker, pairs[:, 0], pairs[:, 1])
            if axis is not None:
                yield axis
