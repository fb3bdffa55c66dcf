"""`artrec learn-colours` as users call it: what it writes is a parameter file that tells the classes."""

from __future__ import annotations

import itertools
import json
import os
import re
from pathlib import Path

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.config import ClassConfig, ImageConfig
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.learning.colour_learning import Learned
from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.io.sources.opening import SourceOptions, open_sources
from artrec_ros.tools import colour_samples
from artrec_ros.tools.colour_report import report, scale_limits, scale_line
from artrec_ros.tools.main import main

ROOT = Path(__file__).resolve().parents[2]
AIBO = Path(os.environ.get("ARTREC_SHARED", ROOT.parent / "shared")) / "data" / "aibo_lowres"
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


def learn(folder: Path, *arguments: str) -> int:
    return main(["learn-colours", *arguments, "--classes", "red=3", "blue=2", "-o", str(folder / "colours.yaml")])


def from_labels(folder: Path) -> list[str]:
    return [str(folder / "images"), "--label-images", str(folder / "labels")]


def from_regions(folder: Path) -> list[str]:
    return ["--annotations", str(folder / "images" / "regions.json")]


@pytest.mark.parametrize("way", [from_labels, from_regions])
def test_the_file_beside_the_nodes_own_tells_the_classes_in_the_shade(folder: Path, way, capsys) -> None:
    assert learn(folder, *way(folder)) == 0
    setup = load_parameters(folder / "node.yaml", folder / "colours.yaml")
    assert setup.image.kind == "colour" and setup.image.blank == (0, 0, 2, 2)
    assert {name: c.label for name, c in setup.image.classes.items()} == {"red": 3, "blue": 2}
    assert len(setup.image.background) == 3
    image, labels = picture(light=0.5)
    assert (Segmenter(setup.image).labels(image) == labels).mean() > 0.995
    printed = capsys.readouterr().out
    assert "background: " in printed and f"Wrote {folder / 'colours.yaml'}: 2 classes" in printed


def test_images_without_labels_are_passed_over(folder: Path, capsys) -> None:
    (folder / "labels" / "1.png").unlink()
    assert learn(folder, *from_labels(folder)) == 0
    counts = [line.split()[1] for line in capsys.readouterr().out.splitlines() if line.startswith("red ")]
    assert counts == [str(2 * 18 * 18)]


def test_what_a_bag_lacks_is_told_once(folder: Path, capsys) -> None:
    image, labels = picture()
    with BagWriter(folder / "bag") as writer:
        for n in range(40):
            writer.write_image("/eye/colour", n, "eye", image)
            writer.write_image("/eye/labels", n, "eye", labels)
    file = folder / "bag/bag.mcap"
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    assert learn(folder, str(folder / "bag")) == 0
    assert capsys.readouterr().err.count(f"{file}: it ends in the middle") == 1


@pytest.mark.parametrize(
    "arguments, words",
    [
        ([], "give either SOURCE"),
        (["images", "--annotations", "images/regions.json"], "give either SOURCE"),
        (["images", "--label-images", "labels", "--every", "0"], "--every: 0"),
        (["images", "--label-images", "images"], "a colour image and a label image of one size"),
        (["images", "--label-images", "nowhere"], "class 'red': 0 pixels"),
        (["images"], "images: is no bag; name the folder of its label images with --label-images"),
    ],
)
def test_what_cannot_be_done_is_told_in_one_line(folder, arguments, words, capsys, monkeypatch) -> None:
    monkeypatch.chdir(folder)
    assert learn(folder, *arguments) == 1
    error = capsys.readouterr().err
    assert words in error and error.count("\n") == 1
    assert not (folder / "colours.yaml").exists()


def test_a_class_that_nobody_marked_names_those_that_are_marked(folder: Path, capsys) -> None:
    regions = str(folder / "images" / "regions.json")
    assert main(["learn-colours", "--annotations", regions, "--classes", "blu=2", "-o", str(folder / "c.yaml")]) == 1
    told = capsys.readouterr().err
    assert "class 'blu': 0 pixels show it, at least" in told and "there are also" in told
    assert all(name in told.partition("there are also")[2] for name in ("red", "blue", "floor"))


def test_reading_shows_how_far_it_is(folder: Path, monkeypatch) -> None:
    read = []
    monkeypatch.setattr(colour_samples, "_READ", lambda pairs: (read.append(1) or pair for pair in pairs))
    assert learn(folder, str(folder / "images"), "--label-images", str(folder / "labels")) == 0
    assert len(read) == 3


@pytest.mark.parametrize(
    "classes, code, words",
    [
        (["red=3", "blue=2", "red=4"], 1, "--classes: red is given twice; a class has one label"),
        (["background=3"], 2, "'background' is the name of a parameter"),
        *(([text], 2, "is no NAME=LABEL") for text in ("red", "red=0", "red=300", "3=3", "red=x")),
    ],
)
def test_a_class_is_a_name_and_a_label(folder: Path, classes, code: int, words: str, capsys) -> None:
    assert main(["learn-colours", *from_regions(folder), "--classes", *classes, "-o", str(folder / "c.yaml")]) == code
    assert words in capsys.readouterr().err


def frames(topic: str) -> dict[int, np.ndarray]:
    with open_sources([AIBO / "bag"], SourceOptions(topic=topic)) as source:
        return {f.stamp_ns: f.image for f in source if f.image is not None}


@pytest.mark.skipif(not AIBO.is_dir(), reason="the rendered robots are not here")
def test_the_shipped_colours_find_more_of_the_markers_than_the_recorded_labels() -> None:
    """At the centres of markers that are wholly in view; the colours were learned from frames 0, 3, 6, ..."""
    segmenter = Segmenter(load_parameters(ROOT / "config" / "aibo_colour.yaml").image)
    colours, recorded = frames("/camera/image_color/compressed"), frames("/camera/segmentation")
    truth = [json.loads(line) for line in (AIBO / "truth.jsonl").read_text().splitlines()]
    hits = []
    for frame in (f for i, f in enumerate(truth) if i % 3):
        own, theirs = segmenter.labels(colours[frame["stamp_ns"]]), recorded[frame["stamp_ns"]]
        for found in frame["objects"]:
            for marker in found["components"].values():
                if marker["full_px"] >= 25 and marker["visible_px"] >= 0.9 * marker["full_px"]:
                    x, y = np.rint(marker["centre"]).astype(int)
                    hits.append((own[y, x] == found["team"], theirs[y, x] == found["team"]))
    ours, recorded_share = np.mean(hits, axis=0)
    assert len(hits) > 100
    assert ours > 0.96 and ours > recorded_share + 0.02


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


def learn_robots(folder: Path, *more: str) -> int:
    files = ["--annotations", str(folder / "coco.json"), "--params-file", str(folder / "robots.yaml")]
    return main(["learn-colours", *files, *more, "-o", str(folder / "colours.yaml")])


def learned_image(folder: Path) -> ImageConfig:
    """How images are read by the file that was written, beside the robots' own."""
    return load_parameters(folder / "robots.yaml", folder / "colours.yaml").image


def labels_of(image: ImageConfig) -> dict[str, int]:
    return {name: c.label for name, c in image.classes.items()}


def with_image(folder: Path, **values: float) -> None:
    """The robots' parameter file with more of the section `image`."""
    more = "".join(f"\n      {name}: {value}" for name, value in values.items())
    (folder / "robots.yaml").write_text(ROBOTS.replace("kind: colour", f"kind: colour{more}"))


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


def with_body(folder: Path, pose: str) -> None:
    """The robots' floor-coloured plates as bodies of a class of their own, which no marker has."""
    body = ", body: {label: plate, boxes: [{xyz: [0.1, 0.1, -0.02], size: [0.3, 0.3, 0.02]}]}"
    text = ROBOT.replace("markers: {square: {}}}", f"markers: {{square: {pose}}}{body}}}", 1)
    (folder / "robot.yaml").write_text(text.replace("{square: {}}", f"{{square: {pose}}}"))
    text = ROBOTS.replace("[red, blue]", "[red, blue, plate]").replace("blue: {", "plate: {label: 5}\n      blue: {")
    (folder / "robots.yaml").write_text(text)


def test_a_class_of_bodies_is_learned_where_they_lie_flat(robots: Path, capsys) -> None:
    with_body(robots, "{pose: {xyz: [0, 0, 0]}}")
    assert learn_robots(robots) == 0
    assert labels_of(learned_image(robots)) == {"team": 1, "plate": 5, "red": 3, "blue": 2}
    assert "is not learned" not in capsys.readouterr().err


def test_a_body_of_which_nothing_shows_is_passed_over_with_a_word(robots: Path, capsys) -> None:
    with_body(robots, "{pose: {xyz: [0, 0, 0]}}")
    text = (robots / "robot.yaml").read_text()
    (robots / "robot.yaml").write_text(text.replace("size: [0.3, 0.3, 0.02]", "size: [0.2, 0.2, 0.02]"))
    assert learn_robots(robots) == 0
    assert "Class 'plate' (label 5) is not learned: too little of it shows" in capsys.readouterr().err


def test_a_class_of_other_bodies_is_learned_where_somebody_drew_it(robots: Path, capsys) -> None:
    with_body(robots, "{}")
    assert learn_robots(robots) == 0
    assert "Class 'plate' (label 5) is not learned: it is of bodies alone" in capsys.readouterr().err
    with pytest.raises(ConfigError, match="'plate' is not in image.classes of the last file"):
        learned_image(robots)
    drawn(robots, "plate", [8, 50, 30, 8])
    assert learn_robots(robots) == 0
    assert "plate" in learned_image(robots).classes
    assert "is not learned" not in capsys.readouterr().err


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
    assert "(background)" in rows["qr"] and "(background)" in rows["yard"] and "100.0%" in rows["red"]
    assert "'blanked' is left out: no pixel is its own" in printed.err and "'under'" not in printed.err
    read = Segmenter(learned_image(robots)).labels(cv2.imread(str(robots / "1.png")))
    assert not (read[37:43, 15:21] == 3).any() and (read[33:35, 12:24] == 3).all()


def test_label_images_take_names_labels_and_gamma_of_the_parameter_file(robots: Path, capsys) -> None:
    (robots / "images").mkdir()
    (robots / "labels").mkdir()
    for n in range(3):
        labels = np.zeros((60, 90), np.uint8)
        labels[12:28, 10:26] = labels[12:28, 50:66] = 1
        labels[32:48, 10:26], labels[32:48, 50:66] = 3, 2
        (robots / f"{n}.png").rename(robots / "images" / f"{n}.png")
        cv2.imwrite(str(robots / "labels" / f"{n}.png"), labels)
    with_image(robots, gamma=1.8, smoothing_px=0.7)
    sources = [str(robots / "images"), "--label-images", str(robots / "labels")]
    files = ["--params-file", str(robots / "robots.yaml"), "-o", str(robots / "colours.yaml")]
    assert main(["learn-colours", *sources, *files]) == 0
    image = learned_image(robots)
    assert labels_of(image) == {"team": 1, "red": 3, "blue": 2}
    assert (image.gamma, image.smoothing_px, image.blur_px) == (1.8, 0.7, 0)
    assert "scale: " not in capsys.readouterr().out


def test_drawn_regions_keep_the_gamma_of_the_parameter_file(robots: Path, capsys) -> None:
    drawn_alone(robots)
    with_image(robots, gamma=1.8, smoothing_px=0.7)
    assert learn_robots(robots) == 0
    assert learned_image(robots).gamma == 1.8


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


def test_what_was_decided_about_sharpening_goes_before_an_earlier_file(robots: Path) -> None:
    with_image(robots, sharpen_px=3)
    assert learn_robots(robots) == 0
    assert learned_image(robots).sharpen_px in (0, 1)


def test_a_blurred_lens_is_measured_and_undone_before_colours_are_learned(robots: Path, capsys) -> None:
    """And what an earlier file says of it goes: what was sharp is told to be so, too."""
    with_image(robots, blur_px=3)
    assert learn_robots(robots) == 0
    assert "blur_px: 0\n" in capsys.readouterr().out
    assert learned_image(robots).blur_px == 0
    for n in range(3):
        path = str(robots / f"{n}.png")
        blurred = cv2.GaussianBlur(cv2.imread(path).astype(np.float32), (0, 0), 1.5)
        noisy = blurred + np.random.default_rng(n).normal(0, 2, blurred.shape)
        cv2.imwrite(path, np.clip(np.rint(noisy), 0, 255).astype(np.uint8))
    assert learn_robots(robots) == 0
    image = learned_image(robots)
    assert image.blur_px == pytest.approx(1.5, rel=0.2)
    read = Segmenter(image).labels(cv2.imread(str(robots / "0.png")))
    assert (read[12:28, 10:26] == 1).mean() > 0.9 and (read[32:48, 50:66] == 2).mean() > 0.9


def test_the_scale_of_what_was_marked_is_told_with_limits(robots: Path, capsys) -> None:
    """Axes of 16 px, 0.2 m long."""
    assert learn_robots(robots) == 0
    (line,) = [text for text in capsys.readouterr().out.splitlines() if text.startswith("scale: ")]
    scale = 16 / 0.2
    told = [float(number) for number in re.findall(r"[0-9.]+(?= |$)", line)]
    count, wider = told.pop(2), 1.25 * 2 ** (1 / 6)
    assert count == 6 and told == pytest.approx([scale, scale, scale / wider, scale * wider], rel=1e-3)


def test_colours_go_before_those_of_an_earlier_file_with_other_lights(robots: Path) -> None:
    text = (robots / "robots.yaml").read_text()
    earlier = "blue: {label: 2, rgb: [1, 2, 3, 4, 5, 6], light: [0.5, 1.5, 0.6, 1.2]}"
    (robots / "robots.yaml").write_text(text.replace("blue: {label: 2}", earlier))
    assert learn_robots(robots) == 0
    assert learned_image(robots).classes["blue"].label == 2


LEAVE_OUT, KEEP = "Leave the label out of the body", "green takes 25% of it: mark green well inside its edges"


@pytest.mark.parametrize(
    ("right", "unknown", "told"),
    [(0.6, 0.15, KEEP), (0.75, 0.2, None), (0.5, 0.5, LEAVE_OUT), (0.45, 0.3, LEAVE_OUT)],
)
def test_a_body_whose_class_is_badly_told_is_named_with_what_to_do(
    right: float, unknown: float, told: str | None
) -> None:
    image = ImageConfig(kind="colour", classes={"plate": ClassConfig(5, (40, 130, 40))})
    shares = {"plate": {"plate": right, "unknown": unknown, "green": 1 - right - unknown}}
    learned = Learned(image, shares, {"plate": 100})
    lines = [line for line in report(learned, ["plate"]) if "body's class 'plate'" in line]
    assert len(lines) == (told is not None) and all(str(told) in line for line in lines)
    assert all(("Leave the label in the body" in line) == (told == KEEP) for line in lines)
    assert not any("body's class" in line for line in report(learned))  # as a marker's it is another matter


def test_colours_are_learned_of_images_as_they_will_be_read(robots: Path) -> None:
    """Pixels of a palette, as a GIF has them, are of colours that no class has; smoothed they are of the classes'."""
    ground = np.indices((60, 90)).sum(axis=0)[..., None] % 2 * np.array([2, 0, -2]) + np.array([-1, 0, 1])
    for n in range(3):
        image = cv2.imread(str(robots / f"{n}.png")).astype(int)
        cv2.imwrite(str(robots / f"{n}.png"), np.clip(image + 70 * ground, 0, 255).astype(np.uint8))
    with_image(robots, smoothing_px=1.5)
    assert learn_robots(robots) == 0
    with_image(robots)  # the colours' file tells of it, as of all by which they are learned
    image = learned_image(robots)
    assert image.smoothing_px == 1.5
    read = Segmenter(image).labels(cv2.imread(str(robots / "0.png")))
    shares = [(read[y : y + 10, x : x + 10] == label).mean() for y, x, label in ((15, 13, 1), (35, 13, 3), (35, 53, 2))]
    assert min(shares) > 0.95, shares


def test_colours_are_learned_of_images_with_the_gain_of_the_parameter_file(robots: Path) -> None:
    """One of the images is dark, and all are read alike: by the colours' file, without the other one."""
    image = cv2.imread(str(robots / "1.png"))
    dark = cv2.convertScaleAbs(image, alpha=0.2)
    cv2.imwrite(str(robots / "2.png"), dark)
    with_image(robots, gain_percentile=95.0, gain_level=0.7, gain_limit=20.0)
    assert learn_robots(robots) == 0
    with_image(robots)
    learned = learned_image(robots)
    assert (learned.gain_percentile, learned.gain_level, learned.gain_limit) == (95, 0.7, 20)
    light, night = (Segmenter(learned).labels(seen) for seen in (image, dark))
    assert {1, 2, 3} <= {*np.unique(light).tolist()} and np.mean(light == night) > 0.98


def test_a_parameter_file_without_objects_tells_of_the_camera(robots: Path, capsys) -> None:
    drawn_alone(robots)
    camera = robots / "camera_params.yaml"
    camera.write_text("/**:\n  ros__parameters:\n    image: {kind: colour, gamma: 1.8, gain_percentile: 95.0}\n")
    marks, out = ["--annotations", str(robots / "coco.json")], ["-o", str(robots / "colours.yaml")]
    files = [*marks, "--params-file", str(camera), *out]
    assert main(["learn-colours", *files, "--classes", "team=1", "red=3", "blue=2"]) == 0
    image = learned_image(robots)
    assert (image.gamma, image.gain_percentile, set(image.classes)) == (1.8, 95.0, {"team", "red", "blue"})
    assert main(["learn-colours", *files]) != 0
    assert "objects" in capsys.readouterr().err


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


@pytest.mark.parametrize(
    ("scales", "low", "high", "said"),
    [
        ([600.0], 240.0, 1500.0, "rests on 1 object (mark nearer and farther ones); much wider"),
        ([600.0, 600.0], 600 / 1.25 / 2**0.5, 600 * 1.25 * 2**0.5, "rests on 2 objects"),
        ([300.0, 600.0], 120.0, 1500.0, "rests on 2 objects"),
        ([500.0] * 9 + [600.0], 400.0, 750.0, "where marked; a quarter wider"),
    ],
)
def test_limits_of_the_scale_are_the_wider_the_fewer_objects_they_rest_on(
    scales: list[float], low: float, high: float, said: str
) -> None:
    assert scale_limits(np.array(scales)) == pytest.approx((low, high))
    assert said in scale_line(np.array(scales))
