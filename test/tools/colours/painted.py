"""Pictures in known colours, what is marked in them, and `artrec learn-colours` as users call it."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.tools.main import main

RED, BLUE, FLOOR = (200, 40, 45), (40, 65, 170), (120, 100, 80)

OBJECT = """
format: artrec_object/1
name: toy
markers: {dot: {disc: {radius: 0.05}}}
components: {base: {required: true, markers: {dot: {}}}}
"""

NODE = """
/**:
  ros__parameters:
    objects: [toy]
    toy: {object_file: toy.yaml, label: 3}
    image: {kind: labels, blank: [0, 0, 2, 2]}
"""


def picture(light: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """A red and a blue patch on a floor, with noise; and the labels."""
    labels = np.zeros((60, 90), np.uint8)
    labels[20:40, 10:30] = 3
    labels[20:40, 50:70] = 2
    rgb = np.array([FLOOR, FLOOR, BLUE, RED], float)[labels] * light
    noisy = rgb[..., ::-1] + np.random.default_rng(3).normal(0, 4, rgb.shape)
    return np.clip(np.rint(noisy), 0, 255).astype(np.uint8), labels


def learn(folder: Path, *arguments: str) -> int:
    return main(["learn-colours", *arguments, "--classes", "red=3", "blue=2", "-o", str(folder / "colours.yaml")])


def from_labels(folder: Path) -> list[str]:
    return [str(folder / "images"), "--label-images", str(folder / "labels")]


def from_regions(folder: Path) -> list[str]:
    return ["--annotations", str(folder / "images" / "regions.json")]


ROBOT = """
format: artrec_object/1
name: robot
markers: {square: {outline: [[0, 0], [0.2, 0], [0.2, 0.2], [0, 0.2]], axis: [[0, 0], [0.2, 0]]}}
components:
  ahead: {required: true, markers: {square: {}}}
  behind: {classes: {r: red, b: blue}, markers: {square: {}}}
identities: {crimson: {behind: r}, azure: {behind: b}}
"""

ROBOTS = """
/**:
  ros__parameters:
    objects: [team]
    team: {object_file: robot.yaml, label: 1}
    image:
      kind: colour
      blank: [0, 0, 90, 6]
      classes: [red, blue]
      red: {label: 3}
      blue: {label: 2}
"""

YELLOW = (220, 205, 60)


def learn_robots(folder: Path, *more: str) -> int:
    files = ["--annotations", str(folder / "coco.json"), "--params-file", str(folder / "robots.yaml")]
    return main(["learn-colours", *files, *more, "-o", str(folder / "colours.yaml")])


def learned_image(folder: Path) -> ImageConfig:
    """How images are read by the file that was written, beside the robots' own."""
    return load_parameters(folder / "robots.yaml", folder / "colours.yaml").image


def labels_of(image: ImageConfig) -> dict[str, int]:
    return {name: c.label for name, c in image.classes.items()}


def drawn(folder: Path, name: str, box: list[int]) -> None:
    """A box of a category of its own in each picture."""
    coco = json.loads((folder / "coco.json").read_text())
    number = len(coco["categories"]) + 1
    coco["categories"].append({"id": number, "name": name})
    coco["annotations"] += [{"image_id": n, "category_id": number, "bbox": box} for n in range(3)]
    (folder / "coco.json").write_text(json.dumps(coco))


def drawn_alone(folder: Path) -> None:
    """Boxes of the classes in place of axes."""
    coco = json.loads((folder / "coco.json").read_text())
    (folder / "coco.json").write_text(json.dumps({**coco, "annotations": [], "categories": []}))
    for name, box in (("team", [11, 13, 14, 14]), ("red", [11, 33, 14, 14]), ("blue", [51, 33, 14, 14])):
        drawn(folder, name, box)
