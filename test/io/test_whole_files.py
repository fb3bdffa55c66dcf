"""Files that commands write: whole or not at all, by whatever name."""

from __future__ import annotations

import errno
import os
import resource
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from artrec_ros.core.base.config import ClassConfig, ImageConfig
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.learning.pair_learning import learn
from artrec_ros.core.model.marker import Marker
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.io.base.whole_files import check_place, make_folder, save_file
from artrec_ros.io.images.writing import save_drawing, save_picture
from artrec_ros.io.learned.colours import save_colours
from artrec_ros.io.learned.constraints import save_constraints
from artrec_ros.io.objects.object_writer import save_object

FLAG = Marker("flag", np.array([[0, 0], [0.4, 0], [0.3, 0.1], [0.4, 0.2], [0, 0.2]]), [0, 0.1], [0.3, 0.1])
MODEL = ObjectModel("toy", (Component("base", (FLAG,), required=True),))
IMAGE = ImageConfig(kind="colour", classes={"red": ClassConfig(label=1)})


@contextmanager
def no_room(size: int = 8) -> Iterator[None]:
    """Files can hold so many bytes, as on a disk that is nearly full."""
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, before[1]))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)


@pytest.mark.parametrize(
    "save",
    [
        lambda path: save_object(path, MODEL),
        lambda path: save_constraints(path, learn(MODEL, [])),
        lambda path: save_colours(path, IMAGE),
        lambda path: save_picture(path, np.zeros((40, 40, 3), np.uint8)),
        lambda path: save_drawing(path, np.zeros((40, 40, 3), np.uint8)),
    ],
)
def test_without_room_an_earlier_file_stays(save: Callable[[Path], None], tmp_path: Path) -> None:
    path = tmp_path / "file.png"
    path.write_text("as it was before")
    with no_room(), pytest.raises(ConfigError, match=r"file\.png: cannot be written: File too large"):
        save(path)
    assert path.read_text() == "as it was before" and [*tmp_path.iterdir()] == [path]


def test_a_link_stays_one_and_folders_are_made(tmp_path: Path) -> None:
    target, link = tmp_path / "kept" / "there.yaml", tmp_path / "link.yaml"
    link.symlink_to(target)
    save_file(target, "one")
    save_file(link, b"two")
    assert link.is_symlink() and target.read_bytes() == b"two"


def test_what_may_be_written_to_is_and_keeps_its_rights(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A mounted file cannot be replaced, only filled anew."""
    path = tmp_path / "mounted.yaml"
    path.write_text("one")
    path.chmod(0o664)
    save_file(path, "two")
    assert path.read_text() == "two" and path.stat().st_mode & 0o777 == 0o664

    def busy(*names: object) -> None:
        raise OSError(errno.EBUSY, "Device or resource busy")

    monkeypatch.setattr(os, "replace", busy)
    save_file(path, "three")
    assert path.read_text() == "three" and [*tmp_path.iterdir()] == [path]
    with pytest.raises(ConfigError, match="busy"):
        save_file(tmp_path / "new.yaml", "four")


def test_a_link_to_itself_is_told(tmp_path: Path) -> None:
    (tmp_path / "loop").symlink_to(tmp_path / "loop")
    with pytest.raises(ConfigError, match="loop: cannot be written: "):
        save_file(tmp_path / "loop", "text")


@pytest.mark.parametrize("write", [check_place, make_folder, lambda path: save_file(path, "x")])
def test_a_file_in_a_folders_place_is_named(tmp_path: Path, write: Callable[[Path], None]) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match=f"file/a/b: cannot be written: {tmp_path}/file is no folder"):
        write(tmp_path / "file/a/b")


def test_a_place_where_nothing_can_be_made_is_told_with_the_way_out() -> None:
    with pytest.raises(ConfigError, match=r"/proc/x/y: cannot be written: nothing can be made in /proc; name another"):
        save_file("/proc/x/y", "text")


def test_looking_whether_a_file_can_be_written_changes_none(tmp_path: Path) -> None:
    (tmp_path / "there").write_text("mine")
    for name in ("there", "new", "folder/new"):
        check_place(tmp_path / name)
    check_place("/dev/stdout")
    assert sorted(p.name for p in tmp_path.rglob("*")) == ["folder", "there"]
    assert (tmp_path / "there").read_text() == "mine"
    with pytest.raises(ConfigError, match="folder: cannot be written: Is a directory"):
        check_place(tmp_path / "folder")


def test_what_is_no_file_is_written_as_it_is() -> None:
    save_file("/dev/null", "text")
    assert Path("/dev/null").is_char_device()


def test_a_picture_of_no_kind_is_refused(tmp_path: Path) -> None:
    for name, picture in (("a.pgn", np.zeros((4, 4), np.uint8)), ("a.pgm", np.zeros((4, 4, 3), np.uint8))):
        with pytest.raises(ConfigError, match=r"'.pg.' cannot hold this picture; let the name end in .png"):
            save_picture(tmp_path / name, picture)
