"""`artrec learn-colours`: learns the classes' reference colours from images in which somebody has told the classes."""

from __future__ import annotations

import argparse
import sys
from collections import defaultdict
from collections.abc import Iterable, Iterator
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ..core.base.config import ImageConfig
from ..core.base.errors import ConfigError
from ..core.learning.colour_learning import Learned, learn_colours, sample_colours
from ..io.images.decoding import read_image
from ..io.learned.colours import save_colours
from ..io.learned.regions import load_regions
from ..io.sources.opening import Frame, SourceOptions, open_sources

_UNMARKED = 255  # number of the pixels that nobody has marked
_SHARPEN_PX = 1
_WORTH_TELLING = 0.01  # share of a class that gets another's label

Pair = tuple[NDArray[np.uint8], NDArray[np.uint8]]  # colour image, class numbers


def add_parser(subparsers: argparse._SubParsersAction) -> None:
    p = subparsers.add_parser(
        "learn-colours", help="learn a camera's colours", description=__doc__,
        epilog="Either SOURCE comes with label images (bags hold them; folders need --label-images), or --annotations "
        "are boxes and polygons drawn in images. Labels and categories that --classes does not name are background.",
    )  # fmt: skip
    p.add_argument("sources", metavar="SOURCE", nargs="*", type=Path, help="bag or folder of colour images")
    p.add_argument("--topic", help="topic of the colour images (else the only one with three channels)")
    p.add_argument("--label-topic", help="topic of the label images (else the only one with one channel)")
    p.add_argument("--label-images", type=Path, metavar="DIR", help="label images named as the colour images, PNG")
    p.add_argument(
        "--annotations", type=Path, nargs="+", default=[], metavar="COCO.json",
        help="boxes or polygons; their category is the class",
    )  # fmt: skip
    p.add_argument(
        "--classes", required=True, nargs="+", type=_named_label, metavar="NAME=LABEL", help="the classes to learn"
    )  # fmt: skip
    p.add_argument("--every", type=int, default=1, metavar="N", help="use every Nth image (default: all)")
    p.add_argument("-o", "--output", required=True, type=Path, metavar="COLOURS.yaml", help="file to write")


def run(args: argparse.Namespace) -> int:
    """Learns, writes the colours, prints how well they tell the classes apart."""
    labels = dict(args.classes)
    if args.every < 1:
        raise ConfigError(f"--every: {args.every} is below 1")
    if bool(args.sources) == bool(args.annotations):
        raise ConfigError("give either SOURCE with label images, or --annotations")
    if args.annotations:
        samples = samples_of_regions(args.annotations, labels)
    else:
        samples = samples_of_labels(_pairs(args), labels, args.every)
    learned = learn_colours(samples, labels, ImageConfig(sharpen_px=_SHARPEN_PX))
    save_colours(args.output, learned.image)
    print("\n".join(report(learned)))
    print(f"Wrote {args.output}: {len(labels)} classes. Give it as a second --params-file, or paste it into the first.")
    return 0


def samples_of_labels(pairs: Iterable[Pair], labels: dict[str, int], every: int) -> dict[str, NDArray[np.uint8]]:
    """Colours by class from images with label images; other labels as 'label N'."""
    names = {n: f"label {n}" for n in range(_UNMARKED)} | {label: name for name, label in labels.items()}
    return _collect((pair for i, pair in enumerate(pairs) if i % every == 0), names)


def samples_of_regions(paths: Iterable[Path], labels: dict[str, int]) -> dict[str, NDArray[np.uint8]]:
    """Colours by category from images with marked regions."""
    marked = load_regions(paths)
    names = dict(enumerate(dict.fromkeys([*labels, *(name for m in marked for name, _ in m.regions)]), start=1))
    numbers = {name: n for n, name in names.items()}
    return _collect((m.read(numbers, _UNMARKED) for m in marked), names)


def _collect(pairs: Iterable[Pair], names: dict[int, str]) -> dict[str, NDArray[np.uint8]]:
    rng = np.random.default_rng(0)
    found = defaultdict(list)
    for image, labels in pairs:
        for name, colours in sample_colours(image, labels, names, rng).items():
            found[name].append(colours)
    return {name: np.concatenate(parts) for name, parts in found.items()}


def _pairs(args: argparse.Namespace) -> Iterator[Pair]:
    """Colour images with their label images."""
    colour = SourceOptions(topic=args.topic, image_kind="colour")
    label = SourceOptions(topic=args.label_topic, image_kind="labels")
    for source in args.sources:
        with open_sources([source], colour, _say) as images:
            if args.label_images is None:
                with open_sources([source], label, _say) as label_frames:
                    yield from _checked(by_stamp(images, label_frames))
            else:
                yield from _checked(by_name(images, args.label_images))


def _say(line: str) -> None:
    print(line, file=sys.stderr)


def by_stamp(images: Iterable[Frame], labels: Iterable[Frame]) -> Iterator[tuple[Frame, Frame]]:
    """Pairs of frames with the same stamp; both come in the order of time."""
    following = iter(labels)
    label = next(following, None)
    for frame in images:
        while label is not None and label.stamp_ns < frame.stamp_ns:
            label = next(following, None)
        if label is not None and label.stamp_ns == frame.stamp_ns:
            yield frame, label


def by_name(images: Iterable[Frame], folder: Path) -> Iterator[tuple[Frame, Frame]]:
    """Pairs of files with the same name but for the suffix; the folder's are PNG."""
    for frame in images:
        path = (folder / frame.name).with_suffix(".png")
        if path.is_file():
            yield frame, Frame(frame.stamp_ns, path.name, read_image(path))


def _checked(pairs: Iterable[tuple[Frame, Frame]]) -> Iterator[Pair]:
    """The images of frames that could be read."""
    for frame, label in pairs:
        if frame.image is None or label.image is None:
            continue
        if frame.image.ndim != 3 or label.image.shape != frame.image.shape[:2]:
            raise ConfigError(
                f"{frame.name}, {label.name}: a colour image and a label image of one size are wanted, not "
                f"{frame.image.shape} and {label.image.shape}"
            )
        yield frame.image, label.image


def report(learned: Learned) -> Iterator[str]:
    """The lines that `artrec learn-colours` prints: per class its references, and what they make of its pixels."""
    width = max(len(name) for name in learned.samples)
    yield f"{'class':{width}}   pixels   right  references r,g,b"
    for name, shares in learned.confusion.items():
        cls = learned.image.classes.get(name)
        right = shares.get(name if cls else "unknown", 0.0)
        references = (
            "; ".join(",".join(map(str, rgb)) for rgb in np.reshape(cls.rgb, (-1, 3))) if cls else "(background)"
        )
        yield f"{name:{width}}  {learned.samples[name]:7d}  {right:6.1%}  {references}"
        others = [(share, other) for other, share in shares.items() if other not in (name, "unknown")]
        for share, other in sorted(others, reverse=True):
            if share >= _WORTH_TELLING:
                yield f"{'':{width}}    {share:.1%} of its pixels are taken for {other}"
    background = np.reshape(learned.image.background, (-1, 3))
    yield f"background: {'; '.join(','.join(map(str, rgb)) for rgb in background) or 'no colour of its own'}"


def _named_label(text: str) -> tuple[str, int]:
    name, _, label = text.partition("=")
    if not name.isidentifier() or not label.isdecimal() or not 1 <= int(label) <= 253:
        raise argparse.ArgumentTypeError(f"'{text}' is no NAME=LABEL with a label of 1 to 253")
    if name in vars(ImageConfig()):
        raise argparse.ArgumentTypeError(f"'{name}' is the name of a parameter; choose another")
    return name, int(label)
