"""A bag of five frames of a crane, and the recording of its replay."""

from __future__ import annotations

import pytest
import yaml
from rerun_recording import CAMERA, OBJECT, PARAMETERS, STAMPS, Recogniser, Recording, picture, run

from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.io.parameters.parameter_file import Setup


@pytest.fixture
def params(tmp_path, monkeypatch):
    made = Recogniser()
    monkeypatch.setattr(Setup, "build", lambda self, **how: made)
    (tmp_path / "crane.yaml").write_text(OBJECT)
    path = tmp_path / "params.yaml"
    path.write_text(yaml.safe_dump({"/**": {"ros__parameters": PARAMETERS}}))
    return path


@pytest.fixture
def bag(tmp_path):
    path = tmp_path / "bag"
    with BagWriter(path) as writer:
        for i, stamp in enumerate(STAMPS):
            writer.write_camera("/cam/camera_info", stamp, CAMERA)
            writer.write_image("/cam/image", stamp, "optical", picture(i))
    return path


@pytest.fixture
def recording(tmp_path, params, bag):
    pytest.importorskip("rerun", reason="rerun-sdk is not installed")
    assert run(params, tmp_path / "seen.rrd", bag) == 0
    return Recording(tmp_path / "seen.rrd")
