"""truth.jsonl: what a scorer knows about each frame, one line per frame."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ..core.errors import SourceError
from ..core.transforms import Array, Pose, readonly


@dataclass(frozen=True)
class TrueComponent:
    """A marker that faces the camera.

    :param full_px: its area if nothing hid it, pixels. :param visible_px: the visible part of that.
    :param centre: (2,) centre of the visible part, pixels; None: nothing of it is visible.
    """

    full_px: float
    visible_px: float
    centre: Array | None


@dataclass(frozen=True)
class TrueObject:
    """An object of the scene.

    :param label: its class number, which tells its name. :param pose: its frame in the camera's optical frame.
    :param components: by the truth's names: 'COMPONENT', 'COMPONENT_SIDE' or 'COMPONENT@SIDE'.
    :param centre_px: (2,) the object's origin in the image.
    """

    label: int
    pose: Pose
    components: Mapping[str, TrueComponent]
    centre_px: Array | None


def load_truth(path: Path) -> dict[int, tuple[TrueObject, ...]]:
    """The objects of each frame by the frame's stamp in nanoseconds. :raises SourceError: naming file and line."""
    truth: dict[int, tuple[TrueObject, ...]] = {}
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise SourceError(f"{path}: cannot be read: {error}") from error
    for number, line in enumerate(lines, 1):
        try:
            record = json.loads(line)
            truth[int(record["stamp_ns"])] = tuple(_object(o) for o in record["objects"])
        except (KeyError, TypeError, ValueError) as error:
            raise SourceError(f"{path}: line {number} is no line of truth: {error!r}") from error
    if not truth:
        raise SourceError(f"{path}: holds no frame")
    return truth


def _object(o: dict[str, Any]) -> TrueObject:
    components = {
        name: TrueComponent(float(c["full_px"]), float(c["visible_px"]), _point(c["centre"]))
        for name, c in o["components"].items()
    }
    pose = Pose(np.array(o["rotation"], float), np.array(o["position"], float))
    return TrueObject(int(o["team"]), pose, components, _point(o.get("centre_px")))


def _point(value: Any) -> Array | None:
    return None if value is None else readonly(value).reshape(2)
