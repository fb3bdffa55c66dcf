"""Files given in another one's place are called what they are."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from artrec_ros.core.base.errors import ArtrecError
from artrec_ros.io.images.cameras import load_camera
from artrec_ros.io.learned.annotations import load_coco
from artrec_ros.io.learned.constraints import load_constraints
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.io.truth.records import load_truth

CONFIG = Path(__file__).parents[2] / "config"
COCO = {"images": [], "annotations": [], "categories": []}
RESULT = {"stamp_ns": 1, "frame": "x", "objects": [], "rejected": []}
FILES = {
    "object.yaml": "an object file",
    "constraints.yaml": "a constraint file",
    "parameters.yaml": "a parameter file (ros__parameters)",
    "coco.json": "a COCO file",
    "camera.yaml": "a camera calibration",
    "metadata.yaml": "a bag's metadata.yaml",
    "replay.json": "the plan of a replay",
}
READERS = {
    "an object file": load_object,
    "a constraint file": lambda path: load_constraints(path, load_object(CONFIG / "objects" / "excavator.yaml", {})),
    "a parameter file (ros__parameters)": load_parameters,
    "a COCO file": lambda path: load_coco([path]),
    "a camera calibration": load_camera,
}


@pytest.fixture
def files(tmp_path):
    shutil.copy(CONFIG / "objects" / "excavator.yaml", tmp_path / "object.yaml")
    shutil.copy(CONFIG / "constraints" / "excavator.yaml", tmp_path / "constraints.yaml")
    shutil.copy(CONFIG / "excavator.yaml", tmp_path / "parameters.yaml")
    (tmp_path / "coco.json").write_text(json.dumps(COCO))
    (tmp_path / "camera.yaml").write_text("image_width: 8\nimage_height: 6\ncamera_matrix: {}\n")
    (tmp_path / "metadata.yaml").write_text("rosbag2_bagfile_information: {version: 9}\n")
    (tmp_path / "replay.json").write_text('{"format": "artrec_replay/1"}')
    return tmp_path


@pytest.mark.parametrize("name", FILES)
@pytest.mark.parametrize("wanted", READERS)
def test_a_file_in_anothers_place_is_called_what_it_is(files, name, wanted):
    if FILES[name] == wanted:
        return
    with pytest.raises(ArtrecError) as caught:
        READERS[wanted](files / name)
    message = str(caught.value)
    assert message.startswith(f"{files / name}: is {FILES[name]}; {wanted} is wanted here") and "\n" not in message


def test_results_are_no_truth(tmp_path):
    (tmp_path / "detections.jsonl").write_text(json.dumps(RESULT) + "\n")
    with pytest.raises(ArtrecError, match=r"is a result of a replay \(detections.jsonl\); truth"):
        load_truth(tmp_path / "detections.jsonl")
