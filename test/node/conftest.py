"""Each run of the tests has a ROS graph and logs of its own."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from hypothesis import settings

from artrec_ros.io.parameters.parameter_file import Setup, load_parameters

settings.register_profile("nightly", max_examples=20_000)

# Tests have several participants in one process. Where Fast DDS delivers among them by calling from one into the other,
# two threads that each take down an entity can wait for each other's locks for ever.
NO_CALLS_BETWEEN_PARTICIPANTS = """<?xml version="1.0" encoding="UTF-8"?>
<dds xmlns="http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles">
  <library_settings><intraprocess_delivery>OFF</intraprocess_delivery></library_settings>
</dds>
"""


@pytest.fixture(scope="session", autouse=True)
def ros_environment(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    profile = tmp_path_factory.mktemp("dds") / "profile.xml"
    profile.write_text(NO_CALLS_BETWEEN_PARTICIPANTS, encoding="utf-8")
    own = {
        "ROS_DOMAIN_ID": str(1 + os.getpid() % 100),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_LOG_DIR": str(tmp_path_factory.mktemp("ros_log")),
        "ROS_PYTHON_CHECK_FIELDS": "1",
        "FASTRTPS_DEFAULT_PROFILES_FILE": str(profile),
    }
    with pytest.MonkeyPatch.context() as patch:
        for name, value in own.items():
            patch.setenv(name, value)
        yield


@pytest.fixture(scope="session")
def parameter_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    import toy

    return toy.write_files(tmp_path_factory.mktemp("toy") / "config")


@pytest.fixture(scope="session", autouse=True)
def compiled(parameter_file: Path) -> None:
    """What is compiled at first use is so, and kept, before any node has to start in time."""
    load_parameters(parameter_file).build()


@pytest.fixture(scope="session")
def setup(parameter_file: Path) -> Setup:
    return load_parameters(parameter_file)


@pytest.fixture
def picture(setup: Setup) -> np.ndarray:
    """A label image with one toy in it."""
    import toy

    return toy.draw(setup.targets[0].model, 0.05, 0.02, 0.6)
