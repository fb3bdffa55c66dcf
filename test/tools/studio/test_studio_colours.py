"""Colours that are clicked on in `artrec studio`: marks become files that `artrec learn-colours` reads."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from studio_pictures import Pictures
from studio_sitting import begun, mark_colours

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.io.sources.opening import SourceOptions
from artrec_ros.tools.main import main
from artrec_ros.tools.studio_state import colour_marks
from artrec_ros.tools.studio_state.colour_marks import BACKGROUND, ColourMarks, box_between, patch_around
from artrec_ros.tools.studio_state.examples import Examples
from artrec_ros.tools.studio_state.session import Session, load_setup
from artrec_ros.tools.studio_state.stills import open_stills
from artrec_ros.tools.studio_state.training import learn_colours


def test_a_click_takes_what_is_of_one_colour_and_hangs_together() -> None:
    image = np.full((40, 60, 3), 40, np.uint8)
    image[10:20, 10:24] = (30, 40, 200)
    image[10:20, 30:44] = (30, 40, 200)  # like it, but apart
    outline = patch_around(image, 12.3, 14.9)
    assert outline.min(axis=0).tolist() == [10, 10] and outline.max(axis=0).tolist() == [23, 19]
    assert np.ptp(patch_around(image, 50, 35), axis=0).max() <= 24, "a background is taken near the click alone"
    with pytest.raises(ConfigError, match="outside the image of 60x40"):
        patch_around(image, 60, 3)


def test_a_single_pixel_is_a_region_too() -> None:
    image = np.zeros((9, 9, 3), np.uint8)
    image[4, 4] = 255
    outline = patch_around(image, 4, 4)
    assert outline.shape == (4, 2) and (outline == 4).all()


def test_colours_are_those_of_the_command(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    written = tmp_path / "colours.yaml"
    regions = str(taught.folder / "regions.json")
    assert main(["learn-colours", "--annotations", regions, "--classes", "team=2", "accent=3", "-o", str(written)]) == 0
    assert written.read_text() == (taught.folder / "colours.yaml").read_text()
    by_command = load_parameters(pictures.parameters, written)
    assert taught.setup.image == by_command.image == load_parameters(taught.parameters).image


def test_a_persons_comments_stay_in_the_parameter_file(taught: Session) -> None:
    assert "# what is looked for" in taught.parameters.read_text()


def test_a_preview_shows_the_classes_that_have_enough(pictures: Pictures, tmp_path: Path) -> None:
    session = begun(pictures, tmp_path / "studio")
    marks = ColourMarks(session)
    with pytest.raises(ConfigError, match="nothing is marked yet"):
        marks.preview()
    for place in pictures.middles(0, "team"):
        marks.add(0, "team", patch_around(session.stills.image(0), *place))
    marks.add(0, BACKGROUND, box_between((0, 0), (40, 40)))
    preview = marks.preview()
    assert preview.lacking == {"accent": 20}
    assert preview.learned is not None and list(preview.learned.image.classes) == ["team"]
    with pytest.raises(ConfigError, match="class 'accent': 0 pixels"):
        marks.learn()


def test_what_was_learned_is_kept_while_the_marks_are_the_same(
    pictures: Pictures, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Learning takes seconds, on a busy machine a minute."""
    session, asked = begun(pictures, tmp_path / "studio"), list[int]()
    learn = colour_marks.learn_from
    monkeypatch.setattr(colour_marks, "learn_from", lambda *given: asked.append(1) or learn(*given))
    marks = mark_colours(pictures, session)
    shown = marks.preview().learned
    assert marks.preview().learned is shown is marks.learn() and len(asked) == 1
    marks.remove(marks.patches[-1])
    assert marks.preview().learned is not shown and len(asked) == 2


def test_marks_are_there_again_in_the_next_sitting(pictures: Pictures, tmp_path: Path) -> None:
    before = mark_colours(pictures, begun(pictures, tmp_path / "studio"), (1,))
    after = ColourMarks(begun(pictures, tmp_path / "studio"))
    assert [p.name for p in after.of(1)] == [p.name for p in before.of(1)] and not after.of(0)
    place = pictures.middles(1, "team")[0]
    found = after.at(1, *place)
    assert found is not None and found.name == "team"
    after.remove(found)
    assert len(ColourMarks(begun(pictures, tmp_path / "studio")).patches) == len(before.patches) - 1


def test_classes_may_stand_in_another_parameter_file_than_objects(pictures: Pictures, tmp_path: Path) -> None:
    text = pictures.parameters.read_text()
    objects, rest = text.split("    image:\n")
    given = (pictures.folder / "objects.yaml", pictures.folder / "classes.yaml")
    given[0].write_text(objects)
    given[1].write_text(f"/**:\n  ros__parameters:\n    image:\n{rest}")
    stills = open_stills(pictures.source, SourceOptions(), 9, tmp_path / "frames", print)
    session = Session(stills, tmp_path, given, load_setup(given, tmp_path))
    assert ColourMarks(session).labels == {"team": 2, "accent": 3}
    examples = Examples(session)
    for number in (0, 1):
        for robot in pictures.axes(number):
            examples.new(number, session.setup.targets[0], ("team", "team"), *robot["team"])
    several = [word for path in given for word in ("--params-file", str(path))]
    written = tmp_path / "by_command.yaml"
    assert main(["learn-colours", "--annotations", str(examples.path), *several, "-o", str(written)]) == 0
    learned = learn_colours(session, examples)
    assert learned is not None and "accent" in learned.right
    assert (tmp_path / "colours.yaml").read_text() == written.read_text()


def test_label_images_have_no_colours_to_learn(pictures: Pictures, tmp_path: Path) -> None:
    text = pictures.parameters.read_text().replace("kind: colour", "kind: palette")
    given = (pictures.folder / "palette.yaml",)
    given[0].write_text(text.replace("{label: 2}\n      acc", "{label: 2, rgb: [1, 2, 3]}\n      acc").replace(
        "accent: {label: 3}", "accent: {label: 3, rgb: [200, 2, 3]}"
    ))  # fmt: skip
    stills = open_stills(pictures.source, SourceOptions(), 9, tmp_path / "frames", print)
    with pytest.raises(ConfigError, match="image.kind is 'palette'"):
        ColourMarks(Session(stills, tmp_path, given, load_setup(given, tmp_path)))
