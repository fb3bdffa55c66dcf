"""detections.jsonl of a replay: one line per frame."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from ...core.model.found import Detection
from ...core.model.frame_result import FrameResult, Rejection
from ..base.json_lines import at_line, lines_of, parsed_line
from ..base.typed import typed
from .found_objects import detection_of, detection_to_dict, rejection_to_dict, rounded
from .line_format import Line

DETECTIONS_FILE, SUMMARY_FILE, VIDEO_FILE = "detections.jsonl", "summary.json", "video.mp4"


@dataclass(frozen=True)
class FrameRecord:
    """What was found in one frame, or the `error` why it could not be used.

    :param ended_by: the limits that ended the search early, by the parameters' names.
    :param frame_id: of poses that do not tell their own. :param source: number of its source in a replay of several;
        None: there is one.
    :param waiting: blobs that were searched in vain before, and wait their turn to be searched again.
    """

    stamp_ns: int
    frame: str
    size: tuple[int, int] | None = None
    detections: tuple[Detection, ...] = ()
    rejected: tuple[Rejection, ...] = ()
    timing_ms: dict[str, float] = field(default_factory=dict)
    ended_by: tuple[str, ...] = ()
    frame_id: str = ""
    error: str | None = None
    source: int | None = None
    waiting: int = 0

    @property
    def complete(self) -> bool:
        """Whether no limit ended the search early."""
        return not self.ended_by

    @classmethod
    def of(cls, stamp_ns: int, frame: str, result: FrameResult, frame_id: str = "") -> FrameRecord:
        """:param frame_id: the camera's optical frame, to which the poses refer."""
        r = result
        found = r.size, r.detections, tuple(r.rejected), r.timing_ms, r.ended_by
        return cls(stamp_ns, frame, *found, frame_id, waiting=r.waiting)

    def to_json(self) -> str:
        """One line, as docs/replay.md describes it."""
        content: dict[str, Any] = {"stamp_ns": self.stamp_ns, "frame": self.frame, "size": self.size}
        if self.source is not None:
            content["source"] = self.source
        content["objects"] = [detection_to_dict(d, self.frame_id) for d in self.detections]
        content["rejected"] = [rejection_to_dict(r) for r in self.rejected]
        content["timing_ms"] = {stage: rounded(t, 3) for stage, t in self.timing_ms.items()}
        content["complete"] = self.complete
        if self.ended_by:
            content["ended_by"] = list(self.ended_by)
        if self.waiting:
            content["waiting"] = self.waiting
        if self.error is not None:
            content["error"] = self.error
        return json.dumps(content, allow_nan=False, ensure_ascii=False)

    @classmethod
    def from_json(cls, line: str) -> FrameRecord:
        """:raises ValueError: it is no line of a result; the key, and what would be."""
        c = typed(parsed_line(line), Line)
        detections = [detection_of(o, f"objects[{i}]") for i, o in enumerate(c["objects"])]
        poses = [o["pose"] for o in c["objects"] if o["pose"] is not None and o.get("pose_from") != "plane"]
        frame_id = poses[0]["frame_id"] if poses else ""
        return cls(
            stamp_ns=c["stamp_ns"],
            frame=c["frame"],
            size=c.get("size"),
            detections=tuple(replace(d, frame_id="") if d.frame_id == frame_id else d for d in detections),
            rejected=c.get("rejected", ()),
            timing_ms=c.get("timing_ms", {}),
            ended_by=c.get("ended_by", ()),
            frame_id=frame_id,
            error=c.get("error"),
            source=c.get("source"),
            waiting=c.get("waiting", 0),
        )


def read_results(path: Path) -> Iterator[FrameRecord]:
    """The frames of a detections.jsonl, in order.

    :raises SourceError: naming file, line and key that cannot be read.
    """
    for number, line in enumerate(lines_of(path), 1):
        with at_line(path, number):
            record = FrameRecord.from_json(line)
        yield record
