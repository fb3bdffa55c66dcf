"""`artrec learn-colours` of a class that several markers show, of which one has few pixels."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
from painted import RED, labels_of, learned_image

from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.tools.main import main

SIZE, PICTURES = (180, 120), 4
LARGE, SMALL = (10, 10, 100, 80), (140, 50, 16, 6)  # x, y, width, height

OBJECT = """
format: artrec_object/1
name: {name}
markers: {{patch: {{outline: [[0, 0], [{x}, 0], [{x}, {y}], [0, {y}]], axis: [[0, 0], [{x}, 0]]}}}}
components: {{top: {{required: true, markers: {{patch: {{}}}}}}}}
"""

ROBOTS = """
/**:
  ros__parameters:
    objects: [cross, pen]
    cross: {object_file: cross.yaml, label: 1}
    pen: {object_file: pen.yaml, label: 1}
    image: {kind: colour, classes: [red], red: {label: 1}}
"""


def write(folder: Path, pale: tuple[int, int, int], floor: tuple[int, int, int]) -> None:
    """A large and a small object of one class, whose colours differ."""
    images, annotations, boxes = [], [], {"cross": LARGE, "pen": SMALL}
    for name, (_, _, width, height) in boxes.items():
        (folder / f"{name}.yaml").write_text(OBJECT.format(name=name, x=width, y=height))
    (folder / "robots.yaml").write_text(ROBOTS)
    for n in range(PICTURES):
        rgb = np.full((SIZE[1], SIZE[0], 3), floor, float)
        for number, (colour, (x, y, width, height)) in enumerate(
            zip((RED, pale), boxes.values(), strict=True), start=1
        ):
            rgb[y : y + height, x : x + width] = colour
            points = [x, y + height - 1, 2, x + width - 1, y + height - 1, 2]
            annotations.append({"image_id": n, "category_id": number, "keypoints": points})
        noisy = rgb[..., ::-1] + np.random.default_rng(n).normal(0, 6, rgb.shape)
        cv2.imwrite(str(folder / f"{n}.png"), np.clip(np.rint(noisy), 0, 255).astype(np.uint8))
        images.append({"id": n, "file_name": f"{n}.png"})
    keypoints = ["top/patch.tail", "top/patch.head"]
    categories = [{"id": n, "name": name, "keypoints": keypoints} for n, name in enumerate(boxes, start=1)]
    coco = {"images": images, "annotations": annotations, "categories": categories}
    (folder / "coco.json").write_text(json.dumps(coco))


def learn(folder: Path) -> int:
    files = ["--annotations", str(folder / "coco.json"), "--params-file", str(folder / "robots.yaml")]
    return main(["learn-colours", *files, "-o", str(folder / "colours.yaml")])


def share(folder: Path, box: tuple[int, int, int, int]) -> float:
    """Of a box, what is told as the class."""
    x, y, width, height = box
    image = learned_image(folder)
    read = Segmenter(image).labels(cv2.imread(str(folder / "0.png")))
    return float((read[y : y + height, x : x + width] == labels_of(image)["red"]).mean())


def test_a_small_marker_counts_as_much_as_a_large_one_of_its_class(tmp_path: Path, capsys) -> None:
    """By pixels it is a fortieth of the class, and the floor's rather."""
    write(tmp_path, (215, 130, 115), (180, 150, 135))
    assert learn(tmp_path) == 0
    assert share(tmp_path, LARGE) > 0.95 and share(tmp_path, SMALL) > 0.8
    printed = capsys.readouterr().out
    (row,) = (line.split() for line in printed.splitlines() if line.startswith("red "))
    assert int(row[1]) < 5000 and "too little" not in printed  # pixels that were seen, however they count


def test_a_marker_that_is_lost_beside_others_of_its_class_is_told_with_what_to_do(tmp_path: Path, capsys) -> None:
    """It is as like the floor as the class: nothing that is learned of both helps."""
    write(tmp_path, (200, 150, 130), (185, 155, 140))
    assert learn(tmp_path) == 0
    (line,) = (line for line in capsys.readouterr().out.splitlines() if "too little" in line)
    assert line.startswith("pen: top/patch: 0% told as red") and "a class of its own" in line
    assert share(tmp_path, LARGE) > 0.95
