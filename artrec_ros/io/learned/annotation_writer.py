"""Annotated examples as a COCO keypoint file, which `load_coco` and annotation tools read."""

from __future__ import annotations

import json
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ..base.whole_files import save_file
from .annotations import AnnotatedObject


def save_coco(
    path: Path,
    categories: Mapping[str, Sequence[str]],
    objects: Sequence[AnnotatedObject],
    empty: Sequence[Path] = (),
) -> None:
    """Writes the file. Images are named relative to its folder.

    :param categories: category name -> names of its keypoints.
    :param empty: images in which there is no object.
    :raises ConfigError: it cannot be written.
    """
    files = list(dict.fromkeys([*(o.image for o in objects), *empty]))
    sizes = {o.image: o.size for o in objects if o.size is not None}
    numbers = {name: n for n, name in enumerate(categories, start=1)}
    content = {
        "info": {"description": "examples marked in artrec studio"},
        "images": [_image(n, file, path.parent, sizes.get(file)) for n, file in enumerate(files, start=1)],
        "categories": [
            {"id": numbers[name], "name": name, "keypoints": list(keypoints)} for name, keypoints in categories.items()
        ],
        "annotations": [
            {"id": n, "image_id": files.index(o.image) + 1, "category_id": numbers[o.category]}
            | _marked(o, categories[o.category])
            for n, o in enumerate(objects, start=1)
        ],
    }
    save_file(path, json.dumps(content, indent=1))


def _image(number: int, file: Path, folder: Path, size: tuple[int, int] | None) -> dict[str, Any]:
    row: dict[str, Any] = {"id": number, "file_name": os.path.relpath(file.absolute(), folder.absolute())}
    return row if size is None else {**row, "width": size[0], "height": size[1]}


def _marked(annotated: AnnotatedObject, keypoints: Sequence[str]) -> dict[str, Any]:
    values: list[float] = []
    for name in keypoints:
        point = annotated.points.get(name)
        values += [0, 0, 0] if point is None else [round(float(point[0]), 2), round(float(point[1]), 2), 2]
    corners = annotated.box if annotated.box is not None else np.array([*annotated.points.values()]).reshape(-1, 2)
    corners = corners if len(corners) else np.zeros((1, 2))  # nothing of it is marked yet
    low, high = corners.min(axis=0), corners.max(axis=0)
    box = [round(float(v), 2) for v in (*low, *(high - low))]
    row = {"keypoints": values, "num_keypoints": len(annotated.points), "bbox": box, "area": box[2] * box[3]}
    return {**row, "iscrowd": 0, **({"attributes": dict(annotated.attributes)} if annotated.attributes else {})}
