"""Truth: what is known of the objects in each frame, from truth.jsonl, poses in a bag, or COCO keypoints.

Each kind of file tells something else. What is missing is not guessed: `TrueObject.told` says which components
the file speaks of, and only those are judged.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import Any

import numpy as np

from ...core.base.errors import SourceError
from ...core.geometry.camera import Camera
from ...core.geometry.transforms import Array, Pose, readonly
from ..base.json_lines import fault
from ..base.kinds import TRUTH, mistaken
from ..base.yaml_files import size_of_file

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
    :param axes: 'COMPONENT/MARKER' -> (2, 2) tail and head of the marker's axis, pixels, of annotated images.
    """

    label: int | None
    pose: Pose | None
    components: Mapping[str, TrueComponent]
    centre_px: Array | None
    name: str | None = None
    joints: Mapping[str, float] = field(default_factory=dict)
    axes: Mapping[str, Array] = field(default_factory=dict)
    told: Told = Told.ALL


FrameKey = int | str
"""What tells a frame: its stamp in nanoseconds, or the name of its image file."""


@dataclass(frozen=True)
class Truth:
    """The objects of each frame.

    :param frames: by stamp, or by image file name, all in the same way. :param source: where they come from.
    :param camera: the calibration beside them, where there is one. :param frame_id: in which the poses are; '': unsaid.
    :param left_out: frames that are no truth, as the recogniser itself annotated them.
    :param problems: what is wrong with the source, as where its end is missing.
    """

    frames: Mapping[FrameKey, tuple[TrueObject, ...]]
    source: str
    camera: Camera | None = None
    frame_id: str = ""
    left_out: int = 0
    problems: tuple[str, ...] = ()

    @property
    def by_name(self) -> bool:
        """Whether frames go by file names."""
        return any(isinstance(key, str) for key in self.frames)

    def objects(self) -> Iterator[TrueObject]:
        for objects in self.frames.values():
            yield from objects


def load_truth(path: Path) -> dict[int, tuple[TrueObject, ...]]:
    """The objects of each frame of a truth.jsonl, by the frame's stamp. :raises SourceError: naming file and line."""
    truth: dict[int, tuple[TrueObject, ...]] = {}
    size_of_file(path, SourceError)
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise SourceError(f"{path}: cannot be read: {error}") from error
    for number, line in enumerate(lines, 1):
        try:
            record = json.loads(line)
            if problem := mistaken(record, TRUTH):
                raise SourceError(f"{path}: {problem}")
            stamp_ns, objects = int(record["stamp_ns"]), tuple(_object(o) for o in record["objects"])
        except (KeyError, TypeError, ValueError) as error:
            raise SourceError(f"{path}: line {number} is no line of truth: {fault(error)}") from error
        if stamp_ns in truth:
            raise SourceError(f"{path}: line {number}: the stamp {stamp_ns} is there twice")
        truth[stamp_ns] = objects
    if not truth:
        raise SourceError(f"{path}: holds no frame")
    return truth


def keys_by_name(names: Sequence[Path], source: object) -> list[FrameKey]:
    """Keys of image files whose names are no stamps: the names, which must differ."""
    keys: list[FrameKey] = [p.name for p in names]
    if twice := sorted(str(k) for k in set(keys) if keys.count(k) > 1):
        raise SourceError(f"{source}: two images are called '{twice[0]}': frames cannot be told by name")
    return keys


def _object(o: dict[str, Any]) -> TrueObject:
    components = {
        name: TrueComponent(float(c["full_px"]), float(c["visible_px"]), _point(c["centre"]))
        for name, c in o["components"].items()
    }
    pose = Pose(_rotation(o["rotation"]), np.array(o["position"], float)) if "position" in o else None
    joints = {str(name): float(q) for name, q in (o.get("joints") or {}).items()}
    name = None if o.get("object") is None else str(o["object"])
    label = int(o["team"]) if name is None or "team" in o else None
    return TrueObject(label, pose, components, _point(o.get("centre_px")), name, joints)


def _rotation(value: Any) -> Array:
    R = np.array(value, float)
    if R.shape != (3, 3) or np.abs(R @ R.T - np.eye(3)).max() > _ROUNDED or np.linalg.det(R) < 0:
        raise ValueError("'rotation' is none: three rows, perpendicular and of length 1, right-handed, are wanted")
    return R


def _point(value: Any) -> Array | None:
    return None if value is None else readonly(value).reshape(2)
