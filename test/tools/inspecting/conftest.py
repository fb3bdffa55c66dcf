"""The shipped files, for `artrec inspect` to look at."""

import shutil

import pytest
from inspections import CONFIG


@pytest.fixture
def config(tmp_path):
    """The shipped excavator, where it can be changed."""
    shutil.copytree(CONFIG, tmp_path / "config")
    return tmp_path / "config"
