"""What a replay has recognised so far, digit by digit, in the order in which it was done: a replay goes on from it.

A line is a JSON list: the frame's number among all frames of the replay, and a `Recognised`. Frozen dataclasses are
written as {"type": ..., field: ...}, arrays as {"array": ..., "shape": ...}; what is read equals what was written.
"""

from __future__ import annotations

import dataclasses
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from ...core.geometry.transforms import Pose
from ...core.memory.looks import Looks
from ...core.memory.memory import Instead, Known, Memory
from ...core.model.found import (
    ClassFit,
    Detection,
    Filtered,
    IdentityFit,
    ImagePose,
    Instance,
    Missing,
    Motion,
    OtherObject,
    OtherPlace,
    OtherTurn,
)
from ...core.model.frame_result import ConstraintFailure, FrameResult, Rejection
from ..base.json_lines import parsed_line
from ..base.typed import typed
from ..base.whole_files import LineFile
from .results import FrameRecord

JOURNAL_FILE = "journal.jsonl"


@dataclass(frozen=True)
class Recognised:
    """A frame and what was found in it, or the `error` why it could not be used.

    :param frame: the bag's topic or the file's name. :param frame_id: the camera's optical frame.
    :param memory: what it and those before it tell the next one; None: nothing.
    """

    stamp_ns: int
    frame: str
    result: FrameResult | None = None
    frame_id: str = ""
    error: str | None = None
    memory: Memory | None = None

    def record(self) -> FrameRecord:
        """As detections.jsonl has it."""
        if self.result is None:
            return FrameRecord(self.stamp_ns, self.frame, error=self.error)
        return FrameRecord.of(self.stamp_ns, self.frame, self.result, self.frame_id)


_TYPES = {
    kind.__name__: kind
    for kind in (
        ClassFit, ConstraintFailure, Detection, Filtered, FrameResult, IdentityFit, ImagePose, Instance, Instead, Known,
        Looks, Memory, Missing, Motion, OtherObject, OtherPlace, OtherTurn, Pose, Recognised, Rejection,
    )
}  # fmt: skip


class Journal:
    """The frames done so far, in a file. A context manager.

    :ivar lost: why frames of an earlier run are not there any more, a line for the user; empty: all are.
    """

    def __init__(self, path: Path) -> None:
        """:raises OSError: it cannot be opened."""
        self._path, self.lost = path, ""
        self._file = LineFile(path)

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *error: Any) -> None:
        self._file.__exit__(*error)

    def append(self, number: int, frame: Recognised) -> Recognised:
        """Adds a frame and returns it as it will be read: what follows does not depend on whether it was.

        :raises OSError: it cannot be written; the file is as it was before.
        """
        line = json.dumps([number, _packed(frame)], ensure_ascii=False)
        self._file.append(line)
        return _parsed(line)[1]

    def frames(self) -> Iterator[tuple[int, Recognised]]:
        """Number and frame, in the order of their lines, up to the first that is none: from there on the file is cut
        off, and `lost` says why."""
        for place, line in enumerate(self._file.lines(), 1):
            try:
                number, frame = _parsed(line)
                done = number, _told(frame)
            except ValueError as error:
                self._file.cut(place - 1)
                self.lost = f"{self._path}: line {place} is no frame: {error}; what follows is recognised again"
                break
            yield done


def _told(frame: Recognised) -> Recognised:
    """A frame whose values are of their kinds. :raises ValueError: they are not, or no line of results holds them."""
    typed(frame, Recognised)
    try:
        frame.record().to_json()
    except (ValueError, TypeError):
        raise ValueError("it holds numbers that are none") from None
    return frame


def _parsed(line: str) -> tuple[int, Recognised]:
    """:raises ValueError: it is no frame, as a user can be told."""
    content = parsed_line(line)
    try:
        number, frame = content[0], _unpacked(content[1])
    except (LookupError, TypeError, ValueError, AttributeError):
        raise ValueError("something in it is missing or of another kind") from None
    if not isinstance(number, int) or not isinstance(frame, Recognised):
        raise ValueError("neither a number nor a frame")
    return number, frame


def _packed(value: Any) -> Any:
    if isinstance(value, FrameResult):
        value = dataclasses.replace(value, labels=None, rejected=tuple(value.rejected), doubtful=tuple(value.doubtful))
    if dataclasses.is_dataclass(value):
        fields = {f.name: _packed(getattr(value, f.name)) for f in dataclasses.fields(value)}
        return {"type": type(value).__name__, **fields}
    if isinstance(value, np.ndarray):
        return {"array": value.astype(np.float64).ravel().tolist(), "shape": value.shape}
    if isinstance(value, dict):
        return {"dict": {key: _packed(item) for key, item in value.items()}}
    if isinstance(value, (list, tuple)):
        return [_packed(item) for item in value]
    return value.item() if isinstance(value, np.generic) else value


def _unpacked(value: Any) -> Any:
    if isinstance(value, list):
        return tuple(_unpacked(item) for item in value)
    if not isinstance(value, dict):
        return value
    if "array" in value:
        return np.array(value["array"], np.float64).reshape(value["shape"])
    if "dict" in value:
        return {key: _unpacked(item) for key, item in value["dict"].items()}
    fields = {name: _unpacked(item) for name, item in value.items() if name != "type"}
    return _TYPES[value["type"]](**fields)
