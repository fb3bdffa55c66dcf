"""Each run of the tests has a ROS graph and logs of its own."""

from __future__ import annotations

import fcntl
import os
import tempfile
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

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


def own_domain() -> tuple[int, IO[str]]:
    """A ROS domain that no other run of these tests on this machine has, and the open file that sees to it."""
    for i in range(100):
        domain = 1 + (os.getpid() + i) % 100
        lock = (Path(tempfile.gettempdir()) / f"artrec_ros_test_domain_{domain}_{os.getuid()}").open("w")
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            lock.close()
        else:
            return domain, lock
    raise RuntimeError("all 100 ROS domains are taken by other runs of these tests")


@pytest.fixture(scope="session", autouse=True)
def ros_environment(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    profile = tmp_path_factory.mktemp("dds") / "profile.xml"
    profile.write_text(NO_CALLS_BETWEEN_PARTICIPANTS, encoding="utf-8")
    domain, lock = own_domain()
    own = {
        "ROS_DOMAIN_ID": str(domain),
        "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST",
        "ROS_LOG_DIR": str(tmp_path_factory.mktemp("ros_log")),
        "ROS_PYTHON_CHECK_FIELDS": "1",
        "FASTRTPS_DEFAULT_PROFILES_FILE": str(profile),
    }
    with lock, pytest.MonkeyPatch.context() as patch:
        for name, value in own.items():
            patch.setenv(name, value)
        yield


@pytest.fixture(scope="session")
def parameter_file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    import toy

    return toy.write_files(tmp_path_factory.mktemp("toy") / "config")


@pytest.fixture(scope="session", autouse=True)
def compiled(parameter_file: Path) -> None:
    """What is compiled at first use is so, and kept, before any node has to start and answer in time."""
    import toy

    setup = load_parameters(parameter_file)
    recognizer = setup.build()
    for camera in (None, toy.CAMERA):
        recognizer.recognize(toy.draw(setup.targets[0].model, 0.05, 0.02, 0.6), camera)


@pytest.fixture(scope="session")
def setup(parameter_file: Path) -> Setup:
    return load_parameters(parameter_file)


@pytest.fixture
def picture(setup: Setup) -> np.ndarray:
    """A label image with one toy in it."""
    import toy

    return toy.draw(setup.targets[0].model, 0.05, 0.02, 0.6)


@pytest.fixture
def node(parameter_file: Path) -> Iterator[Any]:
    """An active node in this process; nothing spins it, images are handed to it."""
    from lone_node import alone

    with alone(parameter_file) as node:
        yield node
