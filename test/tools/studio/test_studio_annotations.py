"""Examples that were marked elsewhere, with which `artrec studio` begins."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import pytest
from studio_pictures import Pictures
from studio_sitting import again

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.tools.studio_state.examples import Examples
from artrec_ros.tools.studio_state.session import Session
from artrec_ros.tools.studio_state.settings import Settings
from artrec_ros.tools.studio_state.training import train_examples


@pytest.fixture
def marked(pictures: Pictures, taught: Session, tmp_path: Path) -> Path:
    """A file with the robots of two frames, made in another sitting."""
    (tmp_path / "elsewhere").mkdir()
    session = again(taught, tmp_path / "elsewhere", pictures)
    examples = Examples(session)
    for number in (4, 5):
        for robot in pictures.axes(number):
            examples.new(number, session.setup.targets[0], ("team", "team"), *robot["team"])
    return examples.path


def changed(file: Path, change: Callable[[dict[str, list[dict[str, object]]]], None]) -> Path:
    content = json.loads(file.read_text())
    for image in content["images"]:
        image["file_name"] = str(Path(file.parent, image["file_name"]).resolve())
    change(content)
    file.write_text(json.dumps(content))
    return file


def test_what_was_marked_before_is_trained_and_scored_without_a_mark_more(
    pictures: Pictures, taught: Session, marked: Path, tmp_path: Path
) -> None:
    session = again(taught, tmp_path, pictures)
    examples = Examples(session, [marked])
    assert examples.misfits == () and len(examples.of(4)) == 3
    trained = train_examples(session, examples)
    assert trained is not None and trained.written
    assert "2 frames, 6 objects in view" in "".join(Settings(session).scored(lambda share: None))


def test_images_that_are_no_frames_are_told_and_leave_no_file(
    pictures: Pictures, taught: Session, marked: Path, tmp_path: Path
) -> None:
    session = again(taught, tmp_path, pictures)
    changed(marked, lambda content: [image.update(file_name=f"cam_{image['id']}.png") for image in content["images"]])
    examples = Examples(session, [marked])
    (line,) = examples.misfits
    assert "no image of it (2, such as 'cam_1.png') is one of the frames (6, such as '00.png')" in line
    assert str(marked) in line and "as SOURCE" in line
    assert not examples.objects and not examples.path.exists(), "the right file may be given the next time"
    session.folder.joinpath("annotations.json").write_text(marked.read_text())
    with pytest.raises(ConfigError, match=r"no image of it \(2, such as 'cam_1.png'\) is one of the frames"):
        Settings(session).scored(lambda share: None)


def test_some_images_that_are_no_frames_are_counted(
    pictures: Pictures, taught: Session, marked: Path, tmp_path: Path
) -> None:
    session = again(taught, tmp_path, pictures)
    changed(marked, lambda content: content["images"][1].update(file_name="other.png"))
    examples = Examples(session, [marked])
    (line,) = examples.misfits
    assert "1 of its 2 images, such as 'other.png', are none of the frames" in line
    assert len(examples.objects) == 6 and len(examples.of(4)) == 3


def test_categories_without_keypoints_are_told(
    pictures: Pictures, taught: Session, marked: Path, tmp_path: Path
) -> None:
    session = again(taught, tmp_path, pictures)
    box = {"id": 99, "image_id": 1, "category_id": 9, "bbox": [1, 2, 3, 4]}

    def with_cars(content: dict[str, list[dict[str, object]]]) -> None:
        content["categories"].append({"id": 9, "name": "car"})
        content["annotations"] += [box, {**box, "id": 100}]

    (line,) = Examples(session, [changed(marked, with_cars)]).misfits
    assert "category 'car' has no keypoints" in line and "its 2 annotations are passed over" in line
