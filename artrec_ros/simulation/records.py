"""Truth as plain values: lines of truth.jsonl and COCO keypoint annotations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..core.geometry.transforms import Array
from ..core.model.objects import ObjectModel
from ..core.model.target import Target
from .simulator import SimulatedFrame
from .truth import MarkerTruth, ObjectTruth

_VISIBLE_SHARE = 0.6  # a marker is annotated when this much of it shows ...
LEAST_FACING = 0.35  # ... and it is not seen at too flat an angle for a similarity to describe it
_LEAST_PX = 12.0  # ... and one could tell where its axis ends
_COUNTED_SHARE = 0.5  # of several markers of a component, one with this share visible stands for it


def truth_record(frame: SimulatedFrame) -> dict[str, Any]:
    """A line of truth.jsonl.

    An object's `components` are named COMPONENT for the marker that shows that component best, COMPONENT@MARKER
    for its other markers that face the camera. Of a box, cylinder or ball of one colour
    COMPONENT is all of it that shows, beside each of its sides.
    """
    return {"stamp_ns": frame.stamp_ns, "objects": [_object_record(truth) for truth in frame.truths]}


def _object_record(truth: ObjectTruth) -> dict[str, Any]:
    placed = truth.placed
    components: dict[str, Any] = {}
    ranked = sorted(truth.markers, key=lambda m: (m.visible_share >= _COUNTED_SHARE, m.visible_px), reverse=True)
    for marker in _whole(ranked, placed.target, truth.balls_px):
        name = marker.component if marker.component not in components else f"{marker.component}@{marker.marker}"
        components[name] = {
            "marker": marker.marker,
            "visible_px": marker.visible_px,
            "full_px": marker.full_px,
            "centre": None if marker.centre is None else marker.centre.tolist(),
        }
    who = {} if placed.identity is None else {"identity": placed.identity}
    return {
        "object": placed.target.name,
        **who,
        "team": placed.target.label,
        "position": placed.T_camera_object.position.tolist(),
        "rotation": placed.T_camera_object.rotation.tolist(),
        "joints": placed.joints,
        "components": components,
        "centre_px": truth.centre_px.tolist(),
    }


def _whole(ranked: Sequence[MarkerTruth], target: Target, balls_px: Mapping[str, Array]) -> list[MarkerTruth]:
    """The same with solids as one, and their sides, too: a component is told by the side that shows it best, and where
    others hide most of it, one may be in full view. A ball is where its centre is, whatever hides part of it."""
    solids = [c.name for c in target.model.components if c.name in target.solids]
    sides = [[m for m in ranked if m.component == name] for name in solids]
    at = [m.centre if m.centre is None else balls_px.get(m.component, m.centre) for m in ranked]
    left = [replace(m, centre=centre) for m, centre in zip(ranked, at, strict=True)]
    return [*(_all_of(of) for of in sides if of), *left]


def _all_of(sides: Sequence[MarkerTruth]) -> MarkerTruth:
    seen = [(m.centre, m.visible_px) for m in sides if m.centre is not None]
    visible_px, full_px = sum(m.visible_px for m in sides), sum(m.full_px for m in sides)
    centre = sum((c * px for c, px in seen), np.zeros(2)) / visible_px if seen else None
    # the best seen one gives its name
    return replace(sides[0], visible_px=visible_px, full_px=full_px, centre=centre)


def keypoint_names(model: ObjectModel) -> list[str]:
    """COMPONENT/MARKER.tail and .head of every marker, of a ball COMPONENT.centre and .edge, in the model's order."""
    names: list[str] = []
    for (component, name), marker in model.markers.items():
        balls = f"{component}.centre", f"{component}.edge"
        names += balls if marker.is_ball else (f"{component}/{name}.tail", f"{component}/{name}.head")
    return names


def is_annotated(marker: MarkerTruth) -> bool:
    """Whether somebody who annotates the image would mark this marker's axis."""
    return marker.visible_share >= _VISIBLE_SHARE and marker.facing >= LEAST_FACING and marker.visible_px >= _LEAST_PX


@dataclass(frozen=True)
class CocoBuilder:
    """Collects COCO keypoint annotations; one category for each target."""

    targets: Sequence[Target]
    content: dict[str, Any]

    @classmethod
    def of(cls, targets: Sequence[Target]) -> CocoBuilder:
        categories = []
        for number, target in enumerate(targets, start=1):
            names = keypoint_names(target.model)
            skeleton = [[i, i + 1] for i in range(1, len(names), 2)]
            categories.append(
                {"id": number, "name": target.name, "supercategory": "articulated", "keypoints": names}
                | {"skeleton": skeleton}
            )
        info = {"description": "simulated examples"}
        return cls(targets, {"info": info, "images": [], "annotations": [], "categories": categories})

    def add(self, frame: SimulatedFrame, file_name: str) -> None:
        """One image and its objects; an object without any marker to annotate is left out."""
        width, height = frame.camera.size
        image = {"id": frame.index, "file_name": file_name, "width": width, "height": height}
        self.content["images"].append(image)
        numbers = {target.name: i for i, target in enumerate(self.targets, start=1)}
        for truth in frame.truths:
            marked = {(m.component, m.marker): m for m in truth.markers if is_annotated(m)}
            if not marked:
                continue
            target = truth.placed.target
            annotation = {
                "id": len(self.content["annotations"]),
                "image_id": frame.index,
                "category_id": numbers[target.name],
                "keypoints": _keypoints(target.model, marked),
                "num_keypoints": 2 * len(marked),
                "bbox": _bounds(list(marked.values())),
                "area": round(sum(m.visible_px for m in marked.values()), 1),
                "iscrowd": 0,
            }
            if truth.placed.identity is not None:
                annotation["attributes"] = {"identity": truth.placed.identity}
            self.content["annotations"].append(annotation)


def _keypoints(model: ObjectModel, marked: dict[tuple[str, str], MarkerTruth]) -> list[float]:
    """x, y, visibility of every keypoint: 2 = annotated, 0 = not."""
    values: list[float] = []
    for key in model.markers:
        truth = marked.get(key)
        for point in () if truth is None else (truth.tail, truth.head):
            values += [round(float(point[0]), 2), round(float(point[1]), 2), 2]
        if truth is None:
            values += [0, 0, 0, 0, 0, 0]
    return values


def _bounds(markers: Sequence[MarkerTruth]) -> list[float]:
    """x, y, width, height around the visible parts of the markers, pixels."""
    boxes = [m.bounds for m in markers if m.bounds is not None]
    x, y = min(b[0] for b in boxes), min(b[1] for b in boxes)
    right, bottom = max(b[0] + b[2] for b in boxes), max(b[1] + b[3] for b in boxes)
    return [round(v, 2) for v in (x, y, right - x, bottom - y)]
