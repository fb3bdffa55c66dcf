"""Annotations that are written are read as they were."""

from __future__ import annotations

from pathlib import Path

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError, SourceError
from artrec_ros.io.learned.annotation_writer import save_coco
from artrec_ros.io.learned.annotations import MACHINE, MADE_BY, AnnotatedObject, load_coco
from artrec_ros.io.truth.from_coco import load_coco_truth

KEYPOINTS = ("base/disc.tail", "base/disc.head", "arm/bar.tail", "arm/bar.head")


def objects(folder: Path, rng: np.random.Generator) -> list[AnnotatedObject]:
    found = []
    for n in range(12):
        shown = [name for name in KEYPOINTS if rng.random() < 0.8] or [KEYPOINTS[0]]
        points = {name: np.round(rng.uniform(-5, 640, 2), 2) for name in shown}
        attributes = {"identity": "gr"} if n % 2 else {MADE_BY: MACHINE} if n % 3 else {}
        image = folder / "pictures" / f"{n // 3}.png"
        found.append(AnnotatedObject(image, f"kind_{n % 2}", "", points, (640, 480), attributes))
    return found


def test_what_is_written_is_read(tmp_path: Path) -> None:
    written = objects(tmp_path, np.random.default_rng(5))
    path = tmp_path / "marks" / "annotations.json"
    save_coco(path, {"kind_0": KEYPOINTS, "kind_1": KEYPOINTS}, written, [tmp_path / "pictures/9.png"])
    read = load_coco([path])
    assert dict(read.categories) == {"kind_0": KEYPOINTS, "kind_1": KEYPOINTS}
    for before, after in zip(written, read.objects, strict=True):
        assert after.image.resolve() == before.image and after.category == before.category and after.size == before.size
        assert after.attributes == before.attributes
        assert after.by_machine == before.by_machine and sorted(after.points) == sorted(before.points)
        for name, place in before.points.items():
            np.testing.assert_array_equal(after.points[name], place)


def test_an_object_of_which_nothing_is_marked_is_kept(tmp_path: Path) -> None:
    bare = AnnotatedObject(tmp_path / "0.png", "lamp", "", {})
    save_coco(tmp_path / "a.json", {"lamp": KEYPOINTS}, [bare])
    (back,) = load_coco([tmp_path / "a.json"]).objects
    assert back.category == "lamp" and not back.points


def test_images_of_the_machine_are_no_truth(tmp_path: Path) -> None:
    points = {name: np.array([10.0 * n, 5.0]) for n, name in enumerate(KEYPOINTS)}
    people = AnnotatedObject(tmp_path / "a.png", "kind", "", points)
    machine = AnnotatedObject(tmp_path / "b.png", "kind", "", points, attributes={MADE_BY: MACHINE})
    beside = AnnotatedObject(tmp_path / "b.png", "kind", "", points)
    path = tmp_path / "annotations.json"
    save_coco(path, {"kind": KEYPOINTS}, [people, machine, beside], [tmp_path / "c.png"])
    truth = load_coco_truth(path)
    assert set(truth.frames) == {"a.png", "c.png"} and truth.left_out == 1
    save_coco(path, {"kind": KEYPOINTS}, [machine])
    with pytest.raises(SourceError, match=f"{MADE_BY}: {MACHINE}"):
        load_coco_truth(path)


def test_a_folder_that_cannot_be_is_told(tmp_path: Path) -> None:
    cv2.imwrite(str(tmp_path / "file.png"), np.zeros((3, 3), np.uint8))
    with pytest.raises(ConfigError, match="cannot be written"):
        save_coco(tmp_path / "file.png" / "annotations.json", {"kind": KEYPOINTS}, [])
