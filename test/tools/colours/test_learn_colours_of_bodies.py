"""`artrec learn-colours` of the classes that objects' bodies have."""

from __future__ import annotations

from pathlib import Path

import pytest
from painted import (
    ROBOT,
    ROBOTS,
    drawn,
    labels_of,
    learn_robots,
    learned_image,
)

from artrec_ros.core.base.config import ClassConfig, ImageConfig
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.learning.colour_learning import Learned
from artrec_ros.tools.colour_report import report


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
    assert "Class 'plate' (label 5) is not learned: no axis shows it" in capsys.readouterr().err
    with pytest.raises(ConfigError, match="'plate' is not in image.classes of the last file"):
        learned_image(robots)
    drawn(robots, "plate", [8, 50, 30, 8])
    assert learn_robots(robots) == 0
    assert "plate" in learned_image(robots).classes
    assert "is not learned" not in capsys.readouterr().err


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


@pytest.mark.parametrize(
    ("right", "unknown", "told"),
    [(0.33, 0.67, "counts as background"), (0.63, 0.37, None), (0.5, 0.1, "green takes 40% of it")],
)
def test_a_markers_class_that_is_badly_told_is_named_with_what_to_do(right: float, unknown: float, told) -> None:
    """A third of a class was right, without a word."""
    image = ImageConfig(kind="colour", classes={"dot": ClassConfig(5, (40, 130, 40))})
    shares = {"dot": {"dot": right, "unknown": unknown, "green": 1 - right - unknown}}
    lines = [line for line in report(Learned(image, shares, {"dot": 100})) if "marker's class 'dot'" in line]
    assert len(lines) == (told is not None) and all(str(told) in line for line in lines)


@pytest.mark.parametrize(("ring_px", "told"), [(None, True), (1.0, True), (4.0, False)])
def test_what_lies_farther_off_than_a_ring_is_too_like_all_the_same(ring_px: float | None, told: bool) -> None:
    """A brown body beside an orange dot was told as paint that goes on for a pixel."""
    image = ImageConfig(kind="colour", classes={"dot": ClassConfig(5, (180, 90, 40))})
    shares = {"dot": {"dot": 0.98}, "beside markers": {"dot": 0.11, "unknown": 0.89}}
    rings = {} if ring_px is None else {"dot": ring_px}
    lines = list(report(Learned(image, shares, dict.fromkeys(shares, 100), rings)))
    assert any("dot takes 11% of 'beside markers'" in line for line in lines) == told
    assert any("dot goes on for" in line for line in lines) == (ring_px is not None)


def test_a_declared_class_of_no_object_is_learned_where_somebody_drew_it(robots: Path, capsys) -> None:
    """It was made background without a word."""
    text = ROBOTS.replace("[red, blue]", "[red, blue, ball]").replace("blue: {", "ball: {label: 7}\n      blue: {")
    (robots / "robots.yaml").write_text(text)
    assert learn_robots(robots) == 0
    assert "Class 'ball' (label 7) is not learned: no axis shows it" in capsys.readouterr().err
    drawn(robots, "ball", [8, 50, 30, 8])
    assert learn_robots(robots) == 0
    assert labels_of(learned_image(robots))["ball"] == 7
