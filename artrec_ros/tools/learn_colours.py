"""`artrec learn-colours`: learns the classes' reference colours from images in which somebody has told the classes."""

from __future__ import annotations

import argparse
import math
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np

from ..core.base.config import GREATEST_LABEL, ImageConfig
from ..core.base.errors import ConfigError
from ..core.geometry.field_plane import FieldPlane
from ..core.learning.colour_learning import Pair, check_samples, enough
from ..io.base.bars import bar, say
from ..io.images.decoding import read_image
from ..io.images.folders import without_suffix
from ..io.images.video import VIDEO_SUFFIXES
from ..io.learned.colours import save_colours
from ..io.learned.marked_objects import load_marked_objects
from ..io.learned.marked_scales import beyond_marks_px, marked_scales
from ..io.learned.regions import MarkedImage, drawn_regions, load_regions
from ..io.sources.frames import once
from ..io.sources.opening import Frame, SourceOptions, holds_bag, open_sources
from .colour_report import report, size_lines
from .colour_samples import Samples, Told, samples_of_labels, samples_of_regions
from .colour_setup import ColourSetup, load_colour_setup
from .colours_of_samples import learn_from
from .options.outputs import OF_COLOURS, check_output
from .options.paths import path
from .unmarked_things import unmarked_things

_DRAWS = partial(bar, desc="choosing", unit="draw", leave=False)
_GAMMA = (
    "image.gamma is taken to be 1, which label images do not tell; where a camera took the images, give 2.2 in a "
    "parameter file and that with --params-file: fits are finer"
)


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    p = subparsers.add_parser(
        "learn-colours", help="learn a camera's colours", description=__doc__,
        epilog="Either SOURCE comes with label images (bags hold them; folders need --label-images), or --annotations "
        "are boxes and polygons drawn in images, or, with --params-file, the axes of objects as for artrec train: its "
        "objects' files tell outlines and classes. What is of no class is background. --params-file tells classes' "
        "names and labels of all.",
    )  # fmt: skip
    p.add_argument("sources", metavar="SOURCE", nargs="*", type=path, help="bag, folder or video of colour images")
    p.add_argument("--topic", help="topic of the colour images (else the only one with three channels)")
    p.add_argument("--label-topic", help="topic of the label images (else the only one with one channel)")
    p.add_argument("--label-images", type=path, metavar="DIR", help="label images named as the colour images, PNG")
    p.add_argument(
        "--annotations", type=path, nargs="+", default=[], metavar="COCO.json",
        help="boxes or polygons, whose category is the class; with --params-file, keypoints COMPONENT/MARKER.tail and "
        ".head, whose category is the object",
    )  # fmt: skip
    p.add_argument(
        "--params-file", type=path, action="append", metavar="NODE.yaml",
        help="the objects that are seen, and their classes; may be given again: later ones go before",
    )  # fmt: skip
    p.add_argument("--images", type=path, metavar="DIR", help="where annotated images lie (default: beside each file)")
    p.add_argument(
        "--around", type=float, default=math.inf, metavar="PX",
        help="with --annotations and --params-file: learn as background only what is so near to an annotated marker; "
        "for images in which not all objects are annotated (default: all of the image)",
    )  # fmt: skip
    p.add_argument(
        "--classes", nargs="+", type=_named_label, default=[], metavar="NAME=LABEL",
        help="the classes to learn (with --params-file: those that it has no name for)",
    )  # fmt: skip
    p.add_argument("--every", type=int, default=1, metavar="N", help="use every Nth image (default: all)")
    p.add_argument("-o", "--output", required=True, type=path, metavar="COLOURS.yaml", help="file to write")


def run(args: argparse.Namespace) -> int:
    """Learns, writes the colours, prints how well they tell the classes apart."""
    check(args)
    check_output(args.output, [*args.sources, *args.annotations, *(args.params_file or ())], OF_COLOURS)
    setup = _setup(args)
    labels = dict(args.classes) if setup is None else _told_labels(args, setup)
    ranged = {} if setup is None else setup.ranged
    labels = {name: label for name, label in labels.items() if name not in ranged}
    if not labels:
        raise ConfigError("all classes have ranges, which stay: there is nothing to learn")
    samples, told = _samples(args, labels, setup)
    for name, cls in ranged.items():
        for shown in (name, f"label {cls.label}"):  # neither of another class nor background
            samples.pop(shown, None)
        say(f"Class '{name}' is not learned: its ranges are given, and stay")
    for name in _lacking_bodies(samples, setup) if setup is not None else ():
        say(
            f"Class '{name}' (label {labels.pop(name)}) is not learned: too little of it shows; "
            "leave it out of image.classes, and its label out of the body"
        )
        samples.pop(name, None)
    check_samples(samples, labels)
    say(f"Choosing the colours of {len(labels)} classes from {sum(map(len, samples.values()))} pixels ...")
    learned = learn_from(samples, told, labels, _DRAWS, ranged)
    save_colours(args.output, learned.image)
    scales = marked_scales(args.annotations, setup.targets) if setup is not None else np.zeros(0)
    beyond = beyond_marks_px(args.annotations, setup.targets) if setup is not None else {}
    print("\n".join(report(learned, setup.bodies if setup is not None else (), scales, beyond)))
    for line in [*unmarked_things(told, learned.image), *(size_lines(setup, scales) if setup is not None else ())]:
        print(line)
    print(f"Wrote {args.output}: {len(labels)} classes. Give it as a second --params-file, or paste it into the first.")
    return 0


def _setup(args: argparse.Namespace) -> ColourSetup | None:
    if not args.params_file:
        return None
    setup = load_colour_setup(args.params_file, dict(args.classes))
    return setup if args.annotations else setup.in_label_images()


def _told_labels(args: argparse.Namespace, setup: ColourSetup) -> dict[str, int]:
    """The classes that are annotated, by axes or by regions of their names."""
    if not args.annotations:
        return {**setup.labels, **dict(args.classes)}
    if not setup.hidden:
        return dict(setup.labels)
    drawn = {name for own in drawn_regions(args.annotations, args.images).values() for name, _ in own}
    for name, label in setup.hidden.items():
        if name not in drawn:
            say(
                f"Class '{name}' (label {label}) is not learned: no axis shows it, and nobody has drawn it; mark "
                f"boxes or polygons of category '{name}'"
            )
    return {**setup.labels, **{name: label for name, label in setup.hidden.items() if name in drawn}}


def _lacking_bodies(samples: Samples, setup: ColourSetup) -> list[str]:
    """Classes of bodies alone of which too little is seen to learn them: objects are found without."""
    return [name for name in setup.labels if name in setup.bodies and not enough(samples, name)]


def check(args: argparse.Namespace) -> None:
    """:raises ConfigError: options that do not go together."""
    if args.every < 1:
        raise ConfigError(f"--every: {args.every} is below 1")
    if not args.around > 0:
        raise ConfigError(f"--around: {args.around} is not above 0")
    if bool(args.sources) == bool(args.annotations):
        raise ConfigError("give either SOURCE with label images, or --annotations")
    for source in args.sources if args.label_images is None else ():
        if source.is_dir() and not holds_bag(source):
            raise ConfigError(f"{source}: is no bag; name the folder of its label images with --label-images DIR")
        if source.suffix.lower() in VIDEO_SUFFIXES and source.is_file():
            raise ConfigError(
                f"{source}: a video has no label images; name a folder of some of its frames' with --label-images DIR "
                f"({source.stem}_000000.png, ...), or mark pictures of its frames and give --annotations in its place"
            )
    if not args.params_file and not args.classes:
        raise ConfigError("--classes: name the classes to learn, such as red=3, or give --params-file")
    _check_classes(args.classes, apart=not args.annotations)
    if args.images and not args.annotations:
        raise ConfigError("--images goes with --annotations")
    if math.isfinite(args.around) and not (args.params_file and args.annotations):
        raise ConfigError("--around goes with --annotations and --params-file")


def _check_classes(classes: Sequence[tuple[str, int]], *, apart: bool) -> None:
    """:param apart: no two of them may have one label. :raises ConfigError: a name or label is given twice."""
    for name, count in Counter(name for name, _ in classes).items():
        if count > 1:
            raise ConfigError(f"--classes: {name} is given twice; a class has one label")
    for label, count in Counter(label for _, label in classes).items():
        if apart and count > 1:
            names = " and ".join(name for name, own in classes if own == label)
            raise ConfigError(f"--classes: {names} have both label {label}; label images do not tell them apart")


def _samples(args: argparse.Namespace, labels: dict[str, int], setup: ColourSetup | None) -> tuple[Samples, Told]:
    blank, camera = (setup.blank, setup.camera) if setup is not None else ((), ImageConfig())
    known = setup is not None and setup.gamma_known
    if not args.annotations:
        found = samples_of_labels(_pairs(args), labels, args.every, blank, camera)
        if not known:
            say(_GAMMA)
        return found
    marked = _marked(args, labels, setup)[:: args.every]
    samples, told = samples_of_regions(marked, labels, blank, camera, gamma_known=known)
    for name in dict.fromkeys(name for m in marked for name, _ in m.regions):
        if name not in samples and name not in labels:
            say(f"'{name}' is left out: no pixel is its own, for smaller regions or image.blank cover it")
    return samples, told


def _marked(args: argparse.Namespace, labels: dict[str, int], setup: ColourSetup | None) -> list[MarkedImage]:
    if setup is None:
        return [m.smaller_before() for m in load_regions(args.annotations, args.images)]
    names = {label: name for name, label in labels.items()}
    names |= {cls.label: name for name, cls in setup.ranged.items()}
    plane = FieldPlane.of(setup.plane, None) if setup.plane.is_given else None  # a lens bends no outline by much
    return load_marked_objects(args.annotations, setup.targets, names, args.images, args.around, plane)


def _pairs(args: argparse.Namespace) -> Iterator[Pair]:
    """Colour images with their label images."""
    colour = SourceOptions(topic=args.topic, image_kind="colour")
    label = SourceOptions(topic=args.label_topic, image_kind="labels")
    unlabelled, found = list[str](), False
    tell = once(say)  # a bag is opened for either, and tells what it lacks twice
    for source in args.sources:
        with open_sources([source], colour, say) as images:
            if args.label_images is None:
                with open_sources([source], label, say) as label_frames:
                    yield from _checked(_by_stamp(images, label_frames))
                    problems = [*images.problems, *label_frames.problems]
            else:
                for pair in _checked(_by_name(images, args.label_images, unlabelled)):
                    found = True
                    yield pair
                problems = images.problems
        for line in problems:
            tell(line)
    if unlabelled and not found:
        raise ConfigError(
            f"--label-images: {args.label_images} holds no label image that is named like one of {len(unlabelled)} "
            f"frames, such as {without_suffix(unlabelled[0])}.png"
        )


def _by_stamp(images: Iterable[Frame], labels: Iterable[Frame]) -> Iterator[tuple[Frame, Frame]]:
    """Pairs of frames with the same stamp; both come in the order of time."""
    following = iter(labels)
    label = next(following, None)
    for frame in images:
        while label is not None and label.stamp_ns < frame.stamp_ns:
            label = next(following, None)
        if label is not None and label.stamp_ns == frame.stamp_ns:
            yield frame, label


def _by_name(images: Iterable[Frame], folder: Path, unlabelled: list[str]) -> Iterator[tuple[Frame, Frame]]:
    """Pairs of files with the same name but for the suffix; the folder's are PNG.

    :param unlabelled: gets the names of frames that have none.
    """
    for frame in images:
        path = folder / f"{without_suffix(frame.name)}.png"
        if path.is_file():
            yield frame, Frame(frame.stamp_ns, path.name, read_image(path))
        else:
            unlabelled.append(frame.name)


def _checked(pairs: Iterable[tuple[Frame, Frame]]) -> Iterator[Pair]:
    """The images of frames that could be read."""
    for frame, label in pairs:
        if frame.image is None or label.image is None:
            continue
        if frame.image.ndim != 3:
            raise ConfigError(
                f"{frame.name}: a colour image is wanted, and this one has one channel; colours are learned from a "
                "camera's images beside their label images (--topic, --label-topic)"
            )
        if label.image.shape != frame.image.shape[:2]:
            raise ConfigError(
                f"{frame.name}, {label.name}: a colour image and a label image of one size are wanted, not "
                f"{frame.image.shape} and {label.image.shape}"
            )
        yield frame.image, label.image


def _named_label(text: str) -> tuple[str, int]:
    name, _, label = text.partition("=")
    if not name.isidentifier() or not label.isdecimal() or not 1 <= int(label) <= GREATEST_LABEL:
        raise argparse.ArgumentTypeError(f"'{text}' is no NAME=LABEL with a label of 1 to {GREATEST_LABEL}")
    if name in vars(ImageConfig()):
        raise argparse.ArgumentTypeError(f"'{name}' is the name of a parameter; choose another")
    return name, int(label)
