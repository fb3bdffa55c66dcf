"""Marked regions from COCO files: boxes, polygons, and what is wrong with a file."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.learned.regions import load_regions


def coco(folder: Path, *annotations: dict[str, Any], image: np.ndarray | None = None) -> Path:
    if image is not None:
        cv2.imwrite(str(folder / "a.png"), image)
    content = {
        "images": [{"id": 7, "file_name": "a.png"}, {"id": 8, "file_name": "b.png"}],
        "categories": [{"id": 1, "name": "red"}, {"id": 2, "name": "floor"}],
        "annotations": [{"image_id": 7, "category_id": 1, **a} for a in annotations],
    }
    path = folder / "regions.json"
    path.write_text(json.dumps(content))
    return path


def test_boxes_and_polygons_mark_their_pixels(tmp_path: Path) -> None:
    image = np.random.default_rng(0).integers(0, 255, (20, 30, 3), dtype=np.uint8)
    polygon = {"segmentation": [[20, 2, 25, 2, 25, 9, 20, 9]], "bbox": [0, 0, 30, 20], "category_id": 2}
    marked = load_regions([coco(tmp_path, {"bbox": [3, 4, 5, 6]}, polygon, image=image)])
    assert [m.path.name for m in marked] == ["a.png"]  # nothing is marked in the other
    read, labels = marked[0].read({"red": 1, "floor": 2}, 255)
    expected = np.full((20, 30), 255, np.uint8)
    expected[4:10, 3:8] = 1
    expected[2:10, 20:26] = 2
    assert np.array_equal(labels, expected)
    assert np.array_equal(read, image)


@pytest.mark.parametrize("size", [(5, 14), (7, 20), (24, 76)])
def test_an_outline_marks_the_pixels_whose_middles_it_holds(tmp_path: Path, size: tuple[int, int]) -> None:
    """Not all that it touches: of small patches that is a fourth more, of which a class would learn what is beside."""
    corners = cv2.boxPoints(((48.3, 45.6), size, 23.0))
    polygon = {"segmentation": [corners.astype(float).ravel().tolist()], "category_id": 2}
    (marked,) = load_regions([coco(tmp_path, polygon, image=np.zeros((90, 100, 3), np.uint8))])
    labels = marked.read({"red": 1, "floor": 2}, 255)[1]
    assert np.count_nonzero((labels == 2) != held(corners)) <= 1
    assert np.count_nonzero(labels == 2) == pytest.approx(size[0] * size[1], rel=0.06)


def held(corners: np.ndarray) -> np.ndarray:
    """(90, 100) pixels whose middles an outline holds."""
    inside = [[cv2.pointPolygonTest(corners, (x, y), measureDist=False) >= 0 for x in range(100)] for y in range(90)]
    return np.array(inside)


@pytest.mark.parametrize("width", [1.0, 1.7, 3.0])
def test_what_is_cut_out_of_an_outline_is_not_marked(tmp_path: Path, width: float) -> None:
    cut = [
        (10.3, 10.2),
        (40.4, 10.2),
        (40.4, 20.1),
        (20.2, 20.1),
        (20.2, 20.1 + width),
        (40.4, 20.1 + width),
        (40.4, 60),
        (10.3, 60),
    ]
    polygon = {"segmentation": [np.ravel(cut).tolist()], "category_id": 2}
    (marked,) = load_regions([coco(tmp_path, polygon, image=np.zeros((90, 100, 3), np.uint8))])
    labels = marked.read({"red": 1, "floor": 2}, 255)[1]
    assert np.array_equal(labels == 2, held(np.array(cut, np.float32)))


@pytest.mark.parametrize(
    "annotation, words",
    [
        ({}, r"annotations\[0\]: has neither a polygon"),
        ({"segmentation": [[1, 2, 3, 4]]}, r"segmentation\[0\]: must be x, y of three"),
        ({"bbox": [1, 2, 3]}, "bbox: must be 4 numbers"),
        ({"bbox": [1, 2, 3, 4], "category_id": 9}, "category_id: there is no category 9"),
        ({"bbox": [1, 2, 3, 4], "image_id": 9}, "image_id: there is no image 9"),
        ({"segmentation": {"counts": "abc", "size": [2, 2]}}, "segmentation: is a run-length mask, which is not read"),
    ],
)
def test_a_region_that_makes_no_sense_is_refused(tmp_path: Path, annotation: dict[str, Any], words: str) -> None:
    with pytest.raises(ConfigError, match=words):
        load_regions([coco(tmp_path, annotation)])


def test_an_image_of_another_size_than_the_file_tells_is_refused(tmp_path: Path) -> None:
    path = coco(tmp_path, {"bbox": [0, 0, 2, 2]}, image=np.zeros((20, 30, 3), np.uint8))
    content = json.loads(path.read_text())
    content["images"][0] |= {"width": 20, "height": 30}
    path.write_text(json.dumps(content))
    with pytest.raises(ConfigError, match="a.png: has 30x20 pixels; its COCO file says 20x30"):
        load_regions([path])[0].read({"red": 1}, 255)


def test_an_image_that_is_not_there_or_has_no_colour_is_refused(tmp_path: Path) -> None:
    marked = load_regions([coco(tmp_path, {"bbox": [0, 0, 2, 2]})])
    with pytest.raises(ConfigError, match="a.png"):
        marked[0].read({"red": 1}, 255)
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((5, 5), np.uint8))
    with pytest.raises(ConfigError, match="a.png: a colour image is wanted"):
        marked[0].read({"red": 1}, 255)


def test_the_smaller_of_regions_goes_before_whatever_their_order_in_the_file(tmp_path: Path) -> None:
    inner, outer = {"bbox": [4, 5, 3, 3]}, {"bbox": [2, 3, 9, 9], "category_id": 2}
    (marked,) = load_regions([coco(tmp_path, inner, outer, image=np.zeros((20, 20, 3), np.uint8))])
    labels = marked.smaller_before().read({"red": 1, "floor": 2}, 255)[1]
    assert (labels[6, 5], labels[10, 10], labels[0, 0]) == (1, 2, 255)


def test_images_may_lie_in_another_folder(tmp_path: Path) -> None:
    path = coco(tmp_path, {"bbox": [0, 0, 2, 2]}, image=np.zeros((20, 20, 3), np.uint8))
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    assert [m.path.parent for folder in (None, elsewhere) for m in load_regions([path], folder)] == [
        tmp_path,
        elsewhere,
    ]
