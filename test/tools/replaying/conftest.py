"""What replays run with."""

from __future__ import annotations

import pytest
from arm_replays import OBJECT, PARAMETERS, Recogniser, params_of

from artrec_ros.io.parameters.parameter_file import Setup


@pytest.fixture
def params(tmp_path):
    (tmp_path / "arm.yaml").write_text(OBJECT)
    return params_of(tmp_path / "params.yaml", **PARAMETERS)


@pytest.fixture
def recogniser(monkeypatch):
    made = Recogniser()
    monkeypatch.setattr(Setup, "build", lambda self, **how: made)
    return made
