"""How `artrec learn-colours` goes with what parameter files say of the image."""

from __future__ import annotations

import re
from pathlib import Path

import cv2
import numpy as np
import pytest
from painted import (
    ROBOTS,
    drawn_alone,
    labels_of,
    learn_robots,
    learned_image,
)

from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.tools.colour_report import scale_limits, scale_line
from artrec_ros.tools.main import main


def with_image(folder: Path, **values: float) -> None:
    """The robots' parameter file with more of the section `image`."""
    more = "".join(f"\n      {name}: {value}" for name, value in values.items())
    (folder / "robots.yaml").write_text(ROBOTS.replace("kind: colour", f"kind: colour{more}"))


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


def test_markers_that_are_specks_at_the_least_scale_are_told(robots: Path, capsys) -> None:
    """They are of 0.2 m, marked with 80 px/m."""

    def warned(**recognizer: float) -> list[str]:
        more = "".join(f"\n      {name}: {value}" for name, value in recognizer.items())
        (robots / "robots.yaml").write_text(f"{ROBOTS.rstrip()}\n    recognizer:{more}\n")
        assert learn_robots(robots) == 0
        return [line for line in capsys.readouterr().out.splitlines() if "min_blob_px" in line]

    assert warned(min_blob_px=20) == []
    (line,) = warned(min_blob_px=150)  # at the least scale that it suggests
    assert line.startswith("warning: team: ahead/square, behind/square: ") and "the object is not found there" in line
    assert warned(min_blob_px=150, min_scale=70.0) == []
    (line,) = warned(min_scale=10.0)
    assert "4 px at recognizer.min_scale 10 px/m, fewer than recognizer.min_blob_px 8" in line
