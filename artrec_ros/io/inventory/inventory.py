"""What a file or folder is, and what it holds: bags, images, objects, constraints, parameters, annotations, truth."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Sequence
from pathlib import Path

import numpy as np

from ...core.base.errors import ArtrecError, ConfigError, ImageError, SourceError
from ...core.geometry.camera import Camera
from ..bags.metadata import BAG_SUFFIXES, is_storage, storage_suffix
from ..bags.reader import Bag, Topic
from ..bags.topics import IMAGE_TYPES, camera_of, choose_info_topic, decode_message
from ..base.bars import bar
from ..base.json_files import read_json
from ..base.kinds import COCO, CONSTRAINTS, OBJECT, kind_of
from ..base.yaml_files import like_it, load_value, load_yaml
from ..images.cameras import load_camera
from ..images.decoding import IMAGE_SUFFIXES, read_image, size_of_image
from ..images.folders import images_of, is_lossy, passed_over
from ..images.video import VIDEO_SUFFIXES
from ..learned.annotations import load_coco
from ..learned.constraints import FORMAT as CONSTRAINT_FORMAT
from ..objects.object_reader import FORMAT as OBJECT_FORMAT
from ..objects.object_reader import load_object
from ..parameters.parameter_file import load_parameters
from ..parameters.sections import read_flat
from ..results.journal import JOURNAL_FILE
from ..results.results import DETECTIONS_FILE, VIDEO_FILE, read_results
from ..sources.frames import SourceOptions
from ..sources.kinds import check_not_live
from ..sources.video_source import UNDECODABLE, VideoSource
from ..truth.records import load_truth
from .contents import (
    MISSING,
    BagContent,
    ConstraintContent,
    Content,
    Item,
    ResultContent,
    Sample,
    Supplement,
    TruthContent,
)
from .own_reports import read_drawing, read_report, read_urdf

_YAML = (".yaml", ".yml")
_LISTED = 3  # files by name on a line
_SAMPLES = 5  # images of a bag or folder that are looked at, evenly spread


def take_stock(paths: Sequence[Path], images_folder: Path | None = None) -> list[Item]:
    """What each path holds; of a folder that is neither bag nor images, what lies in it. Nothing is raised.

    Parameter files without objects are read after each of those that have some, in the order given.

    :param images_folder: where annotated images lie; without it, beside each file.
    """
    more = [p for p in paths if _is_supplement(p)]
    looked = bar(paths, "looking into", unit="path", delay=1, leave=False)
    return [item for path in looked for item in _look(path, more, images_folder)]


def _is_supplement(path: Path) -> bool:
    try:
        return path.suffix.lower() in _YAML and path.is_file() and "objects" not in read_flat(path)
    except ArtrecError:
        return False  # another kind of file, or one whose problem is told when it is read


def _look(path: Path, more: Sequence[Path], images_folder: Path | None) -> Iterator[Item]:
    if path.is_dir() and not _is_bag(path) and not images_of(path):
        inside = sorted(path.iterdir())
        parts = [p for p in inside if _known_kind(p)] or [p for p in inside if p.is_dir() and images_of(p)]
        if not parts:
            yield Item(path, "folder", error="neither a bag, nor images, nor files that artrec reads")
        for part in parts:
            yield from _look(part, more, images_folder)
        return
    kind = "unknown" if path.exists() else MISSING
    try:
        kind, read = _reader(path, more, images_folder)
        yield Item(path, kind, read(path))
    except ArtrecError as error:
        yield Item(path, kind, error=str(error).removeprefix(f"{path}: "))


def _known_kind(path: Path) -> bool:
    if path.is_dir():
        return _is_bag(path)
    return path.suffix.lower() in _KNOWN and path.name not in _OTHERS


_KNOWN = (*_YAML, ".json", ".jsonl", ".svg", ".urdf", *BAG_SUFFIXES, *VIDEO_SUFFIXES)
_OTHERS = ("metadata.yaml", JOURNAL_FILE, VIDEO_FILE)  # what replays write is no input


def _reader(path: Path, more: Sequence[Path], images_folder: Path | None) -> tuple[str, Callable[[Path], Content]]:
    """The kind of a path, and what reads it."""
    check_not_live(path)
    if not path.exists():
        raise SourceError(f"{path}: there is no such file or folder{like_it(path)}")
    if _is_bag(path):
        return "bag", _read_bag
    if path.is_dir():
        return "images", _read_images
    suffix = path.suffix.lower()
    if suffix in IMAGE_SUFFIXES:
        return "images", _read_images
    if suffix == ".json":
        value = read_json(path)
        if kind_of(value.raw) == COCO or "annotations" in value.entries():
            return "annotations", lambda p: load_coco([p], images_folder)
        return "report", lambda _: read_report(value)
    if suffix == ".svg":
        return "drawing", read_drawing
    if suffix == ".urdf":
        return "URDF", read_urdf
    if suffix == ".jsonl":
        return ("results", _read_results) if path.name == DETECTIONS_FILE else ("truth", _read_truth)
    if suffix in _YAML:
        return _yaml_reader(path, more)
    if suffix in VIDEO_SUFFIXES:
        return "images", _read_video
    kinds = ", ".join((*_KNOWN, *IMAGE_SUFFIXES))
    raise SourceError(f"{path}: '{suffix or path.name}' is no kind of file that artrec inspect reads: {kinds}")


def _yaml_reader(path: Path, more: Sequence[Path]) -> tuple[str, Callable[[Path], Content]]:
    keys = load_value(path).entries()
    format = keys["format"].raw if "format" in keys else None
    kinds: dict[str, tuple[str, Callable[[Path], Content]]] = {
        OBJECT_FORMAT.partition("/")[0]: ("object", lambda p: load_object(p)),
        CONSTRAINT_FORMAT.partition("/")[0]: ("constraints", _read_constraints),
    }
    if isinstance(format, str) and format.partition("/")[0] in kinds:
        return kinds[format.partition("/")[0]]
    if "camera_matrix" in keys or "image_width" in keys:
        return "calibration", lambda p: load_camera(p)
    if "objects" in keys or any("ros__parameters" in str(v.raw) for v in keys.values()):
        if path in more:
            return "parameters", lambda p: Supplement(tuple(read_flat(p)))
        return "parameters", lambda p: load_parameters(p, *more)
    kind = kind_of({key: value.raw for key, value in keys.items()})
    if kind in (OBJECT, CONSTRAINTS):  # whose format is missing or unknown, as reading it says
        return kinds[f"artrec_{'object' if kind == OBJECT else 'constraints'}"]
    if kind is not None:
        raise ConfigError(f"{path}: is {kind}, which is not looked into")
    raise ConfigError(f"{path}: neither an object, constraints, parameters (ros__parameters) nor a calibration")


def _is_bag(path: Path) -> bool:
    """Of ROS 1 each file is one: a folder of them holds several."""
    if not path.is_dir():
        return is_storage(path)
    return any(p.name == "metadata.yaml" or (is_storage(p) and storage_suffix(p) != ".bag") for p in path.iterdir())


def _read_images(path: Path) -> Sample:
    files = images_of(path) if path.is_dir() else [path]
    chosen = [files[i] for i in np.unique(np.linspace(0, len(files) - 1, _SAMPLES).astype(int))]
    images, unreadable = [], dict[str, str]()
    for file in chosen:
        try:
            images.append(read_image(file))
        except ImageError as error:
            unreadable[file.name] = str(error)
    problems = [*(f"{name}: {error}" for name, error in unreadable.items()), *_headers(files, unreadable)]
    others = passed_over(path) if path.is_dir() else ""
    lossy = any(map(is_lossy, files))
    return Sample(str(path), len(files), tuple(images), tuple(problems), passed_over=others, lossy=lossy)


def _read_video(path: Path) -> Sample:
    video = VideoSource(path, SourceOptions())
    try:
        seen = video.survey(_SAMPLES)
        if not seen.images:
            raise SourceError(f"{path}: no frame of it can be decoded")
        lost = f"{', '.join(seen.lost[:_LISTED])}{', ...' if len(seen.lost) > _LISTED else ''}: {UNDECODABLE}"
        problems = [*([lost] if seen.lost else []), *(line.removeprefix(f"{path}: ") for line in video.problems)]
        return Sample(str(path), seen.count, seen.images, tuple(problems))
    finally:
        video.close()


def _headers(files: Sequence[Path], told: Collection[str]) -> Iterator[str]:
    """What the files' beginnings tell of images that cannot be read or are not as large as the others.

    :param told: names of which that is known.
    """
    sizes: dict[tuple[int, int], list[str]] = {}
    for file in bar(files, "reading", unit="file", delay=1, leave=False):
        try:
            sizes.setdefault(size_of_image(file), []).append(file.name)
        except ImageError as error:
            if file.name not in told:
                yield f"{file.name}: {error}"
    usual = max(sizes, key=lambda size: len(sizes[size]), default=None)
    for size, names in sizes.items():
        if usual is not None and size != usual:
            others = f"{len(names)} of {len(files)} images have {size[0]}x{size[1]} pixels, not {usual[0]}x{usual[1]}"
            yield f"{others}: {', '.join(names[:_LISTED])}{', ...' if len(names) > _LISTED else ''}"


def _read_bag(path: Path) -> BagContent:
    with Bag(path) as bag:
        topics = tuple(sorted(bag.topics.values()))
        samples = tuple(_sample(bag, t) for t in topics if t.msgtype in IMAGE_TYPES)
        for _ in bar(bag.messages(bag.topics), "reading", unit="message", delay=1, leave=False):
            pass  # the bag counts what it gives, and holds that against what it says of itself
        duration_s = max(0, bag.end_ns - bag.start_ns) / 1e9
        return BagContent(topics, duration_s, samples, tuple(bag.problems))


def image_stamps(path: Path, topic: str) -> frozenset[int]:
    """Header stamps (ns) of an image topic; reads all its messages."""
    stamps = set()
    with Bag(path) as bag:
        for message in bar(bag.messages([topic]), "reading stamps", unit="message", delay=1, leave=False):
            try:
                bag.parse(message)
            except ImageError:
                continue  # told where the images are looked at
            stamps.add(bag.head(message).stamp_ns)
    return frozenset(stamps)


def _sample(bag: Bag, topic: Topic) -> Sample:
    images, problems = [], []
    for start_ns in np.linspace(bag.start_ns, bag.end_ns, _SAMPLES, endpoint=False).astype(np.int64).tolist():
        message = next(bag.messages([topic.name], start_ns), None)
        if message is None:
            continue
        try:
            images.append(decode_message(bag.parse(message)))
        except ImageError as error:
            problems.append(str(error))
    camera, camera_problem = _camera(bag, topic.name)
    return Sample(topic.name, topic.count, tuple(images), tuple(dict.fromkeys(problems)), camera, camera_problem)


def _camera(bag: Bag, image_topic: str) -> tuple[Camera | None, str | None]:
    name, is_there = choose_info_topic(bag, None, image_topic)
    message = next(bag.messages([name]), None) if is_there else None
    if message is None:
        return None, f"no calibration: {'nothing on' if is_there else 'no topic'} '{name}'"
    try:
        return camera_of(bag.parse(message)), None
    except (ImageError, ConfigError) as error:
        return None, f"{name}: {error}"


def _read_constraints(path: Path) -> ConstraintContent:
    top = load_yaml(path, CONSTRAINT_FORMAT).entries()
    for key in ("object", "coverage", "pairs"):
        if key not in top:
            raise ConfigError(f"{path}: {key}: this key is missing")
    classes = top["classes"].items() if "classes" in top else []
    names = tuple(str(c.entries()["name"].raw) for c in classes if "name" in c.entries())
    return ConstraintContent(top["object"].text(), top["coverage"].number(0, 1), len(top["pairs"].items()), names)


def _read_truth(path: Path) -> TruthContent:
    truth = load_truth(path)
    labels = Counter(o.label for objects in truth.values() for o in objects if o.label is not None)
    return TruthContent(len(truth), frozenset(truth), dict(sorted(labels.items())))


def _read_results(path: Path) -> ResultContent:
    stamps, objects = [], Counter[str]()
    for record in read_results(path):
        stamps.append(record.stamp_ns)
        objects.update(d.object for d in record.detections)
    return ResultContent(len(stamps), frozenset(stamps), dict(sorted(objects.items())))
