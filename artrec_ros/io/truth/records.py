"""Truth: what is known of the objects in each frame, from truth.jsonl, poses in a bag, or COCO keypoints.

Each kind of file tells something else. What is missing is not guessed: `TrueObject.told` says which components
the file speaks of, and only those are judged.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import TypedDict

import numpy as np

from ...core.base.errors import SourceError
from ...core.geometry.camera import Camera
from ...core.geometry.transforms import Array, Pose, readonly
from ..base.json_lines import at_line, lines_of, parsed_line
from ..base.kinds import TRUTH, mistaken
from ..base.typed import Amount, Stamp, UnfitError, typed

_Point = tuple[float, float]
_Triple = tuple[float, float, float]
_Rotation = tuple[_Triple, _Triple, _Triple]


class _Component(TypedDict):
    full_px: Amount
    visible_px: Amount
    centre: _Point | None


class _WholeObject(TypedDict):
    components: dict[str, _Component]


class _Object(_WholeObject, total=False):
    object: str | None
    identity: str | None
    team: int
    position: _Triple
    rotation: _Rotation
    joints: dict[str, float] | None
    centre_px: _Point | None


class _Frame(TypedDict):
    """A line of truth.jsonl."""

    stamp_ns: Stamp
    objects: tuple[_Object, ...]


_ROUNDED = 0.01  # by so much rows of a rotation may be off, as where it was written with few digits


@dataclass(frozen=True)
class TrueComponent:
    """A marker that faces the camera.

    :param full_px: its area if nothing hid it, pixels. :param visible_px: the visible part of that.
    :param centre: (2,) centre of the visible part, pixels; None: nothing of it is visible.
    """

    full_px: float
    visible_px: float
    centre: Array | None


class Told(Enum):
    """Of which components a truth speaks."""

    ALL = "all"  # what is not listed cannot be seen
    LABELLED = "labelled"  # what is not listed may be seen or not
    REQUIRED = "required"  # of the required one alone


@dataclass(frozen=True)
class TrueObject:
    """An object of the scene.

    :param label: its class number, None: the truth goes by names. :param name: its name, None: it goes by labels.
    :param pose: its frame in the camera's optical frame, where known.
    :param components: by the truth's names: 'COMPONENT', 'COMPONENT_SIDE' or 'COMPONENT@SIDE'.
    :param centre_px: (2,) the object's origin in the image, where known.
    :param joints: joint's name -> its angle in radians (metres for prismatic joints).
    :param identity: which of several like objects it is, where that is said beside its name.
    :param axes: 'COMPONENT/MARKER' -> (2, 2) tail and head of the marker's axis, pixels, of annotated images.
    :param undirected: those of them whose markers look the same in any turn: an axis tells only where such a one is.
    """

    label: int | None
    pose: Pose | None
    components: Mapping[str, TrueComponent]
    centre_px: Array | None
    name: str | None = None
    joints: Mapping[str, float] = field(default_factory=dict)
    axes: Mapping[str, Array] = field(default_factory=dict)
    told: Told = Told.ALL
    identity: str | None = None
    undirected: frozenset[str] = frozenset()


FrameKey = int | str
"""What tells a frame: its stamp in nanoseconds, or the name of its image file."""


@dataclass(frozen=True)
class Truth:
    """The objects of each frame.

    :param frames: by stamp, or by image file name, all in the same way. :param source: where they come from.
    :param camera: the calibration beside them, where there is one. :param frame_id: in which the poses are; '': unsaid.
    :param crowds: outlines (n, 2) in pixels, by frame, of where something is of which nothing is told.
    :param left_out: frames that are no truth, as the recogniser itself annotated them.
    :param problems: what is wrong with the source, as where its end is missing.
    """

    frames: Mapping[FrameKey, tuple[TrueObject, ...]]
    source: str
    camera: Camera | None = None
    frame_id: str = ""
    left_out: int = 0
    crowds: Mapping[FrameKey, tuple[Array, ...]] = field(default_factory=dict)
    problems: tuple[str, ...] = ()

    @property
    def by_name(self) -> bool:
        """Whether frames go by file names."""
        return any(isinstance(key, str) for key in self.frames)

    def objects(self) -> Iterator[TrueObject]:
        for objects in self.frames.values():
            yield from objects


def load_truth(path: Path) -> dict[int, tuple[TrueObject, ...]]:
    """The objects of each frame of a truth.jsonl, by the frame's stamp. :raises SourceError: naming file, line, key."""
    truth: dict[int, tuple[TrueObject, ...]] = {}
    for number, line in enumerate(lines_of(path), 1):
        if not line.strip():
            continue  # as editors leave one at the end
        with at_line(path, number):
            content = parsed_line(line)
            if problem := mistaken(content, TRUTH):
                raise SourceError(f"{path}: {problem}")
            frame = typed(content, _Frame)
            stamp_ns = frame["stamp_ns"]
            if stamp_ns in truth:
                raise UnfitError(f"the stamp {stamp_ns} is there twice", "stamp_ns")
            truth[stamp_ns] = tuple(_object(o, f"objects[{i}]") for i, o in enumerate(frame["objects"]))
    if not truth:
        raise SourceError(f"{path}: holds no frame")
    return truth


def keys_by_name(names: Sequence[Path], source: object) -> list[FrameKey]:
    """Keys of image files whose names are no stamps: the names, which must differ."""
    keys: list[FrameKey] = [p.name for p in names]
    if twice := sorted(str(k) for k in set(keys) if keys.count(k) > 1):
        raise SourceError(f"{source}: two images are called '{twice[0]}': frames cannot be told by name")
    return keys


def _object(o: _Object, place: str) -> TrueObject:
    """:param place: its key in the line."""
    components = {
        name: TrueComponent(c["full_px"], c["visible_px"], _point(c["centre"])) for name, c in o["components"].items()
    }
    name = o.get("object")
    needed = [*(["team"] if name is None else []), *(["rotation"] if "position" in o else [])]
    if missing := [key for key in needed if key not in o]:
        raise UnfitError("this key is missing", f"{place}.{missing[0]}")
    pose = Pose(_rotation(o["rotation"], f"{place}.rotation"), np.array(o["position"])) if "position" in o else None
    if pose is not None and pose.position[2] <= 0 and _is_seen(o):
        what = f"z is {pose.position[2]:g} m, behind the camera, and yet some of it is told to be in the image"
        raise UnfitError(f"{what}; the camera looks along +z", f"{place}.position")
    joints = o.get("joints") or {}
    centre, identity = _point(o.get("centre_px")), o.get("identity")
    return TrueObject(o.get("team"), pose, components, centre, name, joints, identity=identity)


def _is_seen(o: _Object) -> bool:
    """Whether it is told to be in the image: of one that is not, mocap knows a place behind the camera as well."""
    return o.get("centre_px") is not None or any(c["visible_px"] > 0 for c in o["components"].values())


def _rotation(rows: _Rotation, key: str) -> Array:
    R = np.array(rows)
    if np.abs(R @ R.T - np.eye(3)).max() > _ROUNDED or np.linalg.det(R) < 0:
        raise UnfitError("is none: three rows, perpendicular and of length 1, right-handed, are wanted", key)
    return R


def _point(value: _Point | None) -> Array | None:
    return None if value is None else readonly(value)
