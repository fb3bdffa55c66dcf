"""`artrec learn-colours` as users call it: what it writes is a parameter file that tells the classes."""

from __future__ import annotations

import json
import os
from pathlib import Path

import cv2
import numpy as np
import pytest
from painted import (
    RED,
    from_labels,
    from_regions,
    learn,
    picture,
)

from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.io.sources.opening import SourceOptions, open_sources
from artrec_ros.tools import colour_samples
from artrec_ros.tools.main import main

ROOT = Path(__file__).resolve().parents[3]

AIBO = Path(os.environ.get("ARTREC_SHARED", ROOT.parent / "shared")) / "data" / "aibo_lowres"


@pytest.mark.parametrize("way", [from_labels, from_regions])
def test_the_file_beside_the_nodes_own_tells_the_classes_in_the_shade(folder: Path, way, capsys) -> None:
    assert learn(folder, *way(folder)) == 0
    setup = load_parameters(folder / "node.yaml", folder / "colours.yaml")
    assert setup.image.kind == "colour" and setup.image.blank == (0, 0, 2, 2)
    assert {name: c.label for name, c in setup.image.classes.items()} == {"red": 3, "blue": 2}
    assert len(setup.image.background) == 3
    image, labels = picture(light=0.5)
    assert (Segmenter(setup.image).labels(image) == labels).mean() > 0.99
    printed = capsys.readouterr().out
    assert "background: " in printed and f"Wrote {folder / 'colours.yaml'}: 2 classes" in printed


def test_that_label_images_do_not_tell_gamma_is_told_where_nobody_gave_it(folder: Path, capsys) -> None:
    assert learn(folder, *from_labels(folder)) == 0
    assert "image.gamma is taken to be 1" in capsys.readouterr().err
    (folder / "gamma.yaml").write_text("/**: {ros__parameters: {image: {gamma: 2.2}}}")
    assert learn(folder, *from_labels(folder), "--params-file", str(folder / "gamma.yaml")) == 0
    assert "image.gamma" not in capsys.readouterr().err
    assert "gamma: 2.2" in (folder / "colours.yaml").read_text()


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
        (
            ["images", "--label-images", "nowhere"],
            "nowhere holds no label image that is named like one of 3 frames",
        ),
        (["images"], "images: is no bag; name the folder of its label images with --label-images"),
    ],
)
def test_what_cannot_be_done_is_told_in_one_line(folder, arguments, words, capsys, monkeypatch) -> None:
    monkeypatch.chdir(folder)
    assert learn(folder, *arguments) == 1
    error = capsys.readouterr().err
    assert words in error and error.count("\n") == 1
    assert not (folder / "colours.yaml").exists()


def film_of(path: Path, count: int) -> Path:
    image = picture()[0]
    writer = cv2.VideoWriter(str(path), cv2.VideoWriter.fourcc(*"MJPG"), 10.0, image.shape[1::-1])
    for _ in range(count):
        writer.write(image)
    writer.release()
    return path


def test_colours_are_learned_from_a_video_and_label_images_of_some_of_its_frames(folder: Path, capsys) -> None:
    film = film_of(folder / "my.film.avi", 3)
    assert learn(folder, str(film)) == 1
    told = capsys.readouterr().err
    assert "a video has no label images; name a folder" in told and "--label-images DIR (my.film_000000.png" in told
    assert "--annotations" in told and told.count("\n") == 1
    (folder / "my").mkdir()
    assert learn(folder, str(film), "--label-images", str(folder / "my")) == 1
    assert "named like one of 3 frames, such as my.film_000000.png\n" in capsys.readouterr().err
    (folder / "labels" / "0.png").rename(folder / "my" / "my.film_000001.png")
    assert learn(folder, str(film), "--label-images", str(folder / "my")) == 0
    assert load_parameters(folder / "colours.yaml", folder / "node.yaml").image.classes.keys() == {"red", "blue"}


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


@pytest.mark.parametrize(
    ("over", "said"),
    [
        ([1], "Most of that lies in 1.png [0, 44, 90, 16] (x, y, width, height): look whether something of its colour"),
        ([0, 1, 2], "As marked, it is too like: choose another colour"),
    ],
)
def test_where_one_box_holds_most_of_what_is_taken_it_is_named(folder: Path, over: list[int], said, capsys) -> None:
    """A box of floor that is drawn over something red makes no red floor."""
    for n in over:
        image = cv2.imread(str(folder / "images" / f"{n}.png"))
        image[48:56, 20:40] = image[26:34, 10:30]
        cv2.imwrite(str(folder / "images" / f"{n}.png"), image)
    assert learn(folder, *from_regions(folder)) == 0
    (line,) = [line for line in capsys.readouterr().out.splitlines() if line.startswith("red takes")]
    assert f"of 'floor'. {said}" in line and line.endswith("or lower image.red.spread (0.08)")


@pytest.mark.parametrize("way", [from_labels, from_regions])
@pytest.mark.parametrize("shown", [(40, 200, 60), None])
def test_a_reference_of_something_else_in_few_of_a_class_pixels_is_told(folder: Path, way, shown, capsys) -> None:
    """Something green over a tenth of the blue patch is no shade of blue, as a darker part of it is."""
    for n in range(3):
        path = str(folder / "images" / f"{n}.png")
        image = cv2.imread(path)
        part = image[26:34, 55 : 58 if n else 62]
        part[:] = part // 2 if shown is None else np.array(shown[::-1], np.uint8)
        cv2.imwrite(path, image)
    assert learn(folder, *way(folder)) == 0
    lines = [line for line in capsys.readouterr().out.splitlines() if "another hue" in line]
    if shown is None:
        assert lines == []
        return
    (line,) = lines
    assert line.startswith("blue's reference 40,200,60 has another hue than most of it, ")
    assert ("most of all in 0.png [50, 20, 20, 20] (x, y, width, height)" in line) == (way is from_regions)
    assert "mark smaller regions, or mark it as one of a category of its own" in line


@pytest.mark.parametrize("category", [None, "rail", "red"])
def test_long_things_of_a_class_that_nobody_marked_are_named(folder: Path, category, capsys) -> None:
    """Until they are marked, be it as background or as more of the class."""
    arguments = from_regions(folder)
    for path in (folder / "images").glob("*.png"):
        image = cv2.imread(str(path))
        image[6:10] = RED[::-1]
        cv2.imwrite(str(path), image)
    regions = folder / "images" / "regions.json"
    coco = json.loads(regions.read_text())
    if category == "rail":
        coco["categories"].append({"id": 99, "name": "rail"})
    number = {c["name"]: c["id"] for c in coco["categories"]}.get(category)
    for n, own in enumerate(coco["images"] if category else (), start=1000):
        box = {"id": n, "image_id": own["id"], "category_id": number, "bbox": [5, 7, 70, 2]}
        coco["annotations"].append(box)
    regions.write_text(json.dumps(coco))
    assert learn(folder, *arguments) == 0
    told = [line for line in capsys.readouterr().out.splitlines() if "no region touches" in line]
    assert [line.split(" takes ")[0] for line in told] == (["red"] if category is None else [])
    assert all("[0, 6, 90, 4] (x, y, width, height)" in line for line in told)
