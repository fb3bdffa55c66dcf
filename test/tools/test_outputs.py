"""What commands write by a user's name takes nothing away."""

from __future__ import annotations

from pathlib import Path

import cv2
import pytest

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.tools.main import main
from artrec_ros.tools.options.outputs import OF_CONSTRAINTS, check_not_read, check_output

OBJECT = """\
format: artrec_object/1
name: toy
markers:
  flag: {outline: [[0, 0], [0.04, 0], [0.03, 0.01], [0.04, 0.02], [0, 0.02]], axis: [[0, 0.01], [0.03, 0.01]]}
components: {base: {required: true, markers: {flag: {}}}}
"""
PARAMETERS = "/**: {ros__parameters: {objects: [toy], toy: {object_file: toy.yaml, label: 2}}}\n"
COCO = '{"images": [], "annotations": [], "categories": []}\n'


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    for name, text in (("toy.yaml", OBJECT), ("params.yaml", PARAMETERS), ("coco.json", COCO), ("notes.txt", "mine")):
        (tmp_path / name).write_text(text)
    (tmp_path / "frames").mkdir()
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("command", "lost"),
    [
        ("train --object toy.yaml --annotations coco.json -o coco.json", "coco.json"),
        ("train --object toy.yaml --from-joints -o toy.yaml", "toy.yaml"),
        ("train --object toy.yaml --annotations coco.json -o notes.txt", "notes.txt"),
        ("learn-colours --annotations coco.json --classes red=1 -o coco.json", "coco.json"),
        ("learn-colours --annotations coco.json --classes red=1 -o params.yaml", "params.yaml"),
        ("model toy.yaml --marks coco.json -o coco.json --overwrite", "coco.json"),
        ("model toy.yaml -o notes.txt --overwrite", "notes.txt"),
        ("evaluate . --truth report.html", "report.html"),
        ("model toy.yaml --sheet photo.png", "photo.png"),
        ("model toy.yaml --print page.pdf", "page.pdf"),
        ("inspect params.yaml . --scene photo.png", "photo.png"),
    ],
)
def test_nothing_that_is_read_or_of_others_is_written_over(
    folder: Path, capsys: pytest.CaptureFixture[str], command: str, lost: str
) -> None:
    for name in ("report.html", "photo.png", "page.pdf"):
        (folder / name).write_text("of others")
    before = {p.name: p.read_text() for p in folder.iterdir() if p.is_file()}
    assert main(command.split()) == 1
    said = capsys.readouterr()
    assert said.err.startswith(f"artrec: {lost}: ") and said.err.count("\n") == 1 and not said.out
    assert "name another" in said.err
    assert {p.name: p.read_text() for p in folder.iterdir() if p.is_file()} == before


def test_a_replay_writes_no_overlays_among_its_images(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for output in (folder, Path()):
        assert main(["replay", "frames", "--params-file", "params.yaml", "-o", str(output)]) == 1
        assert "is read by this command" in capsys.readouterr().err
    assert not any((folder / "frames").iterdir()) and not (folder / "replay.json").exists()


@pytest.mark.parametrize("option", ["--sheet sheet.png", "--sheet sheet.jpg", "--print page.pdf"])
def test_a_drawing_is_drawn_anew(folder: Path, option: str) -> None:
    if "--print" in option:
        pytest.importorskip("matplotlib")
    drawing = folder / option.split()[1]
    assert main(["model", "toy.yaml", *option.split()]) == 0
    drawn = drawing.stat().st_mtime_ns
    assert main(["model", "toy.yaml", *option.split()]) == 0
    assert drawing.stat().st_mtime_ns > drawn
    if drawing.suffix != ".pdf":
        assert cv2.imread(str(drawing)).shape[2] == 3


def test_what_a_command_wrote_itself_and_what_is_empty_may_be_written_anew(folder: Path) -> None:
    own, empty, linked = folder / "own.yaml", folder / "empty.yaml", folder / "linked.yaml"
    own.write_text("# a note\nformat: artrec_constraints/1\n")
    empty.touch()
    linked.symlink_to("toy.yaml")
    check_output(own, [folder / "toy.yaml"], OF_CONSTRAINTS)
    check_output(empty, [], OF_CONSTRAINTS)
    check_output(folder / "new.yaml", [], OF_CONSTRAINTS)
    with pytest.raises(ConfigError, match=r"linked\.yaml: is read"):
        check_not_read(linked, [folder / "toy.yaml"])
    with pytest.raises(ConfigError, match="--overwrite replaces it"):
        check_output(own, [], OF_CONSTRAINTS, overwrite=False)
