"""What is found, as an object of detections.jsonl, and back. Lengths and angles are rounded far below what can be
measured."""

from __future__ import annotations

from typing import Any

import numpy as np

from ...core.geometry.transforms import Pose, rotation_from_quaternion
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
from ...core.model.frame_result import Rejection
from ..base.typed import UnfitError
from .line_format import FilteredPlace, FoundObject, OtherImagePlace, Place
from .line_format import OtherPlace as OtherSpatialPlace


def rounded(value: Any, digits: int) -> float:
    """To so many digits after the point, whatever kind of number it is."""
    return round(float(value), digits)


def detection_to_dict(d: Detection, frame_id: str) -> dict[str, Any]:
    """An entry of `objects`. :param frame_id: of a pose that does not tell its own."""
    pose = d.pose and {"frame_id": d.frame_id or frame_id, **_pose_to_dict(d.pose)}
    told: dict[str, Any] = {} if d.class_fit is None else {"class": _class_to_dict(d.class_fit)}
    if d.margin is not None:
        told["margin"] = rounded(d.margin, 4)
    if d.identity is not None:
        told |= {"identity": d.identity.name, "identity_probability": rounded(d.identity.probability, 4)}
        told |= {"identity_runner_up": d.identity.runner_up, "identity_unique": d.identity.unique}
    if d.pose is not None and d.pose_from != "fit":
        told["pose_from"] = d.pose_from
    if d.plane_scale is not None:
        told["plane_scale"] = rounded(d.plane_scale, 4)
    if d.predicted:
        told["predicted"] = True
    if d.joint_deviations:
        told["joint_deviations"] = {name: rounded(q, 6) for name, q in d.joint_deviations.items()}
    if d.other_turn is not None:
        other = d.other_turn
        told["other_turn"] = {
            "probability": rounded(other.probability, 4),
            **_pose_to_dict(other.pose),
            "joints": {name: rounded(value, 6) for name, value in other.joints.items()},
        }
    if d.other_place is not None:
        told["other_place"] = {
            "probability": rounded(d.other_place.probability, 4),
            **_place_to_dict(d.other_place.image),
        }
    if d.other_object is not None:
        rival = d.other_object
        told["other_object"] = {"object": rival.object, "probability": rounded(rival.probability, 4)}
    if d.as_told < 1:
        told["as_told"] = rounded(d.as_told, 4)
    if d.missing:
        told["missing"] = [_missing_to_dict(m) for m in d.missing]
    if d.filtered is not None:
        told["filtered"] = _filtered_to_dict(d.filtered, d.motion)
    return {
        "object": d.object,
        "id": d.id,
        "score": rounded(d.score, 4),
        **told,
        "image": _place_to_dict(d.image),
        "pose": pose,
        "joints": {name: rounded(q, 6) for name, q in d.joints.items()},
        "components": [_component_to_dict(c) for c in d.components],
    }


def _pose_to_dict(pose: Pose) -> dict[str, Any]:
    return {"position": [rounded(v, 6) for v in pose.position], "orientation": [rounded(v, 9) for v in pose.quaternion]}


def _component_to_dict(c: Instance) -> dict[str, Any]:
    shows = {"shows": c.shows} if c.shows else {}
    return {"name": c.component, "marker": c.marker, "score": rounded(c.score, 4), **shows, **_place_to_dict(c)}


def _missing_to_dict(m: Missing) -> dict[str, Any]:
    content: dict[str, Any] = {"name": m.component, "state": m.state, "x": rounded(m.x, 2), "y": rounded(m.y, 2)}
    if m.by:
        content["by"] = m.by
    return {**content, "score": rounded(m.score, 4)} if m.score > 0 else content


def _filtered_to_dict(f: Filtered, motion: Motion | None) -> dict[str, Any]:
    content = {
        **_pose_to_dict(f.pose),
        "covariance": [rounded(v, 10) for v in f.covariance.ravel()],
        "joints": {name: rounded(q, 6) for name, q in f.joints.items()},
        "joint_deviations": {name: rounded(q, 6) for name, q in f.joint_deviations.items()},
    }
    if motion is not None:
        content["twist"] = [rounded(v, 6) for v in motion.twist]
        content["joint_rates"] = {name: rounded(q, 6) for name, q in motion.joints.items()}
    return content


def rejection_to_dict(r: Rejection) -> dict[str, Any]:
    """An entry of `rejected`."""
    place = {"score": rounded(r.score, 4), "x": rounded(r.x, 2), "y": rounded(r.y, 2)}
    content: dict[str, Any] = {"object": r.object, "reason": r.reason, **place}
    if r.failed is not None:
        content["failed"] = {k: v if isinstance(v, str) else rounded(v, 6) for k, v in vars(r.failed).items()}
    return content


def _class_to_dict(c: ClassFit) -> dict[str, Any]:
    content: dict[str, Any] = {"name": c.name, "confidence": rounded(c.confidence, 4), "runner_up": c.runner_up}
    content["runner_up_confidence"] = rounded(c.runner_up_confidence, 4)
    return {**content, "reason": c.reason} if c.name is None else content


def _place_to_dict(p: ImagePose | Instance) -> dict[str, float]:
    return {"x": rounded(p.x, 3), "y": rounded(p.y, 3), "theta": rounded(p.theta, 6), "scale": rounded(p.scale, 4)}


def _pose(p: Place, place: str) -> Pose:
    """:param place: its key in the line."""
    if not np.linalg.norm(p["orientation"]) > 0:
        raise UnfitError(f"{list(p['orientation'])} has no length", f"{place}.orientation")
    return Pose(rotation_from_quaternion(p["orientation"]), np.array(p["position"]))


def detection_of(o: FoundObject, place: str) -> Detection:
    """An entry of `objects`, read. :param place: its key in the line.

    :raises UnfitError: naming the key that does not fit the others.
    """
    pose, filtered, other, fit = o["pose"], o.get("filtered"), o.get("other_turn"), o.get("class")
    elsewhere, rival = o.get("other_place"), o.get("other_object")
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
        plane_scale=o.get("plane_scale"),
        predicted=o.get("predicted", False),
        motion=_motion(filtered) if filtered else None,
        filtered=_filtered(filtered, f"{place}.filtered") if filtered else None,
        other_turn=_other_turn(other, f"{place}.other_turn") if other else None,
        other_place=_other_place(elsewhere) if elsewhere else None,
        other_object=OtherObject(rival["object"], rival["probability"]) if rival else None,
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
