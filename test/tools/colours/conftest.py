"""Folders of pictures, with what is marked in them and the files of a node."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from painted import (
    BLUE,
    FLOOR,
    NODE,
    OBJECT,
    RED,
    ROBOT,
    ROBOTS,
    YELLOW,
    picture,
)


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    """Pictures in images/, their labels in labels/, two boxes a picture in images/regions.json, a node's files."""
    images, annotations = [], []
    for n, light in enumerate((0.8, 1.0, 1.1)):
        image, labels = picture(light)
        for name, content in (("images", image), ("labels", labels)):
            (tmp_path / name).mkdir(exist_ok=True)
            cv2.imwrite(str(tmp_path / name / f"{n}.png"), content)
        images.append({"id": n, "file_name": f"{n}.png"})
        boxes = ((1, [10, 20, 20, 20]), (2, [50, 20, 20, 20]), (3, [0, 44, 90, 16]))
        annotations += [{"image_id": n, "category_id": c, "bbox": box} for c, box in boxes]
    names = [{"id": n, "name": name} for n, name in enumerate(("red", "blue", "floor"), start=1)]
    coco = {"images": images, "annotations": annotations, "categories": names}
    (tmp_path / "images" / "regions.json").write_text(json.dumps(coco))
    (tmp_path / "toy.yaml").write_text(OBJECT)
    (tmp_path / "node.yaml").write_text(NODE)
    return tmp_path


@pytest.fixture
def robots(tmp_path: Path) -> Path:
    """Two robots a picture, annotated by axes alone; a strip that is blanked has the team's colour."""
    keypoints = [f"{c}/square.{end}" for c in ("ahead", "behind") for end in ("tail", "head")]
    images, annotations = [], []
    for n, light in enumerate((0.8, 1.0, 1.1)):
        labels = np.zeros((60, 90), np.uint8)
        labels[:6] = 1
        for x, identity, label in ((10, "crimson", 3), (50, "azure", 2)):
            labels[12:28, x : x + 16] = 1
            labels[32:48, x : x + 16] = label
            ends = [(x, 27), (x + 16, 27), (x, 47), (x + 16, 47)]  # y up in the object: axes are the lower sides
            points = [v for end in ends for v in (*end, 2)]
            about = {"keypoints": points, "attributes": {"identity": identity}}
            annotations.append({"image_id": n, "category_id": 1, **about})
        rgb = np.array([FLOOR, YELLOW, BLUE, RED], float)[labels] * light
        noisy = rgb[..., ::-1] + np.random.default_rng(n).normal(0, 4, rgb.shape)
        cv2.imwrite(str(tmp_path / f"{n}.png"), np.clip(np.rint(noisy), 0, 255).astype(np.uint8))
        images.append({"id": n, "file_name": f"{n}.png"})
    categories = [{"id": 1, "name": "team", "keypoints": keypoints}]
    coco = {"images": images, "annotations": annotations, "categories": categories}
    (tmp_path / "coco.json").write_text(json.dumps(coco))
    (tmp_path / "robot.yaml").write_text(ROBOT)
    (tmp_path / "robots.yaml").write_text(ROBOTS)
    return tmp_path
