"""What `artrec studio` shows of objects and of failed frames."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from studio_pictures import Pictures
from studio_sitting import again

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.model.target import Target
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.tools.main import main
from artrec_ros.tools.studio_state.examples import Examples
from artrec_ros.tools.studio_state.failures import load_failures
from artrec_ros.tools.studio_state.object_views import joint_ranges, joint_units, middle, outlines, picture
from artrec_ros.tools.studio_state.session import Session

ROOT = Path(__file__).resolve().parents[3]


def test_failed_frames_lead_to_frames(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    session = again(taught, tmp_path, pictures)
    examples = Examples(session)
    for robot in pictures.axes(4):
        examples.new(4, session.setup.targets[0], ("team", "team"), *robot["team"])
    examples.new(4, session.setup.targets[0], ("team", "team"), np.array([5.0, 5.0]), np.array([30.0, 5.0]))  # none
    result = tmp_path / "result"
    arguments = [str(pictures.source), "--params-file", str(session.parameters), "--no-video", "-o", str(result)]
    assert main(["replay", *arguments]) == 0
    with pytest.raises(ConfigError, match="no scores there"):
        load_failures(result, None, session.stills)
    assert main(["evaluate", str(result), "--truth", str(examples.path), "--no-page"]) == 0
    (shown,) = load_failures(result, None, session.stills)
    assert shown.number == 4 and shown.key == "04.png" and shown.card.picture.startswith("data:image/webp")
    assert any(reason.startswith("missed robot: no candidate near it") for reason in shown.reasons)


def test_outlines_of_the_object_file_lie_on_the_marked_patches(
    pictures: Pictures, taught: Session, tmp_path: Path
) -> None:
    session = again(taught, tmp_path, pictures)
    examples = Examples(session)
    target = session.setup.targets[0]
    robot = examples.new(2, target, ("team", "team"), *pictures.axes(2)[0]["team"])
    places = {name: outline.mean(axis=0) for name, outline in outlines(robot, target)}
    for component, name in (("team", "team/team"), ("accent", "accent/accent")):
        assert min(np.linalg.norm(places[name] - m) for m in pictures.middles(2, component)) < 1.5


def test_an_object_is_drawn_with_its_joints_where_they_are_put() -> None:
    target = Target("excavator", load_object(ROOT / "config/objects/excavator.yaml", {}), 2)
    ranges = joint_ranges(target)
    name = next(iter(ranges))
    drawn = [picture(target, middle(target) | {name: value}, -40, 35) for value in ranges[name]]
    assert drawn[0] is not None and drawn[0].shape == drawn[1].shape and (drawn[0] != drawn[1]).any()
    assert middle(target).keys() == ranges.keys() and joint_units(target) == dict.fromkeys(ranges, "rad")
    flat = Target("vss", load_object(ROOT / "config/objects/vss.yaml", {}), 2)
    assert picture(flat, {}, 0, 0) is None, "its file does not say where the markers sit"
