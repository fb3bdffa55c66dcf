"""The sheet on which `artrec model` draws an object and its markers."""

import math

import cv2
import numpy as np
from model_runs import OBJECTS, QUADRUPED, run

from artrec_ros.core.model.target import Target
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.simulation import sheet
from artrec_ros.simulation.sheet import MarkerCell, model_sheet


def test_the_sheet_shows_markers_and_the_object(tmp_path):
    assert run(QUADRUPED, "--sheet", tmp_path / "new" / "sheet.png", "--label", 3) == 0
    sheet = cv2.imread(str(tmp_path / "new" / "sheet.png"))
    # four shapes, seven sides, both ends of four joints; four in a row
    assert sheet.shape[1] == 4 * 300 and sheet.shape[0] == 5 * 342
    assert np.all(sheet[42 + 150, 150] == (40, 30, 200)) or np.any(np.all(sheet[42:342, :300] == (40, 30, 200), axis=2))


def test_a_rim_lies_around_letters_whatever_the_font_does_with_thickness():
    plain, rimmed = np.full((2, 40, 120, 3), 90, np.uint8)
    sheet._text(plain, "lateral_right", (10, 25), (255, 255, 255), 0.34)
    sheet._text(rimmed, "lateral_right", (10, 25), (255, 255, 255), 0.34, (0, 0, 0))
    letters, rim = ([np.flatnonzero((p != 90).any(axis=(2, axis))) for axis in (0, 1)] for p in (plain, rimmed))
    for inner, outer in zip(letters, rim, strict=True):
        assert (inner[0] - outer[0], outer[-1] - inner[-1]) == (1, 1)


def test_joints_on_the_sheet_have_units(monkeypatch):
    captions = []
    monkeypatch.setattr(sheet, "_captioned", lambda image, caption, notes: captions.append(caption) or image)
    model_sheet(Target("quadruped", load_object(QUADRUPED, {}), 2), [])
    assert "front_left at -0.7 rad" in captions


def test_classes_of_the_sheet_are_called_what_the_file_calls_them(tmp_path, monkeypatch):
    square = "outline: [[-0.02, -0.02], [0.02, -0.02], [0.02, 0.02], [-0.02, 0.02]], axis: [[-0.01, 0], [0.01, 0]]"
    (tmp_path / "two.yaml").write_text(
        "format: artrec_object/1\nname: two\nclasses: {steel: 5}\n"
        f"markers: {{m: {{{square}}}, n: {{{square.replace('0.02', '0.03')}}}}}\n"
        "components: {a: {required: true, markers: {m: {}}, label: cherry}, b: {markers: {n: {}}, label: steel}}\n"
    )
    written = []
    monkeypatch.setattr(sheet, "_text", lambda image, text, *rest: written.append(text))
    assert run(tmp_path / "two.yaml", "--sheet", tmp_path / "sheet.png") == 0
    assert {"40 x 40 mm, class cherry", "60 x 60 mm, class steel"} <= set(written)


def test_a_sheet_of_markers_alone_has_no_object():
    pendulum = load_object(OBJECTS / "pendulum.yaml")
    cells = [MarkerCell(m, 2, m.name, (0.1, 0.05)) for c in pendulum.components for m in c.markers]
    sheet = model_sheet(Target("pendulum", pendulum, 2), cells)
    assert sheet.shape[0] == 342 * math.ceil(len(cells) / 4)
