from __future__ import annotations

from pathlib import Path

import pytest

from artrec_ros.core.constraints.constraint_set import ConstraintSet
from artrec_ros.io.learned.constraints import save_constraints
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.tools.tuning.parameter_text import tuned_text

from .lamp import PARAMETERS, write_lamp

CHANGES = {"recognizer.min_match": 0.61, "expert.alignment.tolerance_px": 3.0, "image.smoothing_px": 1.5,
           "expert.alignment.couple_spans": [1]}  # fmt: skip


def tuned(params: Path, target: Path, changes=CHANGES, more=()) -> str:
    setup = load_parameters(params, *more)
    text = tuned_text([params, *more], setup.changed(changes), changes, target, "note\nof two lines")
    target.write_text(text)
    found = load_parameters(target).resolved
    for key, value in {**setup.resolved, **changes}.items():
        if not key.endswith("_file"):
            assert found[key] == value, key
    assert Path(found["lamp.object_file"]).samefile(setup.resolved["lamp.object_file"])
    return text


def test_what_a_person_wrote_stays(tmp_path):
    params = write_lamp(tmp_path)
    (tmp_path / "out").mkdir()
    lines = tuned(params, tmp_path / "out" / "parameters.yaml").splitlines()
    assert lines[:3] == ["# note", "# of two lines", "# a lamp on a bench"]
    assert "      min_match: 0.61         # share of the outline" in lines
    assert '      object_file: "../lamp.yaml"   # beside this file' in lines
    assert any(line.strip().startswith("tolerance_px: 3.0  # px: ") for line in lines)  # unit and meaning come along
    kept = [line for line in PARAMETERS.splitlines() if not any(k in line for k in ("min_match", "_file", "image"))]
    assert [line for line in lines if line in kept] == kept


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("    recognizer:\n      whole_object: false\n      min_match: 0.8", "    recognizer.min_match: 0.8"),
        ("    recognizer:\n      whole_object: false\n      min_match: 0.8", "    recognizer: {min_match: 0.8}"),
        ("    recognizer:\n      whole_object: false\n      min_match: 0.8", "    recognizer: {}"),
        ("    image: {kind: labels}\n", ""),
        ("object_file: lamp.yaml", "object_file: FOLDER/lamp.yaml"),
        ("/**:", "/robot/artrec_node:"),
    ],
)
def test_other_ways_of_writing(tmp_path, old, new):
    params = write_lamp(tmp_path)
    assert old in PARAMETERS
    params.write_text(PARAMETERS.replace(old, new.replace("FOLDER", str(tmp_path))))
    tuned(params, tmp_path / "parameters.yaml")


def test_of_several_files_the_values_stay(tmp_path):
    params = write_lamp(tmp_path)
    (tmp_path / "more.yaml").write_text("/**: {ros__parameters: {expert: {alignment: {refine_keep: 7}}}}")
    text = tuned(params, tmp_path / "parameters.yaml", more=[tmp_path / "more.yaml"])
    assert "refine_keep: 7" in text and text.startswith("# note")


def test_two_sections_are_written_anew(tmp_path):
    params = write_lamp(tmp_path)
    params.write_text(PARAMETERS + "/artrec_node:\n  ros__parameters: {recognizer: {min_match: 0.7}}\n")
    assert "min_match: 0.61" in tuned(params, tmp_path / "parameters.yaml")
    assert not list(tmp_path.glob("*.part"))


def test_a_file_that_was_not_named_before_is_added(tmp_path):
    """As constraints are, once they are learned; what a person wrote stays all the same."""
    params, target = write_lamp(tmp_path), tmp_path / "new.yaml"
    save_constraints(tmp_path / "learned.yaml", ConstraintSet("lamp", 0.95, ()))
    setup = load_parameters(params).changed({"lamp.constraint_file": str(tmp_path / "learned.yaml")})
    target.write_text(tuned_text([params], setup, {"lamp.constraint_file": "learned.yaml"}, target, ""))
    assert load_parameters(target).targets[0].constraints == ConstraintSet("lamp", 0.95, ())
    assert "# a lamp on a bench" in target.read_text()
