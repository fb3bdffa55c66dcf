"""`artrec learn-colours` from the axes that were marked for training."""

from __future__ import annotations

import itertools
import json
import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from painted import (
    BLUE,
    FLOOR,
    RED,
    ROBOTS,
    drawn,
    labels_of,
    learn_robots,
    learned_image,
)

from artrec_ros.core.base.config import ClassConfig
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.tools.colour_report import size_lines
from artrec_ros.tools.colour_setup import load_colour_setup
from artrec_ros.tools.main import main


def test_axes_marked_for_training_are_enough(robots: Path, capsys) -> None:
    assert learn_robots(robots) == 0
    image = learned_image(robots)
    assert labels_of(image) == {"team": 1, "red": 3, "blue": 2}
    read = Segmenter(image).labels(cv2.imread(str(robots / "0.png")))
    assert [(read[y : y + 10, x : x + 10] == label).mean() > 0.95 for y, x, label in (
        (15, 13, 1), (35, 13, 3), (15, 53, 1), (35, 53, 2)
    )] == [True] * 4  # fmt: skip
    assert (read[50:] > 0).mean() < 0.01
    assert "unmarked" in capsys.readouterr().out


def test_classes_that_have_ranges_stay_as_they_are_and_are_no_background(robots: Path, capsys) -> None:
    def with_ranges(**ranges: str) -> None:
        text = ROBOTS
        for label, name in ((3, "red"), (2, "blue")):
            text = text.replace(f"{name}: {{label: {label}", f"{name}: {{label: {label}{ranges.get(name, '')}")
        (robots / "robots.yaml").write_text(text)

    with_ranges(blue=", hue: [200.0, 250.0], saturation: [0.4, 1.0]")
    assert learn_robots(robots) == 0
    image = learned_image(robots)
    assert labels_of(image) == {"blue": 2, "team": 1, "red": 3}
    assert (
        image.classes["blue"] == ClassConfig(2, hue=(200.0, 250.0), saturation=(0.4, 1.0)) and image.classes["red"].rgb
    )
    read = Segmenter(image).labels(cv2.imread(str(robots / "0.png")))
    assert [(read[y : y + 10, x : x + 10] == label).mean() > 0.95 for y, x, label in (
        (15, 13, 1), (35, 13, 3), (15, 53, 1), (35, 53, 2)
    )] == [True] * 4  # fmt: skip
    printed = capsys.readouterr()
    assert "Class 'blue' is not learned: its ranges are given, and stay" in printed.out + printed.err


def test_where_all_classes_have_ranges_nothing_is_learned(robots: Path, capsys) -> None:
    classes = {
        "red": "{label: 3, hue: [340, 20]}",
        "blue": "{label: 2, hue: [200, 250]}",
        "yellow": "{label: 1, hue: [40, 70]}",
    }
    text = ROBOTS.replace("[red, blue]", "[red, blue, yellow]").split("      red:")[0]
    (robots / "robots.yaml").write_text(text + "".join(f"      {name}: {cls}\n" for name, cls in classes.items()))
    assert learn_robots(robots) == 1 and "there is nothing to learn" in capsys.readouterr().err


def test_objects_that_nobody_marked_are_told_of_and_left_out_with_around(robots: Path, capsys) -> None:
    """Half of the robots are not annotated: their colours would be learned as background."""
    coco = json.loads((robots / "coco.json").read_text())
    kept = [a for n, a in enumerate(coco["annotations"]) if n in (0, 3, 4)]
    (robots / "coco.json").write_text(json.dumps({**coco, "annotations": kept}))
    assert learn_robots(robots) == 0
    assert "team takes" in (printed := capsys.readouterr().out) and "--around" in printed
    assert learn_robots(robots, "--around", "8") == 0
    assert "takes" not in capsys.readouterr().out


def test_a_region_inside_an_outline_is_no_part_of_the_class(robots: Path, capsys) -> None:
    """A grey plate on the red marker: without the region its colour would be the class'."""
    for n in range(3):
        image = cv2.imread(str(robots / f"{n}.png"))
        image[36:44, 14:22] = 90
        cv2.imwrite(str(robots / f"{n}.png"), image)
    drawn(robots, "qr", [14, 36, 8, 8])
    drawn(robots, "yard", [0, 8, 90, 52])  # which holds all markers, and is beneath them
    drawn(robots, "under", [16, 38, 2, 2])
    drawn(robots, "blanked", [10, 0, 20, 5])
    assert learn_robots(robots) == 0
    printed = capsys.readouterr()
    rows = {line.split()[0]: line for line in printed.out.splitlines() if "%" in line}
    assert "(background)" in rows["qr"] and "(background)" in rows["yard"]
    assert float(rows["red"].split()[2].rstrip("%")) > 99.0
    assert "'blanked' is left out: no pixel is its own" in printed.err and "'under'" not in printed.err
    read = Segmenter(learned_image(robots)).labels(cv2.imread(str(robots / "1.png")))
    assert not (read[37:43, 15:21] == 3).any() and (read[33:35, 12:24] == 3).all()


def test_what_is_taken_beside_markers_is_told_with_what_to_do(robots: Path, capsys) -> None:
    """A rim of a class' own colour around one robot's patches."""
    for n in range(3):
        picture = cv2.imread(str(robots / f"{n}.png"))
        picture[31:49, 5:10] = picture[31:49, 26:31] = picture[35, 13]
        cv2.imwrite(str(robots / f"{n}.png"), picture)
    assert learn_robots(robots) == 0
    printed = capsys.readouterr().out
    assert re.search(r"red takes \d+% of 'beside markers'.*a body of that size with a class of its own", printed)


@pytest.mark.parametrize(
    "arguments, words",
    [
        (["--params-file", "robots.yaml", "0.png"], "0.png: "),
        (["--params-file", "robots.yaml", ".", "--label-images", ".", "--around", "5"], "goes with --annotations"),
        (["--params-file", "robots.yaml", ".", "--label-images", ".", "--images", "."], "--images goes with"),
        (["--annotations", "coco.json"], "--classes: name the classes"),
        (
            ["--annotations", "coco.json", "--classes", "red=3", "--around", "5"],
            "goes with --annotations and --params-file",
        ),
        (["--annotations", "coco.json", "--params-file", "robots.yaml", "--around", "0"], "--around: 0.0"),
    ],
)
def test_options_that_do_not_go_together_are_told(robots, arguments, words, capsys, monkeypatch) -> None:
    monkeypatch.chdir(robots)
    assert main(["learn-colours", *arguments, "-o", "colours.yaml"]) == 1
    error = capsys.readouterr().err
    assert words in error and error.count("\n") == 1


def test_outlines_that_are_too_small_are_told_with_how_much(robots: Path, capsys) -> None:
    """In place of the advice to choose another colour: all that is painted reaches farther than the marked axes say."""
    px = 3
    for n in range(3):
        picture = cv2.imread(str(robots / f"{n}.png"))
        for x, y in itertools.product((10, 50), (12, 32)):
            patch = picture[y : y + 16, x : x + 16].copy()
            wide = cv2.copyMakeBorder(patch, px, px, px, px, cv2.BORDER_REFLECT)
            picture[y - px : y + 16 + px, x - px : x + 16 + px] = wide
        cv2.imwrite(str(robots / f"{n}.png"), picture)
    assert learn_robots(robots) == 0
    printed = capsys.readouterr().out
    told = {name: float(px) for name, px in re.findall(r"(\w+) goes on for ([0-9.]+) px", printed)}
    assert told == {name: pytest.approx(px, abs=0.6) for name in ("red", "blue")}  # the team's are closed in
    assert "px (0.0" in printed and not re.search("(red|blue) takes .*'beside markers'", printed)


def test_outlines_that_end_where_the_paint_does_are_not_told_too_small(robots: Path, capsys) -> None:
    assert learn_robots(robots) == 0
    assert "goes on for" not in capsys.readouterr().out


@pytest.mark.parametrize(("scale", "told"), [(900.0, False), (1100.0, True)])
def test_markers_that_are_larger_than_needed_are_told_once(robots: Path, scale: float, told: bool) -> None:
    setup = load_colour_setup([robots / "robots.yaml"], {})
    sides = [m.area**0.5 for target in setup.targets for m in target.model.markers.values()]
    scales = np.array([scale, 1.2 * scale]) * 0.08 / min(sides)
    assert sum("times smaller tell as much" in line for line in size_lines(setup, scales)) == told  # of 72 px, 88 px


LAMPS = """
format: artrec_object/1
name: team
markers: {{lamp: {{disc: {{radius: {}}}}}}}
components:
  red: {{required: true, label: 3, markers: {{lamp: {{pose: {{xyz: [0, 0, 0]}}}}}}}}
  blue: {{label: 2, markers: {{lamp: {{pose: {{xyz: [0.5, 0, 0]}}}}}}}}
"""


@pytest.mark.parametrize(("radius", "larger"), [(0.05, 3), (0.065, 1.5), (0.08, None)])
def test_outlines_that_the_object_file_has_large_enough_are_told_no_more(tmp_path, capsys, radius, larger) -> None:
    """Lamps shine 8 px far, and are marked 5 px far: what the file lacks is told, whatever the marks are."""
    keypoints = [f"{name}/lamp.{end}" for name in ("red", "blue") for end in ("tail", "head")]
    images, annotations = [], []
    for n in range(3):
        image = np.full((60, 100, 3), FLOOR[::-1], np.uint8)
        for x, colour in ((25, RED), (75, BLUE)):  # 100 px/m
            cv2.circle(image, (x, 30), 8, colour[::-1], cv2.FILLED)
        noise = np.random.default_rng(n).normal(0, 4, image.shape)
        cv2.imwrite(str(tmp_path / f"{n}.png"), np.clip(image + noise, 0, 255).astype(np.uint8))
        images.append({"id": n, "file_name": f"{n}.png"})
        points = [v for x in (20, 30, 70, 80) for v in (x, 30, 2)]
        annotations.append({"image_id": n, "category_id": 1, "keypoints": points})
    categories = [{"id": 1, "name": "team", "keypoints": keypoints}]
    coco = {"images": images, "annotations": annotations, "categories": categories}
    (tmp_path / "coco.json").write_text(json.dumps(coco))
    (tmp_path / "robot.yaml").write_text(LAMPS.format(radius))
    (tmp_path / "robots.yaml").write_text(ROBOTS)
    assert learn_robots(tmp_path) == 0
    told = re.findall(r"(\w+) goes on .* by ([0-9.]+) px \(0.0\d* m\) on each side", capsys.readouterr().out)
    wanted = [] if larger is None else [(name, pytest.approx(larger, abs=0.6)) for name in ("blue", "red")]
    assert sorted((name, float(px)) for name, px in told) == wanted
