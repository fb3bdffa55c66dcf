"""A line of detections.jsonl, as docs/replay.md describes it: what `typed` reads it by."""

from __future__ import annotations

from typing import Annotated, TypedDict

from ...core.model.found import ClassFit, ImagePose, MissingState, PoseSource
from ...core.model.frame_result import Rejection
from ..base.typed import Amount, Between, Share, Stamp

_Triple = tuple[float, float, float]
_Quadruple = tuple[float, float, float, float]
_Sextuple = tuple[float, float, float, float, float, float]
_Joints = dict[str, float]
_Count = Annotated[int, Between(0, 2**31)]


class Place(TypedDict):
    """A pose: metres and a quaternion x, y, z, w."""

    position: _Triple
    orientation: _Quadruple


class _FramedPlace(Place):
    frame_id: str


class _OtherPlace(Place):
    probability: Share


class OtherPlace(_OtherPlace, total=False):
    """`other_turn`."""

    joints: _Joints


class OtherImagePlace(TypedDict):
    """`other_place`."""

    probability: Share
    x: float
    y: float
    theta: float
    scale: float


class OtherObjectShare(TypedDict):
    """`other_object`."""

    object: str
    probability: Share


class _FilteredPlace(Place):
    covariance: tuple[float, ...]
    joints: _Joints
    joint_deviations: _Joints


class FilteredPlace(_FilteredPlace, total=False):
    """`filtered`."""

    twist: _Sextuple
    joint_rates: _Joints


class _Seen(TypedDict):
    name: str
    marker: str
    score: Share
    x: float
    y: float
    theta: float
    scale: float


class _Component(_Seen, total=False):
    shows: str


class _Missing(TypedDict):
    name: str
    state: MissingState
    x: float
    y: float


class _MissingWhy(_Missing, total=False):
    by: str
    score: Share


class _FoundObject(TypedDict):
    object: str
    id: _Count
    score: Share
    image: ImagePose
    pose: _FramedPlace | None
    joints: _Joints
    components: tuple[_Component, ...]


class _Told(_FoundObject, total=False):
    joint_deviations: _Joints
    margin: float | None
    identity: str | None
    identity_probability: Share
    identity_runner_up: str | None
    identity_unique: bool
    pose_from: PoseSource
    plane_scale: Amount | None
    predicted: bool
    filtered: FilteredPlace | None
    other_turn: OtherPlace | None
    other_place: OtherImagePlace | None
    other_object: OtherObjectShare | None
    as_told: Share
    missing: tuple[_MissingWhy, ...]


_Class = TypedDict("_Class", {"class": ClassFit | None}, total=False)  # no name that a class could hold


class FoundObject(_Told, _Class):
    pass


class _Line(TypedDict):
    stamp_ns: Stamp
    frame: str
    objects: tuple[FoundObject, ...]


class Line(_Line, total=False):
    """A line."""

    size: tuple[_Count, _Count] | None
    rejected: tuple[Rejection, ...]
    timing_ms: dict[str, float]
    ended_by: tuple[str, ...]
    error: str | None
    source: _Count | None
    waiting: _Count
