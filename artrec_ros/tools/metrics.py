"""How well detections agree with truth: pure functions that add up counts; rates divide last.

An object counts when its required component is in view: one of its markers has 30 px or more, half of it visible.
It is recognised when a detection of its name lies on it, one detection an object (the assignment with the least sum
of distances). It is right when, besides, every component of the detection lies on that object's own component and no
well visible component is missed.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields

import numpy as np
from scipy.optimize import linear_sum_assignment

from ..core.datatypes import Detection, Instance
from ..core.transforms import Array
from ..io.truth import TrueComponent, TrueObject

_COUNTED_PX, _COUNTED_SHARE = 30.0, 0.5  # the least required component of an object that counts
_EXPECTED_PX, _EXPECTED_SHARE = 25.0, 0.7  # the least other component whose absence is a miss
_NEAR = 0.5  # farthest detection of an object, in square roots of its largest marker's area
_LEAST_EXTENT_PX = 4.0
_ON_COMPONENT, _ON_COMPONENT_PX = 0.35, 1.0  # the same of a component, and pixels besides
_LEAST_COMPONENT_PX = 9.0
_FAR = 1e3  # the distance of pairs that no assignment should make


@dataclass(frozen=True)
class Counts:
    """What was counted over some frames; counts of different frames or names add up."""

    frames: int = 0
    frames_without_result: int = 0
    objects: int = 0
    recognised: int = 0
    right: int = 0
    false: int = 0
    components_right: int = 0
    components_wrong: int = 0
    components_missed: int = 0
    position_errors: tuple[float, ...] = ()
    rotation_errors_rad: tuple[float, ...] = ()

    def __add__(self, other: Counts) -> Counts:
        return Counts(*(getattr(self, f.name) + getattr(other, f.name) for f in fields(self)))

    def rates(self) -> dict[str, float | int | None]:
        """The figures to quote. Position errors are relative to the distance. None: there was nothing to measure."""
        found = self.components_right + self.components_wrong
        wanted = self.components_right + self.components_missed
        return {
            "frames": self.frames,
            "frames_without_result": self.frames_without_result,
            "objects": self.objects,
            "recognised": self.recognised,
            "recognition_rate": _ratio(self.recognised, self.objects),
            "right_rate": _ratio(self.right, self.objects),
            "false_per_frame": _ratio(self.false, self.frames),
            "component_precision": _ratio(self.components_right, found),
            "component_recall": _ratio(self.components_right, wanted),
            "position_error_median": _median(self.position_errors),
            "rotation_error_deg_median": _median(np.degrees(self.rotation_errors_rad)),
        }


def score(
    truth: Mapping[int, Sequence[TrueObject]],
    detections: Mapping[int, Sequence[Detection]],
    label: int,
    name: str,
    root: str,
) -> Counts:
    """Counts of one object name over all frames of the truth.

    :param truth, detections: by stamp. :param label: the truth's class number of objects of this name.
    :param root: name of the object's required component.
    """
    total = Counts()
    for stamp_ns, objects in truth.items():
        of_name = [d for d in detections.get(stamp_ns, ()) if d.object == name]
        total += score_frame([o for o in objects if o.label == label], of_name, root)
        total += Counts(frames=1, frames_without_result=int(stamp_ns not in detections))
    return total


def score_frame(objects: Sequence[TrueObject], detections: Sequence[Detection], root: str) -> Counts:
    """Counts of one object name in one frame. An object that does not count excuses the detection that lies on it."""
    counted = [is_in_view(o, root) for o in objects]
    distances = np.array([[_distance(o, d, root) for d in detections] for o in objects])
    pairs = []
    if distances.size:
        rows, columns = linear_sum_assignment(distances)
        pairs = [(i, j) for i, j in zip(rows, columns, strict=True) if distances[i, j] <= _NEAR]
    counts = Counts(objects=sum(counted), false=len(detections) - len(pairs))
    for i, j in pairs:
        if counted[i]:
            counts += _score_pair(objects[i], detections[j], root)
    return counts


def is_in_view(o: TrueObject, root: str) -> bool:
    """Whether an object counts: enough of its required component can be seen."""
    return any(
        c.full_px >= _COUNTED_PX and c.visible_px >= _COUNTED_SHARE * c.full_px
        for name, c in o.components.items()
        if c.centre is not None and shows(name, root)
    )


def shows(truth_name: str, component: str) -> bool:
    """Whether a name of the truth ('front_left@front', 'torso_left') is one of this component's markers."""
    return truth_name.split("@")[0] == component or truth_name.startswith(component + "_")


def _distance(o: TrueObject, d: Detection, root: str) -> float:
    """From the detection's required component to the object's, over the object's apparent size."""
    places = [c.centre for name, c in o.components.items() if shows(name, root)] + [o.centre_px]
    offsets = [_offset(d.image.x, d.image.y, p) for p in places if p is not None]
    extent = max((c.full_px for c in o.components.values()), default=1.0) ** 0.5
    return min(offsets, default=_FAR) / max(extent, _LEAST_EXTENT_PX)


def _score_pair(o: TrueObject, d: Detection, root: str) -> Counts:
    hits = {c: _is_on_its_component(c, o) for c in d.components}
    others = [hit for c, hit in hits.items() if c.component != root]
    missed = _missed(o, {c.component for c in d.components}, root)
    counts = Counts(
        recognised=1,
        right=int(all(hits.values()) and not missed),
        components_right=sum(others),
        components_wrong=len(others) - sum(others),
        components_missed=len(missed),
    )
    if d.pose is None:
        return counts
    error = np.linalg.norm(d.pose.position - o.pose.position) / np.linalg.norm(o.pose.position)
    cosine = (np.trace(d.pose.rotation.T @ o.pose.rotation) - 1) / 2
    return counts + Counts(
        position_errors=(float(error),), rotation_errors_rad=(float(np.arccos(np.clip(cosine, -1, 1))),)
    )


def _is_on_its_component(instance: Instance, o: TrueObject) -> bool:
    return any(
        _offset(instance.x, instance.y, c.centre)
        <= _ON_COMPONENT * max(c.full_px, _LEAST_COMPONENT_PX) ** 0.5 + _ON_COMPONENT_PX
        for name, c in o.components.items()
        if c.centre is not None and shows(name, instance.component)
    )


def _missed(o: TrueObject, found: set[str], root: str) -> set[str]:
    """Components that are well visible and were not found."""

    def is_expected(c: TrueComponent) -> bool:
        return c.full_px >= _EXPECTED_PX and c.visible_px >= _EXPECTED_SHARE * c.full_px

    expected = {name.split("@")[0] for name, c in o.components.items() if is_expected(c) and not shows(name, root)}
    return expected - found


def _offset(x: float, y: float, point: Array) -> float:
    return float(np.hypot(x - point[0], y - point[1]))


def _ratio(part: int, whole: int) -> float | None:
    return round(part / whole, 4) if whole else None


def _median(values: Sequence[float] | Array) -> float | None:
    return round(float(np.median(values)), 4) if len(values) else None
