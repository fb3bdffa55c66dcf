"""Pictures of robots, and a sitting in which their colours were taught, once for all tests of the studio."""

from __future__ import annotations

import pytest
from studio_pictures import Pictures, write_pictures
from studio_sitting import begun, mark_colours

from artrec_ros.tools.studio_state.session import Session


@pytest.fixture(scope="session")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Pictures:
    return write_pictures(tmp_path_factory.mktemp("robots"), 6)


@pytest.fixture(scope="session")
def taught(pictures: Pictures, tmp_path_factory: pytest.TempPathFactory) -> Session:
    """A sitting in which the colours were clicked on and saved."""
    session = begun(pictures, tmp_path_factory.mktemp("taught") / "studio")
    marks = mark_colours(pictures, session)
    marks.keep(marks.learn())
    return session
