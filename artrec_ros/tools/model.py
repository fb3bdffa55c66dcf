"""`artrec model`: an object file from pictures, a drawing or a URDF; a sheet to check it by; what will be ambiguous."""

from __future__ import annotations

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from ..core.base.config import GREATEST_LABEL
from ..core.base.errors import ConfigError
from ..core.design.ambiguity import Ambiguities, find_ambiguities
from ..core.geometry.camera import Camera
from ..core.model.objects import ObjectModel
from ..core.model.target import Target
from ..io.base.bars import bar
from ..io.images.cameras import load_camera
from ..io.images.decoding import IMAGE_SUFFIXES
from ..io.images.writing import save_drawing
from ..io.learned.annotations import load_coco
from ..io.objects.marker_images import image_marker
from ..io.objects.marker_shapes import object_of, safe_name
from ..io.objects.object_reader import cut_back, load_object
from ..io.objects.object_writer import Labels, save_object
from ..io.objects.svg import svg_markers
from ..io.objects.urdf_model import object_from_urdf
from ..simulation.sheet import MarkerCell, model_sheet
from .inspecting.model_report import advice, focal_px, shape_rows, summary, table
from .options.camera_options import add_camera, camera_of
from .options.outputs import OF_OBJECT, OF_PAGES, check_drawing, check_output
from .options.paths import path
from .options.picture_sizes import picture_sizes
from .training.marked_lengths import lines, measured_by
from .training.varying_marks import varying

_YAML, _URDF, _SVG = (".yaml", ".yml"), (".urdf", ".xml"), (".svg",)
_COMPARED = partial(bar, desc="comparing markers", unit="pair", delay=1, leave=False)
_SHOWN_LABEL = 2  # the colour of markers on the sheet whose components name no class


def add_parser(subparsers: Any) -> None:
    p = subparsers.add_parser(
        "model",
        help="make an object file from pictures, a drawing or a URDF, and check it",
        description="Makes an object file, or reads one; says from which distance its markers can be told and what "
        "will be ambiguous; draws a sheet to check it by. SOURCE is an object file (.yaml), a drawing (.svg: each "
        "filled shape is a marker, each named group a component), pictures (photos or label images of one marker each, "
        "taken straight from in front, or straightened by a rectangle of known size around the marker, such as a sheet "
        "of paper), or a URDF (.urdf) with --markers.",
    )
    p.add_argument("sources", nargs="+", type=path, metavar="SOURCE", help="object file, drawing, pictures or URDF")
    p.add_argument("-o", "--output", type=path, metavar="OBJECT.yaml", help="object file to write")
    p.add_argument("--overwrite", action="store_true", help="replace OBJECT.yaml if it is there already")
    p.add_argument("--name", help="name of the object (default: the file's, the robot's)")
    _add_pictures(p)
    p.add_argument(
        "--markers", type=path, metavar="OBJECT.yaml",
        help="URDF: an object file whose components are named after links, each marker with its pose on the link",
    )  # fmt: skip
    p.add_argument("--body-label", type=int, metavar="N", help="URDF: class of the bodies' pixels, where they have one")
    p.add_argument(
        "--marks", type=path, nargs="+", action="extend", default=[], metavar="COCO.json",
        help="object file: measure its lengths anew by images in which the ends of its markers' axes are marked (as "
        "for artrec train), straight from above where it is flat, else with --camera-info; -o writes it",
    )  # fmt: skip
    _add_drawings(p)
    p.set_defaults(run=run)


def _add_pictures(p: argparse.ArgumentParser) -> None:
    """How large the markers are that pictures show, and where in them."""
    p.add_argument(
        "--width", type=float, nargs="+", metavar="M",
        help="pictures: width of each marker's bounding box, metres; drawing: width of the whole drawing",
    )  # fmt: skip
    p.add_argument(
        "--height", type=float, nargs="+", metavar="M",
        help="pictures: height of each marker's bounding box: tells a slant, with --width",
    )  # fmt: skip
    p.add_argument(
        "--corners", type=float, nargs=8, action="append", metavar="PX",
        help="pictures: x y of upper left, upper right, lower right and lower left of a rectangle around the marker; "
        "once for each picture",
    )  # fmt: skip
    p.add_argument(
        "--rectangle", type=float, nargs=2, metavar=("W", "H"), help="width and height of that rectangle, metres"
    )
    p.add_argument("--marker-label", type=int, metavar="N", help="label images: class of the marker")


def _add_drawings(p: argparse.ArgumentParser) -> None:
    """What is drawn of the object, and for which camera."""
    p.add_argument("--sheet", type=path, metavar="FILE.png", help="draw the markers, and the object from all sides")
    p.add_argument(
        "--print", type=path, metavar="PAGE.pdf", dest="printed",
        help="the markers at true scale, with crop marks and a ruler to check the printer by",
    )  # fmt: skip
    p.add_argument("--paper", choices=("A4", "A3", "letter"), default="A4", help="size of these pages (default: A4)")
    p.add_argument("--label", type=int, default=_SHOWN_LABEL, metavar="N", help="class of the object drawn, for colour")
    p.add_argument("--distance", type=float, metavar="M", help="warn of markers that cannot be told so far off")
    add_camera(p, (640, 480))


def run(args: argparse.Namespace) -> int:
    """Makes or reads the object, prints what is known of it, writes what was asked for."""
    camera = camera_of(args)
    _check(args)
    model, notes = _model_of(args)
    found = find_ambiguities(model, shown=_COMPARED)
    print(summary(model))
    metric = not args.marks or args.camera_info is not None or args.distance is not None
    for line in _reach(found, camera) if metric else ():
        print(line)
    for line in [*notes, *advice(found, camera if metric else None, args.distance)]:
        print(line)
    if args.output:
        save_object(args.output, model, _comments([*args.sources, *args.marks]), _labels_as_given(args, model))
        print(f"Wrote {args.output}; docs/object_file.md has every key.")
    if args.sheet:
        names = Labels.as_in(args.sources[0]).names() if _kind(args.sources[0]) == "object" else {}
        _write_sheet(args.sheet, sheet_of(found, camera, args.label, names))
        print(f"Drew {args.sheet}")
    if args.printed:
        pages = print_pages(args.printed, model, args.label, args.paper)
        print(f"Wrote {args.printed}: {pages} of {args.paper}; print at 100 % and measure the ruler.")
    return 0


def _reach(found: Ambiguities, camera: Camera) -> Iterator[str]:
    """From how far markers are told."""
    yield (
        f"With a camera of {camera.size[0]} x {camera.size[1]} pixels and a focal length of {focal_px(camera):.0f} px, "
        "markers seen straight on; turned by 60 degrees, half as far; sizes of the narrowest rectangle around:"
    )
    yield from table(found, camera)


def print_pages(path: Path, model: ObjectModel, label: int, paper: str = "A4") -> int:
    """Writes the markers at true scale and returns the number of pages. :raises ConfigError: matplotlib is missing."""
    try:
        from .printing import print_pages as write
    except ImportError as error:
        raise ConfigError(f"--print: {error}; pip install artrec_ros[report]") from None
    return write(path, model, label, paper)


def _check(args: argparse.Namespace) -> None:
    for flag, value in (
        ("--label", args.label),
        ("--marker-label", args.marker_label),
        ("--body-label", args.body_label),
    ):
        if value is not None and not 0 <= value <= GREATEST_LABEL:
            raise ConfigError(f"{flag}: {value} is not within 0 .. {GREATEST_LABEL}")
    if args.distance is not None and not args.distance > 0:
        raise ConfigError(f"--distance: {args.distance} must be greater than 0 m")
    for flag, lengths in (("--width", args.width), ("--height", args.height), ("--rectangle", args.rectangle)):
        if any(not 0 < length < 100 for length in lengths or ()):
            raise ConfigError(f"{flag}: {lengths} must be metres, greater than 0 and below 100")
    if args.printed and args.printed.suffix.lower() != ".pdf":
        raise ConfigError(f"--print: '{args.printed}' must end in .pdf")
    inputs = [*args.sources, *args.marks, *filter(None, [args.markers, args.camera_info])]
    if args.output:
        check_output(args.output, inputs, OF_OBJECT, overwrite=args.overwrite)
    if args.sheet:
        check_drawing("--sheet", args.sheet, inputs)
    if args.printed:
        check_output(args.printed, inputs, OF_PAGES)


def _model_of(args: argparse.Namespace) -> tuple[ObjectModel, Sequence[str]]:
    """The object, and lines on how it was made."""
    sources: list[Path] = args.sources
    kinds = {_kind(s) for s in sources}
    if len(kinds) > 1 or (len(sources) > 1 and kinds != {"picture"}):
        raise ConfigError(f"SOURCE: {len(sources)} given; several pictures, or one object file, drawing or URDF")
    kind, first = kinds.pop(), sources[0]
    if kind != "picture" and (args.height or args.corners or args.rectangle):
        raise ConfigError(f"--height, --corners, --rectangle: are for pictures, and {first} is none")
    if (kind == "urdf") != (args.markers is not None):
        raise ConfigError(
            "a URDF and --markers go together: the URDF tells how links move, --markers what sits on them"
        )
    if args.marks and kind != "object":
        raise ConfigError(f"--marks: measures what an object file has, and {first} is none")
    if kind == "object":
        model = _with_any_numbers(first)
        return _measured(model, args) if args.marks else (model, _cut_back(first))
    if kind == "urdf":
        made = object_from_urdf(first, _with_any_numbers(args.markers), args.name, args.body_label)
        return made.model, [f"note: {n}" for n in made.notes]
    name = safe_name(args.name or (args.output or first).stem)
    if kind == "drawing":
        if args.width and len(args.width) != 1:
            raise ConfigError(f"--width: {len(args.width)} given; a drawing has one")
        notes: list[str] = []
        markers = svg_markers(first, args.width[0] if args.width else None, lambda line: notes.append(f"note: {line}"))
        return object_of(name, markers), notes
    sizes = picture_sizes(len(sources), args.width, args.height, args.corners, args.rectangle)
    pictured = [
        image_marker(source, size.width_m, args.marker_label, size.height_m, size.rectangle)
        for source, size in zip(sources, sizes, strict=True)
    ]
    told = [size.told(s.name, marker) for s, size, marker in zip(sources, sizes, pictured, strict=True)]
    return object_of(name, pictured), told


def _with_any_numbers(path: Path) -> ObjectModel:
    """An object that is read by itself: markers of classes whose names differ are not taken for each other."""
    load_object(path)  # says what is wrong with the file
    return load_object(path, Labels.as_in(path).numbered())


def _labels_as_given(args: argparse.Namespace, model: ObjectModel) -> Labels | None:
    """As a file has them; of a URDF's object the markers' file those of markers. None: they are numbers."""
    kind = _kind(args.sources[0])
    if kind == "urdf":
        return replace(Labels.as_in(args.markers), body={c.name: c.body_label for c in model.components})
    return Labels.as_in(args.sources[0]) if kind == "object" else None


def _cut_back(path: Path) -> list[str]:
    markers = cut_back(path)
    told = f"bodies reach a little beyond {', '.join(markers)}, and are taken to end beneath"
    return [f"note: {told} {'it' if len(markers) == 1 else 'them'}"] if markers else []


def _measured(model: ObjectModel, args: argparse.Namespace) -> tuple[ObjectModel, Sequence[str]]:
    """The object with the lengths that marked images tell, where these are better. Without calibration a length is in
    whatever the object file has: metres, or pixels of one picture."""
    camera = load_camera(args.camera_info) if args.camera_info else None
    marks = load_coco(args.marks)
    measured = measured_by(marks, model, camera)
    told = [*lines(measured, camera is not None), *(varying(marks, model) if camera is None else ())]
    return measured.model if measured.helps else model, told


def _kind(source: Path) -> str:
    suffix = source.suffix.lower()
    kinds = {"object": _YAML, "urdf": _URDF, "drawing": _SVG, "picture": IMAGE_SUFFIXES}
    for kind, suffixes in kinds.items():
        if suffix in suffixes:
            return kind
    known = ", ".join(s for suffixes in kinds.values() for s in suffixes)
    raise ConfigError(f"{source}: '{suffix}' is no kind of file that an object can be made from (known: {known})")


def _comments(sources: Sequence[Path]) -> tuple[str, ...]:
    names = ", ".join(s.name for s in sources)
    return (f"Made by `artrec model` from {names}. Lengths in metres, angles in radians.",)


def _write_sheet(path: Path, sheet: NDArray[np.uint8]) -> None:
    small = [cv2.IMWRITE_PNG_COMPRESSION, 9] if path.suffix.lower() == ".png" else []
    save_drawing(path, sheet, small)


def sheet_of(
    found: Ambiguities, camera: Camera, label: int, class_names: Mapping[int, str] | None = None
) -> NDArray[np.uint8]:
    """(H, W, 3) BGR the markers with what is known of them, and the object from all sides.

    :param label: the object's own class. :param class_names: of those classes that are called otherwise than by number.
    """
    cells = []
    for row in shape_rows(found, camera):
        component = found.model.component(row.keys[0][0])
        shown = component.labels(label)[0]
        notes = f"found to {row.found_m:.2f} m, told to {row.told_m:.2f} m"
        class_name = (class_names or {}).get(shown, "")
        cells.append(MarkerCell(component.marker(row.keys[0][1]), shown, row.names, row.size_m, notes, class_name))
    return model_sheet(Target(found.model.name, found.model, label), cells)
