"""`benchmarks/sensitivity.py`: every number is changed by a third either way, and one that changes nothing is told."""

import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from artrec_ros.io.parameters.specs import all_specs

ROOT = Path(__file__).parents[1]
OBJECT = """
format: artrec_object/1
name: toy
markers: {flag: {outline: [[-0.1, -0.1], [0.2, -0.1], [0.1, 0.15], [-0.1, 0.1]], axis: [[-0.1, 0], [0.1, 0]]}}
components: {base: {required: true, markers: {flag: {}}}}
"""


@pytest.fixture
def sensitivity(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    import sensitivity

    return sensitivity


def test_numbers_change_by_a_third_and_stay_within_their_range(sensitivity):
    specs = all_specs([], [])
    values = {n: [v for _, v in sensitivity.values_of(specs[n], specs[n].default)] for n in specs if "expert" in n}
    assert values["expert.alignment.coarse_keep"] == [133, 267]
    assert values["expert.alignment.point_step"] == [1, 3]
    assert values["expert.grouping.min_group_match"] == pytest.approx([0.7 * 2 / 3, 0.7 * 4 / 3])
    assert values["expert.grouping.min_satisfied"][1] == 1.0
    assert values["expert.alignment.gates_px"][2:] == [[8.0, 1.0], [8.0, 2.0]]
    assert values["expert.search.climb_rounds"] == [[7, 9, 16], [15, 17, 32]]  # a schedule changes as a whole
    assert len(values["expert.votes.ring"]) == 4  # of three numbers one is 0, which no factor changes


def test_a_number_that_matters_and_one_that_does_not_are_told(sensitivity, tmp_path, monkeypatch, capsys):
    (tmp_path / "toy.yaml").write_text(OBJECT)
    params = tmp_path / "node.yaml"
    params.write_text("/**: {ros__parameters: {objects: [toy], toy: {object_file: toy.yaml, label: 1}}}")
    labels = np.zeros((120, 160), np.uint8)
    corners = np.array([[-0.1, 0.1], [0.2, 0.1], [0.1, -0.15], [-0.1, -0.1]]) * 150 + (70, 60)
    cv2.fillPoly(labels, [corners.astype(np.int32)], 1)
    (tmp_path / "images").mkdir()
    cv2.imwrite(str(tmp_path / "images" / "0.png"), labels)
    monkeypatch.setattr(sys, "argv", ["sensitivity.py", "--set", str(params), str(tmp_path / "images"), "-"])
    monkeypatch.setattr(sys, "argv", [*sys.argv, "--only", "alone_match"])
    sensitivity.main()
    told = capsys.readouterr().out
    assert "1 objects told" in told and "grouping.min_alone_match" in told
    monkeypatch.setattr(sys, "argv", [*sys.argv[:-1], "max_blobs"])
    sensitivity.main()
    assert "change nothing by a third either way: expert.blobs.max_blobs" in capsys.readouterr().out
