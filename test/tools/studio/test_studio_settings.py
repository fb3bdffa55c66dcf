"""Parameters that are tried in `artrec studio`, beside those that are saved."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest
from studio_pictures import Pictures
from studio_sitting import again

from artrec_ros.core import recognizer
from artrec_ros.core.base import kernel_cache
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.tools.studio_state.examples import Examples
from artrec_ros.tools.studio_state.session import Session, load_setup
from artrec_ros.tools.studio_state.settings import Settings, read_list


def test_settings_are_tried_and_kept(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    session = again(taught, tmp_path, pictures)
    settings = Settings(session)
    assert "recognizer.min_probability" in settings.specs() and "expert.fit.steps" not in settings.changes
    settings.change("recognizer.min_probability", 0.97)
    before, after = settings.both(0)
    assert len(after.detections) <= len(before.detections)
    with pytest.raises(ConfigError, match="min_probability"):
        settings.change("recognizer.min_probability", 1.5)
    assert settings.value("recognizer.min_probability") == 0.97
    settings.save()
    assert not settings.changes
    assert load_parameters(session.parameters).recognizer.min_probability == 0.97
    settings.change("recognizer.min_probability", 0.97)
    assert not settings.changes, "the session's own value is no change"


def test_it_is_told_that_an_image_waits_for_the_compiler(
    pictures: Pictures, taught: Session, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Whichever window or thread it was that asked, and why the next start compiles again."""
    session = again(taught, tmp_path, pictures)
    seen: list[object] = []

    def get_ready(parts: object, told: Callable[[float], None]) -> None:
        told(0.3)
        seen.append((session.compiled, session.warnings))

    monkeypatch.setattr(recognizer, "get_ready", get_ready)
    monkeypatch.setattr(kernel_cache, "problem", lambda: "/there: compiled code cannot be written")
    session.stills.problems.append("camera_info is another camera's")
    Settings(session).both(0)
    both = ["camera_info is another camera's", "/there: compiled code cannot be written"]
    assert seen[0] == (0.3, both) and session.compiled is None and session.warnings == both


def test_scores_are_those_of_frames_marked_by_hand(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    session = again(taught, tmp_path, pictures)
    settings = Settings(session)
    with pytest.raises(ConfigError, match="no frame is marked"):
        settings.scored(lambda share: None)
    examples = Examples(session)
    for number in (4, 5):
        for robot in pictures.axes(number):
            examples.new(number, session.setup.targets[0], ("team", "team"), *robot["team"])
    (first, *_) = [line for line in settings.scored(lambda share: None) if "frames," in line]
    assert first.startswith("2 frames, 6 objects in view, ") and int(first.split(", ")[2].split()[0]) >= 4
    settings.change("recognizer.min_probability", 0.9)
    assert any("after" in line for line in settings.scored(lambda share: None))


def test_a_change_that_changes_nothing_is_told(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    settings = Settings(again(taught, tmp_path, pictures))
    settings.change("recognizer.min_probability", 0.5)
    assert settings.unread() == []
    settings.change("recognizer.min_match", 0.5)  # robots are found as a whole
    (line,) = settings.unread()
    assert line.startswith("recognizer.min_match changes nothing")


@pytest.mark.parametrize(("text", "values"), [("1, 2", [1, 2]), ("[0.5, a]", [0.5, "a"]), ("", [])])
def test_lists_are_read_as_people_write_them(text: str, values: list[object]) -> None:
    assert read_list(text) == values


def test_a_list_that_is_none_is_told() -> None:
    with pytest.raises(ConfigError, match="is no list"):
        read_list("1, {")


def test_constraint_files_need_not_be_there_yet(pictures: Pictures, tmp_path: Path) -> None:
    given = pictures.folder / "with_constraints.yaml"
    text = pictures.parameters.read_text().replace("robot.yaml,", "robot.yaml, constraint_file: none.yaml,")
    given.write_text(text)
    assert load_setup((given,), tmp_path).targets[0].constraints is None
    given.write_text(text.replace("constraint_file", "constraints_file"))
    with pytest.raises(ConfigError, match="robot.constraints_file"):
        load_setup((given,), tmp_path)
