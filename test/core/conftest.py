"""What is found in a small image of a crane, stage by stage."""

from types import SimpleNamespace

import pytest
from cranes import BLANK, BLUE, CONFIG, CRANE, CRANES, RED, SHAPE_OF, crane_scene
from scene import crane

from artrec_ros.core.alignment.matching import Matches, find_matches
from artrec_ros.core.alignment.placements import Placements
from artrec_ros.core.alignment.starts import find_starts
from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.geometry.range_limits import scale_limits
from artrec_ros.core.grouping.candidates import Candidates, Roles, candidates_of
from artrec_ros.core.model.target import Target


@pytest.fixture(scope="module")
def scene() -> SimpleNamespace:
    return crane_scene()


@pytest.fixture(scope="module")
def starts(scene: SimpleNamespace) -> Placements:
    wanted, scales = {*CRANES, (3, BLUE)}, scale_limits(CONFIG, None)
    return find_starts(scene.blobs, scene.cmap, scene.shapes, wanted, CONFIG, Deadline(), scales)


@pytest.fixture(scope="module")
def matches(scene: SimpleNamespace) -> Matches:
    scales = scale_limits(CONFIG, None)
    return find_matches(scene.blobs, scene.cmap, scene.shapes[:3], CRANES, CONFIG, Deadline(), BLANK, scales)


@pytest.fixture(scope="module")
def candidates(matches: Matches) -> Candidates:
    return candidates_of(Roles.of(Target("crane", crane(), RED, CRANE), SHAPE_OF), matches, CONFIG)
