"""Examples in `artrec studio`: axes are drawn, proposals accepted, mended and rejected."""

from __future__ import annotations

import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from studio_pictures import Pictures
from studio_sitting import again, begun

from artrec_ros.core.base.errors import ArtrecError, SourceError
from artrec_ros.io.learned.annotations import axis_px, instance_from_axis, load_coco
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.io.sources.opening import SourceOptions
from artrec_ros.io.truth.from_coco import load_coco_truth
from artrec_ros.tools.studio_state.examples import Examples, rigid_points
from artrec_ros.tools.studio_state.marking import Marking
from artrec_ros.tools.studio_state.session import Session, load_setup
from artrec_ros.tools.studio_state.stills import open_stills

ROOT = Path(__file__).resolve().parents[3]


def test_an_axis_and_its_instance_say_the_same() -> None:
    marker = load_object(ROOT / "config/objects/mirosot.yaml").component("left").markers[0]
    tail, head = np.array([20.0, 31.5]), np.array([44.0, 12.0])
    np.testing.assert_allclose(axis_px(marker, instance_from_axis("left", marker, tail, head)), [tail, head], atol=1e-9)


def test_one_axis_places_what_is_rigid_with_it(pictures: Pictures, tmp_path: Path) -> None:
    session = begun(pictures, tmp_path / "studio")
    model = session.setup.targets[0].model
    for number in range(3):
        for robot in pictures.axes(number):
            points = rigid_points(model, ("team", "team"), *robot["team"])
            for end, at in zip(("tail", "head"), robot["accent"], strict=True):
                assert np.linalg.norm(points[f"accent/accent.{end}"] - at) < 1.5


def test_joints_part_what_is_rigid() -> None:
    model = load_object(ROOT / "config/objects/excavator.yaml")
    required = model.required
    points = rigid_points(model, (required.name, required.markers[0].name), np.zeros(2), np.array([50.0, 0.0]))
    moving = {c.name for c in model.joint_components}
    assert moving and not {name.partition("/")[0] for name in points} & moving


def test_what_the_recogniser_proposes_lies_on_the_robots(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    session = again(taught, tmp_path, pictures)
    examples = Examples(session)
    marking = Marking(session, examples)
    marking.look_at(3)
    assert marking.propose(session.recognise(3)) >= 2
    assert not examples.path.exists(), "a proposal is no example yet"
    truth = [np.mean(r["team"], axis=0) for r in pictures.axes(3)]
    for proposal in marking.proposals:
        middle = (proposal.points["team/team.tail"] + proposal.points["team/team.head"]) / 2
        assert min(np.linalg.norm(middle - t) for t in truth) < 2
    assert proposal.by_machine


def test_accepted_proposals_are_the_machines_until_somebody_mends_them(
    pictures: Pictures, taught: Session, tmp_path: Path
) -> None:
    session = again(taught, tmp_path, pictures)
    examples = Examples(session)
    marking = Marking(session, examples)
    for number in (3, 4):
        marking.look_at(number)
        marking.propose(session.recognise(number))
        marking.accept_all()
    with pytest.raises(SourceError, match="recogniser made"):
        load_coco_truth(examples.path)
    marking.look_at(3)
    count = len(examples.objects)
    for o in examples.of(3):
        marking.choose(np.mean([*o.points.values()], axis=0))
        assert marking.chosen is o
        end = o.points["team/team.head"]
        marking.drag(end, end + (1.0, 0.5))
        np.testing.assert_allclose(marking.chosen.points["team/team.head"], end + (1.0, 0.5))
    assert len(examples.objects) == count
    assert marking.propose(session.recognise(3)) == 0, "what is marked is not proposed again"
    truth = load_coco_truth(examples.path)
    assert list(truth.frames) == ["03.png"] and truth.left_out == 1
    assert [o.by_machine for o in load_coco([examples.path]).objects].count(True) == count - len(examples.of(3))


def test_rejecting_takes_away_and_keys_walk_through_the_proposals(
    pictures: Pictures, taught: Session, tmp_path: Path
) -> None:
    session = again(taught, tmp_path, pictures)
    marking = Marking(session, Examples(session))
    found = marking.propose(session.recognise(0))
    marking.reject()
    marking.accept()
    assert len(marking.proposals) == found - 2 and len(marking.examples.of(0)) == 1
    marking.choose(np.mean([*marking.examples.of(0)[0].points.values()], axis=0))
    marking.reject()
    assert not marking.examples.of(0)
    marking.nothing_here()
    assert Examples(session).is_marked(0), "an empty frame counts as looked at, in the next sitting, too"
    assert load_coco_truth(marking.examples.path).frames == {"00.png": ()}


def test_axes_are_drawn_one_after_the_other_where_nothing_follows(tmp_path: Path) -> None:
    (tmp_path / "frames").mkdir()
    cv2.imwrite(str(tmp_path / "frames/0.png"), np.zeros((80, 100, 3), np.uint8))
    stills = open_stills(tmp_path / "frames", SourceOptions(), 9, tmp_path / "studio/frames", print)
    given = (ROOT / "config/vss.yaml",)
    session = Session(stills, tmp_path / "studio", given, load_setup(given, tmp_path / "studio"))
    marking = Marking(session, Examples(session))
    assert marking.next_key == ("team", "patch")
    marking.drag(np.array([10.0, 10.0]), np.array([20.0, 10.0]))
    assert marking.next_key == ("accent", "patch") and marking.drawn is not None
    marking.drag(np.array([20.0, 21.0]), np.array([30.0, 20.0]))
    assert marking.drawn is None and marking.next_key == ("team", "patch")
    marking.drag(np.array([50.0, 50.0]), np.array([60.0, 50.0]))
    marking.skip()
    assert marking.drawn is None and [len(o.points) for o in marking.examples.objects] == [4, 2]
    again = Examples(session).objects
    assert [sorted(o.points) for o in again] == [sorted(o.points) for o in marking.examples.objects]


def test_what_is_drawn_beside_an_object_leaves_it_where_it_is(
    pictures: Pictures, taught: Session, tmp_path: Path
) -> None:
    session = again(taught, tmp_path, pictures)
    marking = Marking(session, Examples(session))
    corner = np.array([60.0, 40.0])
    marking.drag(np.array([40.0, 40.0]), corner)
    marking.drag(corner + (1.0, 0.0), np.array([80.0, 41.0]))
    first, second = marking.examples.of(0)
    np.testing.assert_array_equal(first.points["team/team.head"], corner)
    np.testing.assert_array_equal(second.points["team/team.tail"], corner + (1.0, 0.0))
    marking.choose(np.mean([*first.points.values()], axis=0))
    marking.drag(corner, corner + (0.0, 3.0))
    np.testing.assert_array_equal(marking.examples.of(0)[0].points["team/team.head"], corner + (0.0, 3.0))
    assert len(marking.examples.of(0)) == 2


def test_the_first_marker_may_be_the_one_that_is_hidden(tmp_path: Path) -> None:
    (tmp_path / "frames").mkdir()
    cv2.imwrite(str(tmp_path / "frames/0.png"), np.zeros((80, 100), np.uint8))
    stills = open_stills(tmp_path / "frames", SourceOptions(), 9, tmp_path / "studio/frames", print)
    given = (ROOT / "config/aibo.yaml",)
    marking = Marking(*_with_examples(Session(stills, tmp_path / "studio", given, load_setup(given, tmp_path))))
    hidden = marking.next_key
    marking.skip()
    seen = marking.next_key
    assert hidden is not None and seen is not None and seen != hidden and seen[0] == hidden[0]
    marking.drag(np.array([10.0, 10.0]), np.array([30.0, 10.0]))
    assert {name.rpartition(".")[0] for name in marking.examples.objects[0].points} == {"/".join(seen)}
    marking.finish()
    assert marking.next_key == hidden
    for _ in range(20):
        marking.skip()
        assert marking.next_key is not None, "where all are skipped, it begins anew"


def _with_examples(session: Session) -> tuple[Session, Examples]:
    return session, Examples(session)


def test_examples_that_fit_no_object_are_named(pictures: Pictures, tmp_path: Path) -> None:
    content = {
        "images": [{"id": 1, "file_name": "00.png"}],
        "categories": [{"id": 1, "name": "robot", "keypoints": ["wheel/rim.tail", "wheel/rim.head"]}],
        "annotations": [{"id": 1, "image_id": 1, "category_id": 1, "keypoints": [1, 2, 2, 3, 4, 2]}],
    }
    (tmp_path / "coco.json").write_text(json.dumps(content))
    with pytest.raises(ArtrecError, match=r"coco.json.*wheel/rim.tail.*robot"):
        Examples(begun(pictures, tmp_path / "studio"), [tmp_path / "coco.json"])
