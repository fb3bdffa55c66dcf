"""detections.jsonl of a replay: one line per frame. Lengths and angles are rounded far below what can be measured."""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from ...core.geometry.transforms import Pose, rotation_from_quaternion
from ...core.model.found import (
    ClassFit,
    Detection,
    Filtered,
    FrameResult,
    IdentityFit,
    ImagePose,
    Instance,
    Missing,
    Motion,
    OtherPlace,
    OtherTurn,
    Rejection,
)
from ..base.json_lines import at_line, lines_of, parsed_line
from ..base.typed import UnfitError, typed
from .line_format import FilteredPlace, FoundObject, Line, OtherImagePlace, Place
from .line_format import OtherPlace as OtherSpatialPlace

DETECTIONS_FILE, SUMMARY_FILE = "detections.jsonl", "summary.json"


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
        content["objects"] = [_detection_to_dict(d, self.frame_id) for d in self.detections]
        content["rejected"] = [_rejection_to_dict(r) for r in self.rejected]
        content["timing_ms"] = {stage: _f(t, 3) for stage, t in self.timing_ms.items()}
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
        detections = [_built(o, f"objects[{i}]") for i, o in enumerate(c["objects"])]
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


def _f(value: Any, digits: int) -> float:
    return round(float(value), digits)


def _detection_to_dict(d: Detection, frame_id: str) -> dict[str, Any]:
    pose = d.pose and {"frame_id": d.frame_id or frame_id, **_pose_to_dict(d.pose)}
    told: dict[str, Any] = {} if d.class_fit is None else {"class": _class_to_dict(d.class_fit)}
    if d.margin is not None:
        told["margin"] = _f(d.margin, 4)
    if d.identity is not None:
        told |= {"identity": d.identity.name, "identity_probability": _f(d.identity.probability, 4)}
        told |= {"identity_runner_up": d.identity.runner_up, "identity_unique": d.identity.unique}
    if d.pose is not None and d.pose_from != "fit":
        told["pose_from"] = d.pose_from
    if d.predicted:
        told["predicted"] = True
    if d.joint_deviations:
        told["joint_deviations"] = {name: _f(q, 6) for name, q in d.joint_deviations.items()}
    if d.other_turn is not None:
        other = d.other_turn
        told["other_turn"] = {
            "probability": _f(other.probability, 4),
            **_pose_to_dict(other.pose),
            "joints": {name: _f(value, 6) for name, value in other.joints.items()},
        }
    if d.other_place is not None:
        told["other_place"] = {
            "probability": _f(d.other_place.probability, 4),
            **_place_to_dict(d.other_place.image),
        }
    if d.as_told < 1:
        told["as_told"] = _f(d.as_told, 4)
    if d.missing:
        told["missing"] = [_missing_to_dict(m) for m in d.missing]
    if d.filtered is not None:
        told["filtered"] = _filtered_to_dict(d.filtered, d.motion)
    return {
        "object": d.object,
        "id": d.id,
        "score": _f(d.score, 4),
        **told,
        "image": _place_to_dict(d.image),
        "pose": pose,
        "joints": {name: _f(q, 6) for name, q in d.joints.items()},
        "components": [_component_to_dict(c) for c in d.components],
    }


def _pose_to_dict(pose: Pose) -> dict[str, Any]:
    return {"position": [_f(v, 6) for v in pose.position], "orientation": [_f(v, 9) for v in pose.quaternion]}


def _component_to_dict(c: Instance) -> dict[str, Any]:
    shows = {"shows": c.shows} if c.shows else {}
    return {"name": c.component, "marker": c.marker, "score": _f(c.score, 4), **shows, **_place_to_dict(c)}


def _missing_to_dict(m: Missing) -> dict[str, Any]:
    content: dict[str, Any] = {"name": m.component, "state": m.state, "x": _f(m.x, 2), "y": _f(m.y, 2)}
    if m.by:
        content["by"] = m.by
    return {**content, "score": _f(m.score, 4)} if m.state == "in doubt" else content


def _filtered_to_dict(f: Filtered, motion: Motion | None) -> dict[str, Any]:
    content = {
        **_pose_to_dict(f.pose),
        "covariance": [_f(v, 10) for v in f.covariance.ravel()],
        "joints": {name: _f(q, 6) for name, q in f.joints.items()},
        "joint_deviations": {name: _f(q, 6) for name, q in f.joint_deviations.items()},
    }
    if motion is not None:
        content["twist"] = [_f(v, 6) for v in motion.twist]
        content["joint_rates"] = {name: _f(q, 6) for name, q in motion.joints.items()}
    return content


def _rejection_to_dict(r: Rejection) -> dict[str, Any]:
    place = {"score": _f(r.score, 4), "x": _f(r.x, 2), "y": _f(r.y, 2)}
    content: dict[str, Any] = {"object": r.object, "reason": r.reason, **place}
    if r.failed is not None:
        content["failed"] = {k: v if isinstance(v, str) else _f(v, 6) for k, v in vars(r.failed).items()}
    return content


def _class_to_dict(c: ClassFit) -> dict[str, Any]:
    content: dict[str, Any] = {"name": c.name, "confidence": _f(c.confidence, 4), "runner_up": c.runner_up}
    content["runner_up_confidence"] = _f(c.runner_up_confidence, 4)
    return {**content, "reason": c.reason} if c.name is None else content


def _place_to_dict(p: ImagePose | Instance) -> dict[str, float]:
    return {"x": _f(p.x, 3), "y": _f(p.y, 3), "theta": _f(p.theta, 6), "scale": _f(p.scale, 4)}


def _pose(p: Place, place: str) -> Pose:
    """:param place: its key in the line."""
    if not np.linalg.norm(p["orientation"]) > 0:
        raise UnfitError(f"{list(p['orientation'])} has no length", f"{place}.orientation")
    return Pose(rotation_from_quaternion(p["orientation"]), np.array(p["position"]))


def _built(o: FoundObject, place: str) -> Detection:
    """:param place: its key in the line."""
    pose, filtered, other, fit = o["pose"], o.get("filtered"), o.get("other_turn"), o.get("class")
    elsewhere = o.get("other_place")
    return Detection(
        object=o["object"],
        id=o["id"],
        score=o["score"],
        image=o["image"],
        components=tuple(
            Instance(
                c["name"], c["marker"], c["score"], c["x"], c["y"], c["theta"], c["scale"], shows=c.get("shows", "")
            )
            for c in o["components"]
        ),
        pose=_pose(pose, f"{place}.pose") if pose else None,
        joints=o["joints"],
        joint_deviations=o.get("joint_deviations", {}),
        class_fit=fit,
        margin=o.get("margin"),
        identity=_identity(o, place),
        frame_id=pose["frame_id"] if pose else "",
        pose_from=o.get("pose_from", "fit"),
        predicted=o.get("predicted", False),
        motion=_motion(filtered) if filtered else None,
        filtered=_filtered(filtered, f"{place}.filtered") if filtered else None,
        other_turn=_other_turn(other, f"{place}.other_turn") if other else None,
        other_place=_other_place(elsewhere) if elsewhere else None,
        as_told=o.get("as_told", 1.0),
        missing=tuple(
            Missing(m["name"], m["state"], m["x"], m["y"], m.get("by", ""), m.get("score", 0.0))
            for m in o.get("missing", ())
        ),
    )


def _other_turn(o: OtherSpatialPlace, place: str) -> OtherTurn:
    return OtherTurn(_pose(o, place), o["probability"], o.get("joints", {}))


def _other_place(o: OtherImagePlace) -> OtherPlace:
    return OtherPlace(ImagePose(o["x"], o["y"], o["theta"], o["scale"]), o["probability"])


def _filtered(f: FilteredPlace, place: str) -> Filtered:
    if len(f["covariance"]) != 36:
        raise UnfitError("must be a list of 36", f"{place}.covariance")
    covariance = np.array(f["covariance"]).reshape(6, 6)
    return Filtered(_pose(f, place), covariance, f["joints"], f["joint_deviations"])


def _motion(f: FilteredPlace) -> Motion | None:
    return Motion(np.array(f["twist"]), f.get("joint_rates", {})) if "twist" in f else None


def _identity(o: FoundObject, place: str) -> IdentityFit | None:
    if "identity_probability" not in o:
        return None
    if "identity" not in o:
        raise UnfitError("this key is missing", f"{place}.identity")
    told = o["identity"], o["identity_probability"]
    return IdentityFit(*told, o.get("identity_runner_up"), o.get("identity_unique", False))
