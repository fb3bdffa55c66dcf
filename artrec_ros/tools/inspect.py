"""`artrec inspect`: what bags, objects, constraints, parameters, annotations and truth hold; whether they fit."""

from __future__ import annotations

import argparse
from collections import Counter
from collections.abc import Iterator
from typing import Any

from ..core.base.errors import ConfigError
from ..core.constraints.constraint_set import ConstraintSet
from ..core.geometry.camera import Camera
from ..core.model.objects import ObjectModel
from ..core.ways import FACING, PAPER, PLANE, way_of
from ..io.images.video import VIDEO_SUFFIXES
from ..io.inventory.contents import (
    MISSING,
    BagContent,
    ConstraintContent,
    Item,
    Report,
    ResultContent,
    Sample,
    Supplement,
    TruthContent,
)
from ..io.inventory.inventory import take_stock
from ..io.learned.annotations import Annotations
from ..io.parameters.parameter_file import Setup
from ..io.parameters.specs import EXPERT
from ..io.parameters.unread import unread
from .inspecting.inspection import calibrated_images, problems, warnings
from .inspecting.model_report import counted, summary
from .inspecting.next_step import next_steps
from .inspecting.scene_report import draw_scene, scene_lines
from .inspecting.silent_topics import silent_topics
from .options.outputs import check_drawing
from .options.paths import path

_OTHER_TOPICS = 12  # topics of a bag that are listed beside images and calibrations


def add_parser(subparsers: Any) -> None:
    p = subparsers.add_parser(
        "inspect",
        help="print what files hold, and whether they fit together",
        description="Prints what a bag, folder of images, object, constraint or parameter file, calibration, COCO "
        "file, truth or result holds; of parameters, which of the node's topics will stay empty, and why. Of several "
        "it says whether they fit together: labels, names, topics, calibration, constraints, stamps. One line for "
        "every problem; exit code 1 where there is one.",
    )
    p.add_argument("paths", nargs="*", type=path, metavar="PATH", help="files and folders; of a folder, what is in it")
    p.add_argument(
        "--params-file", type=path, action="append", default=[], metavar="NODE.yaml",
        help="a parameter file, as other commands take it; the same as to name it as PATH",
    )  # fmt: skip
    p.add_argument("--camera-info", type=path, metavar="FILE.yaml", help="a calibration, likewise")
    p.add_argument("--images", type=path, metavar="DIR", help="where annotated images lie (default: beside each file)")
    p.add_argument(
        "--scene",
        type=path,
        metavar="PICTURE",
        help="draw the parameters' scene.region and scene.plane over an image: PICTURE.png",
    )
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Exit code 1 where something is wrong or does not fit."""
    cameras = [] if args.camera_info is None else [args.camera_info]
    paths = list(dict.fromkeys([*args.params_file, *args.paths, *cameras]))
    if not paths:
        raise ConfigError("name what to look into: PATH, or --params-file")
    if args.scene is not None:
        check_drawing("--scene", args.scene, paths)
    items = take_stock(paths, args.images)
    for item in items:
        for n, line in enumerate(describe(item)):
            print(f"{'  ' if n else ''}{line}")
        if isinstance(item.content, Setup):
            there = calibrated_images(items)
            images = {True, False} if there is None else {there}
            for line in (*unread(item.content, images), *silent_topics(item.content, there)):
                print(f"  {line}")
    for line in scene_lines(items):
        print(line)
    if args.scene is not None:
        print(draw_scene(items, args.scene))
    for line in next_steps(items, args.images):
        print(f"next: {line}")
    for line in dict.fromkeys(warnings(items)):
        print(f"warning: {line}")
    found = list(dict.fromkeys(problems(items)))
    for line in found:
        print(f"problem: {line}")
    known = sum(i.content is not None for i in items)
    if not found:
        print("no problem found" if known == 1 else f"no problem found: all {known} fit together")
    return int(bool(found))


def describe(item: Item) -> Iterator[str]:
    """A headline, then details."""
    content = item.content
    head = f"{item.path}: {item.kind}"
    if isinstance(content, BagContent):
        yield from _bag(head, content)
    elif isinstance(content, Sample):
        each = "frame" if item.path.suffix.lower() in VIDEO_SUFFIXES else "file"
        yield f"{head}, {counted(content.count, each)}, {_pixels(content)}"
        if content.passed_over:
            yield f"passed over: {content.passed_over}"
    elif isinstance(content, ObjectModel):
        yield from _object(f"{item.path}: object ", content)
    elif isinstance(content, ConstraintContent):
        classes = f", classes {', '.join(content.classes)}" if content.classes else ""
        yield f"{head} of '{content.object}', {counted(content.pairs, 'pair')}, coverage {content.coverage:g}{classes}"
    elif isinstance(content, Setup):
        yield from _setup(head, content)
    elif isinstance(content, Annotations):
        yield from _annotations(head, content)
    elif isinstance(content, TruthContent):
        by_label = f", objects by label: {_counts(content.labels)}" if content.labels else ""
        yield f"{head}, {counted(content.frames, 'frame')}{by_label}"
    elif isinstance(content, ResultContent):
        yield f"{head}, {counted(content.frames, 'frame')}, objects found: {_counts(content.objects)}"
    elif isinstance(content, Supplement):
        shown = ", ".join(content.names[:6]) + (" ..." if len(content.names) > 6 else "")
        yield f"{head} without objects, to be read after others: {shown}"
    elif isinstance(content, Camera):
        yield f"{head}, {_camera(content)}"
    elif isinstance(content, Report):
        yield f"{item.path}: {content.kind}"
        yield from content.lines
    elif item.kind != MISSING:  # of which its problem says all
        yield f"{head}, with a problem that is told below"


def _counts(counts: Any) -> str:
    return ", ".join(f"{name}: {count}" for name, count in counts.items()) or "none"


def _camera(camera: Camera) -> str:
    lens = f"distortion of {camera.distortion.size} coefficients" if camera.distortion.any() else "no distortion"
    (fx, _, cx), (_, fy, cy) = camera.matrix[:2].tolist()
    return f"{camera.size[0]}x{camera.size[1]}, focal lengths {fx:.1f}, {fy:.1f} px, centre {cx:.1f}, {cy:.1f}, {lens}"


def _pixels(s: Sample) -> str:
    if s.size is None:
        return "none readable"
    parts = [f"{s.size[0]}x{s.size[1]}", counted(s.channels, "channel")]
    if s.channels == 1 and len(s.labels) <= 32:
        parts.append(f"labels {' '.join(map(str, s.labels))}")
    elif s.channels == 1:
        parts.append(f"{len(s.labels)} values: brightness rather than labels")
    if len(s.images) < s.count:
        parts.append(f"in {len(s.images)} images looked at")
    return ", ".join(parts)


def _bag(head: str, bag: BagContent) -> Iterator[str]:
    yield f"{head}, {counted(len(bag.topics), 'topic')}, {bag.duration_s:.2f} s"
    samples = {s.name: s for s in bag.samples}
    first = [t for t in bag.topics if t.name in samples or t.msgtype.endswith("/CameraInfo")]
    others = [t for t in bag.topics if t not in first]
    shown = [*first, *others[:_OTHER_TOPICS]]
    width = max((len(t.name) for t in shown), default=0)
    for topic in shown:
        line = f"{topic.name:{width}}  {topic.msgtype}  {topic.count}"
        s = samples.get(topic.name)
        if s is not None:
            line += f"  {_pixels(s)}; " + (_camera(s.camera) if s.camera else s.camera_problem or "")
        yield line
    if len(shown) < len(bag.topics):
        yield f"and {len(bag.topics) - len(shown)} more topics"


def _object(head: str, model: ObjectModel) -> Iterator[str]:
    yield head + summary(model)
    for c in model.components:
        about = [", ".join(m.name for m in c.markers)]
        about += ["required"] if c.required else []
        about += [f"label {c.label}"] if c.label is not None else []
        about += [f"of one of the classes {', '.join(c.classes)}"] if c.classes else []
        about += [f"body of {len(c.bodies)} box{'es' if len(c.bodies) > 1 else ''}"] if c.bodies else []
        yield f"{c.name}: {'; '.join(about)}"
    if model.identities:
        once = ", each occurs once" if model.unique else ""
        yield f"identities: {', '.join(identity.name for identity in model.identities)}{once}"
    yield _way(model)


def _way(model: ObjectModel) -> str:
    if not model.is_spatial:
        return "not every marker has a pose: found in the image plane, by learned constraints"
    places = "every marker has a pose: found in space, given a calibration"
    return f"{places}; it is flat: found as a whole in the image plane without one" if model.is_flat else places


def _setup(head: str, setup: Setup) -> Iterator[str]:
    yield f"{head} for image.kind '{setup.image.kind}'"
    for t in setup.targets:
        space = "in space" if t.model.is_spatial else "in the image plane"
        if t.model.is_spatial and t.model.is_flat:
            space = "in space, or without a calibration as a whole in the image (no poses, but image_poses)"
            if way_of(t, setup.recognizer, calibrated=True) == FACING:
                space = "as a whole on scene.plane"
        learned = "no constraints"
        if isinstance(t.constraints, ConstraintSet):
            learned = counted(len(t.constraints.pairs), "learned pair")
            if {way_of(t, setup.recognizer, calibrated=c) for c in (False, True)}.isdisjoint((PAPER, PLANE)):
                learned += " (used with recognizer.whole_object: false)"
        yield f"{t.name}: object '{t.model.name}', label {t.label}, {space}, {learned}"
    if setup.image.classes:
        yield "classes: " + ", ".join(f"{name} {c.label}" for name, c in setup.image.classes.items())
    specs = setup.specs
    changed = {
        k: v for k, v in setup.resolved.items()
        if k.startswith(("recognizer.", "scene.", "tracking.", EXPERT)) and k in specs and v != specs[k].default
        and v != list(specs[k].default if isinstance(specs[k].default, tuple) else ())
    }  # fmt: skip
    if changed:
        yield "not at their defaults: " + ", ".join(f"{k} {v}" for k, v in changed.items())


def _annotations(head: str, annotations: Annotations) -> Iterator[str]:
    counts = Counter(o.category for o in annotations.objects)
    images = len({o.image for o in annotations.objects})
    yield f"{head}, {counted(len(annotations.objects), 'annotated object')} in {counted(images, 'image')}"
    for name, keypoints in annotations.categories.items():
        yield f"{name}: {counted(counts[name], 'object')}, {counted(len(keypoints), 'keypoint')}"
    if annotations.bare:
        yield f"regions, of categories without keypoints: {_counts(annotations.bare)}"
