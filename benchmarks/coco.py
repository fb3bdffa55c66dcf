"""COCO keypoints as `artrec train` reads them, written from measured axes."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from pathlib import Path

Axis = tuple[tuple[float, float], tuple[float, float]]  # tail, head in pixels


class CocoWriter:
    """Collects one annotation per object; keypoints are COMPONENT/MARKER.tail and .head.

    :param markers: COMPONENT/MARKER names, in the order of the keypoints.
    """

    def __init__(self, description: str, categories: Sequence[str], markers: Sequence[str]) -> None:
        self._markers = tuple(markers)
        keypoints = [f"{m}.{end}" for m in markers for end in ("tail", "head")]
        self._ids = {name: i + 1 for i, name in enumerate(categories)}
        self._content: dict = {"info": {"description": description}, "images": [], "annotations": []}
        self._content["categories"] = [
            {"id": i, "name": name, "supercategory": "articulated", "keypoints": keypoints}
            for name, i in self._ids.items()
        ]

    def add_image(self, file_name: str, width: int, height: int) -> int:
        """The image's id."""
        images = self._content["images"]
        images.append({"id": len(images), "file_name": file_name, "width": width, "height": height})
        return len(images) - 1

    def add_object(
        self, image_id: int, category: str, axes: Mapping[str, Axis], attributes: Mapping[str, str] | None = None
    ) -> None:
        """:param axes: COMPONENT/MARKER -> axis, of those that are seen. :param attributes: as CVAT writes them."""
        points: list[float] = []
        for marker in self._markers:
            for end in axes.get(marker, ()):
                points += [round(end[0], 2), round(end[1], 2), 2]
            points += [] if marker in axes else [0] * 6
        entry = {"image_id": image_id, "category_id": self._ids[category], "keypoints": points, "iscrowd": 0}
        self._content["annotations"].append(
            {"id": len(self._content["annotations"]), **entry, "num_keypoints": 2 * len(axes)}
            | ({"attributes": dict(attributes)} if attributes else {})
        )

    def write(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps(self._content), encoding="utf-8")
