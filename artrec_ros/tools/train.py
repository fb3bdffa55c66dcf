"""`artrec train`: learns an object's constraints from annotated images, and says how far they can be trusted."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass, replace

from ..core.base.errors import ConfigError
from ..core.constraints.classes import ConfigurationClass
from ..core.constraints.constraint_set import ConstraintSet
from ..core.geometry.camera import Camera
from ..core.learning.class_learning import learn_class
from ..core.learning.pair_learning import Example, learn
from ..core.model.objects import ObjectModel
from ..io.images.cameras import load_camera
from ..io.learned.annotations import Annotations, load_coco
from ..io.learned.constraints import save_constraints
from ..io.objects.object_reader import load_object
from .options.outputs import OF_CONSTRAINTS, check_output
from .options.paths import path
from .training.annotated_joints import JointFitter
from .training.marked_lengths import hint
from .training.measured import load_setup, measure_axes, way_out
from .training.misplaced_marks import misplaced
from .training.train_from_joints import add_from_joints, constraints_from, examples_from_joints
from .training.train_report import report

_LEAST_EXAMPLES = 2


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    parser = subparsers.add_parser("train", help="learn an object's constraints", description=__doc__)
    parser.add_argument("--object", required=True, type=path, metavar="OBJECT.yaml", help="what the object is")
    source = parser.add_mutually_exclusive_group(required=True)
    source.add_argument(
        "--annotations", type=path, nargs="+", action="extend", metavar="COCO.json",
        help="COCO keypoints named COMPONENT/MARKER.tail and COMPONENT/MARKER.head",
    )  # fmt: skip
    source.add_argument(
        "--from-joints", action="store_true",
        help="learn from the places and joints that the object file declares, over a range of views, without images",
    )  # fmt: skip
    parser.add_argument(
        "--category", nargs="+", action="extend", default=[], metavar="NAME",
        help="annotations to use (default: all). Two or more become classes of configurations, each with constraints "
        "of its own, that recognised objects are told apart by",
    )  # fmt: skip
    parser.add_argument("-o", "--output", required=True, type=path, metavar="CONSTRAINTS.yaml", help="file to write")
    parser.add_argument(
        "--coverage", type=float, default=0.95, metavar="SHARE",
        help="share of new examples that each pair's box, and each class's region, shall hold: 0 (the bare box) to "
        "0.999 (default %(default)s)",
    )  # fmt: skip
    parser.add_argument(
        "--max-scale-ratio", type=float, default=2.0, metavar="RATIO",
        help="leave out markers whose scale is below their object's largest by more than this: they are seen too "
        "obliquely to be found by their shape (default %(default)s: 60 degrees)",
    )  # fmt: skip
    parser.add_argument(
        "--params-file", type=path, action="append", metavar="NODE.yaml",
        help="run the recogniser over the annotated images as this parameter file says, and learn how annotated axes "
        "differ from fitted outlines; may be given again: later ones go before",
    )  # fmt: skip
    parser.add_argument("--images", type=path, metavar="DIR", help="where the images lie (default: beside each file)")
    parser.add_argument(
        "--camera-info", type=path, metavar="FILE",
        help="calibration of the annotated images; without it the focal length is found from the examples, where "
        "classes of an object in space need it",
    )  # fmt: skip
    add_from_joints(parser)


def run(args: argparse.Namespace) -> int:
    """Learns, writes the constraint file, prints the report."""
    if not 0 <= args.coverage <= 0.999:
        raise ConfigError(f"--coverage: {args.coverage} is not within 0 .. 0.999")
    if not args.max_scale_ratio >= 1:
        raise ConfigError(f"--max-scale-ratio: {args.max_scale_ratio} is below 1")
    inputs = [args.object, *(args.annotations or ()), *(args.params_file or ()), *filter(None, [args.camera_info])]
    check_output(args.output, inputs, OF_CONSTRAINTS)
    model = load_object(args.object)
    if args.from_joints:
        return _run_from_joints(args, model)
    setup = load_setup(*args.params_file) if args.params_file else None
    camera = load_camera(args.camera_info) if args.camera_info else None
    annotations = load_coco(args.annotations, args.images).of(args.category)
    training = train(model, annotations, args.coverage, args.max_scale_ratio)
    constraints = training.constraints
    lines = []
    names = tuple(dict.fromkeys(args.category))
    if len(names) > 1:
        classes, more = _train_classes(model, annotations, names, args.coverage, args.max_scale_ratio, camera)
        constraints, lines = replace(constraints, classes=classes), more
    if setup is not None:
        measured = measure_axes(setup, model, constraints, annotations)
        constraints = replace(constraints, axes=measured.axes)
        lines.append(f"The recogniser found {measured}.")
        lines += filter(None, [way_out(setup, model, constraints, annotations, measured)])
    save_constraints(args.output, constraints)
    lines += hint(annotations, model, camera, args.object)
    print("\n".join([*report(model, training.examples, constraints), *lines]))
    print("".join(f"{line}\n" for line in misplaced(annotations.objects)), end="")
    if half := annotations.half_labelled():
        print(f"{half} markers have only one end of their axis labelled and were left out.")
    if annotations.crowds:
        print(f"{len(annotations.crowds)} annotations of crowds (iscrowd: 1) were left out.")
    if training.oblique:
        print(f"{training.oblique} markers are seen too obliquely (--max-scale-ratio) and were left out.")
    print(f"Wrote {args.output}: {len(constraints.pairs)} pairs of object '{model.name}'.")
    return 0


def _run_from_joints(args: argparse.Namespace, model: ObjectModel) -> int:
    """The same without annotations."""
    if args.category or args.params_file or args.images:
        raise ConfigError("--category, --params-file and --images go with --annotations, not with --from-joints")
    examples = [_without_oblique(e, args.max_scale_ratio) for e in examples_from_joints(args, model)]
    constraints = constraints_from(model, examples, args.coverage)
    save_constraints(args.output, constraints)
    print("\n".join(report(model, examples, constraints, made_up=True, detailed=args.debug)))
    print(f"Wrote {args.output}: {len(constraints.pairs)} pairs of object '{model.name}', from its joints alone.")
    return 0


@dataclass(frozen=True)
class Training:
    """What was learned, from which examples; `oblique` counts markers that were left out."""

    constraints: ConstraintSet
    examples: list[Example]
    oblique: int


def train(model: ObjectModel, annotations: Annotations, coverage: float, max_scale_ratio: float) -> Training:
    """Constraints from annotations.

    :param coverage: share of new examples that each pair's box shall hold.
    :param max_scale_ratio: markers of smaller scale than their object's largest by more than this are left out.
    """
    everything = [e for e in annotations.examples(model) if e]
    examples = [_without_oblique(e, max_scale_ratio) for e in everything]
    constraints = learn(model, examples, coverage, _LEAST_EXAMPLES)
    if not constraints.pairs and len(model.components) > 1:
        crowds = f" ({len(annotations.crowds)} of crowds, iscrowd: 1, not counted)" if annotations.crowds else ""
        raise ConfigError(
            f"of {len(annotations.objects)} annotations{crowds}, {len(examples)} show a marker of object "
            f"'{model.name}' and no pair of its components is seen together in {_LEAST_EXAMPLES} or more; annotate "
            "both ends of both axes"
        )
    return Training(constraints, examples, sum(map(len, everything)) - sum(map(len, examples)))


def _without_oblique(example: Example, max_scale_ratio: float) -> Example:
    """The example without the markers that are seen too obliquely."""
    least = max((i.scale for i in example.values()), default=0.0) / max_scale_ratio
    return {key: i for key, i in example.items() if i.scale >= least}


def _train_classes(
    model: ObjectModel,
    annotations: Annotations,
    names: Sequence[str],
    coverage: float,
    max_scale_ratio: float,
    camera: Camera | None,
) -> tuple[tuple[ConfigurationClass, ...], list[str]]:
    """A class of configurations per category, and lines that tell how its joints were found.

    :raises ConfigError: a category shows no pair of components together.
    """
    fitter = JointFitter.of(model, annotations.objects, camera)
    classes, lines = [], []
    for name in names:
        own = annotations.of([name])
        examples = [_without_oblique(e, max_scale_ratio) for e in own.examples(model) if e]
        joints = fitter.joints(own.objects) if fitter else []
        learned = learn_class(name, model, examples, joints, coverage)
        if not learned.pairs and not learned.joints:
            raise ConfigError(f"category '{name}': no pair of components is seen together in {_LEAST_EXAMPLES} or more")
        if fitter:
            lines.append(f"class '{name}': joints found in {len(joints)} of {len(own.objects)} examples")
        classes.append(learned)
    if fitter:
        lines.append(fitter.summary())
    return tuple(classes), lines
