from __future__ import annotations

import dataclasses
import os

import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.model.found import ClassFit, Detection, IdentityFit, ImagePose, Instance, OtherObject, OtherPlace
from artrec_ros.core.model.frame_result import ConstraintFailure, FrameResult, Rejection
from artrec_ros.io.base.whole_files import LineFile, write_whole
from artrec_ros.io.results.journal import Journal, Recognised


def frame(stamp_ns: int = 10) -> Recognised:
    random = np.random.default_rng(stamp_ns)
    pose = Pose.from_xyz_rpy(random.normal(size=3), random.normal(size=3))
    part = Instance("base", "patch", np.float32(0.3), *random.normal(size=4), contour=random.normal(size=(5, 2)))
    found = Detection(
        "arm", 2, 0.1 + 0.2, ImagePose(1, 2, 3, 4), (part,), pose, {"lever": np.float64(1 / 3)},
        random.normal(size=(6, 6)), ClassFit("waving", 0.7, None), 0.25,
        IdentityFit(None, 1 / 3, "gr", True, 0.8, {"gr": np.float64(-1 / 3), "gv": -2.5}),
    )  # fmt: skip
    found = dataclasses.replace(found, other_place=OtherPlace(ImagePose(5, 6, 7, 8), 1 / 3, found))
    found = dataclasses.replace(found, other_object=OtherObject("leg", 1 / 3), plane_scale=np.float64(1 / 3))
    failed = ConstraintFailure("a/b", "c/d", "distance_m", 1 / 3, 0.1, 0.2, 0.13)
    rejected = (Rejection("arm", "weiß nicht", 0.5, 1.5, 2.5, failed), Rejection("arm", "other"))
    likely = dataclasses.replace(found, score=0.2)
    result = FrameResult(
        (8, 6), (found,), rejected, {"total": 1.25}, (), np.zeros((6, 8), np.uint8), doubtful=(likely,)
    )
    return Recognised(stamp_ns, "/camera/image", result, "eye")


def same(a: object, b: object) -> bool:
    """Digit by digit, and of the same types but for numpy's numbers."""
    if dataclasses.is_dataclass(a):
        return type(a) is type(b) and all(same(getattr(a, f.name), getattr(b, f.name)) for f in dataclasses.fields(a))
    if isinstance(a, np.ndarray):
        return isinstance(b, np.ndarray) and a.shape == b.shape and np.array_equal(a, b)
    if isinstance(a, tuple):
        return isinstance(b, tuple) and len(a) == len(b) and all(map(same, a, b))
    if isinstance(a, dict):
        return isinstance(b, dict) and list(a) == list(b) and all(same(a[k], b[k]) for k in a)
    return a == b


def test_what_is_read_is_what_was_written(tmp_path):
    written = [frame(1), Recognised(2, "bad.png", error="no image"), frame(3)]
    with Journal(tmp_path / "j") as journal:
        returned = [journal.append(i, f) for i, f in enumerate(written)]
    with Journal(tmp_path / "j") as journal:
        numbers, read = zip(*journal.frames(), strict=True)
    assert numbers == (0, 1, 2)
    for before, back, later in zip(written, returned, read, strict=True):
        result = before.result and dataclasses.replace(before.result, labels=None)
        assert same(dataclasses.replace(before, result=result), later) and same(back, later)
        assert later.record().to_json() == before.record().to_json()


def test_a_line_that_was_cut_off_is_dropped_and_overwritten(tmp_path):
    with Journal(tmp_path / "j") as journal:
        for i in range(3):
            journal.append(i, frame(i))
    os.truncate(tmp_path / "j", (tmp_path / "j").stat().st_size - 5)
    with Journal(tmp_path / "j") as journal:
        journal.append(7, frame())
        assert [n for n, _ in journal.frames()] == [0, 1, 7]


@pytest.mark.parametrize("line", ["[1]", "{}", '[1, {"type": "Popen"}]', '["x", null]', "nonsense", "\0\0", "\udcff"])
def test_a_line_that_is_no_frame_is_named_and_what_is_before_it_kept(tmp_path, line):
    with Journal(tmp_path / "j") as journal:
        for i in range(2):
            journal.append(i, frame(i))
    with open(tmp_path / "j", "ab") as stream:
        stream.write(f"{line}\n".encode(errors="surrogateescape"))
    with Journal(tmp_path / "j") as journal:
        journal.append(2, frame(2))
        assert [n for n, _ in journal.frames()] == [0, 1]
        assert "j: line 3 is no frame: " in journal.lost and "Error" not in journal.lost
        journal.append(7, frame(7))
    with Journal(tmp_path / "j") as journal:
        assert [n for n, _ in journal.frames()] == [0, 1, 7] and not journal.lost


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            '"score": 0.30000000000000004',
            '"score": "x"',
            "result.detections[0].score: must be a finite number, not 'x'",
        ),
        ('"position": {"array": [', '"position": {"array": [null, 1, 2], "x": [', "it holds numbers that are none"),
        ('"shape": [3, 3]', '"shape": [4, 3]', "something in it is missing or of another kind"),
    ],
)
def test_a_frame_with_wrong_values_is_recognised_again(tmp_path, old, new, said):
    with Journal(tmp_path / "j") as journal:
        for i in range(3):
            journal.append(i, frame(i))
    lines = (tmp_path / "j").read_text().splitlines()
    assert old in lines[1]
    lines[1] = lines[1].replace(old, new, 1)
    (tmp_path / "j").write_text("\n".join(lines) + "\n")
    with Journal(tmp_path / "j") as journal:
        assert [n for n, _ in journal.frames()] == [0]
        assert f"line 2 is no frame: {said}" in journal.lost


def test_a_full_disk_leaves_whole_lines(tmp_path, monkeypatch):
    """The second piece of a line finds no room."""
    real = os.pwrite
    room = [10**6]

    def pwrite(handle: int, data: bytes, offset: int) -> int:
        if not room[0]:
            raise OSError(28, "No space left on device")
        written = real(handle, data[: room[0]], offset)
        room[0] -= written
        return written

    monkeypatch.setattr(os, "pwrite", pwrite)
    with LineFile(tmp_path / "f") as file:
        file.append("first")
        room[0] = 3
        with pytest.raises(OSError, match="No space"):
            file.append("second")
        assert file.count == 1 and (tmp_path / "f").read_text() == "first\n"
        room[0] = 100
        file.append("third")
    assert (tmp_path / "f").read_text() == "first\nthird\n"


def test_a_file_is_replaced_whole_or_not_at_all(tmp_path, monkeypatch):
    path = tmp_path / "f"
    write_whole(path, "before")
    full = OSError(28, "full")
    monkeypatch.setattr("artrec_ros.io.base.whole_files.os.replace", lambda *_: (_ for _ in ()).throw(full))
    with pytest.raises(OSError, match="full"):
        write_whole(path, "after")
    assert path.read_text() == "before" and [p.name for p in tmp_path.iterdir()] == ["f"]
