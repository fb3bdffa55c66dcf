"""What `artrec studio` does behind its pages: marks become files that the commands read, and what these learn."""

from __future__ import annotations

import dataclasses
import json
from pathlib import Path

import cv2
import numpy as np
import pytest
from studio_pictures import Pictures, write_pictures

from artrec_ros.core.base.errors import ArtrecError, ConfigError, SourceError
from artrec_ros.core.model.found import FrameResult
from artrec_ros.core.model.target import Target
from artrec_ros.io.images.decoding import read_image
from artrec_ros.io.learned.annotations import axis_px, instance_from_axis, load_coco
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.io.sources.opening import SourceOptions
from artrec_ros.io.truth.from_coco import load_coco_truth
from artrec_ros.tools.main import main
from artrec_ros.tools.studio_state.colour_marks import BACKGROUND, ColourMarks, box_between, patch_around
from artrec_ros.tools.studio_state.doubts import doubt_of, ranked
from artrec_ros.tools.studio_state.examples import Examples, rigid_points
from artrec_ros.tools.studio_state.failures import load_failures
from artrec_ros.tools.studio_state.marking import Marking
from artrec_ros.tools.studio_state.object_views import joint_ranges, middle, outlines, picture
from artrec_ros.tools.studio_state.session import Session, load_setup
from artrec_ros.tools.studio_state.settings import Settings, read_list
from artrec_ros.tools.studio_state.stills import open_stills
from artrec_ros.tools.studio_state.training import keep_scale_limits, learn_colours, train_examples

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def pictures(tmp_path_factory: pytest.TempPathFactory) -> Pictures:
    return write_pictures(tmp_path_factory.mktemp("robots"), 6)


def begun(pictures: Pictures, folder: Path) -> Session:
    stills = open_stills(pictures.source, SourceOptions(), 100, folder / "frames", print)
    given = (pictures.parameters,)
    return Session(stills, folder, given, load_setup(given, folder))


def mark_colours(pictures: Pictures, session: Session, frames: tuple[int, ...] = (0, 1)) -> ColourMarks:
    marks = ColourMarks(session)
    for number in frames:
        image = session.stills.image(number)
        for name in ("team", "accent"):
            for place in pictures.middles(number, name):
                marks.add(number, name, patch_around(image, *place))
        for corner in ((0, 0), (200, 150)):
            marks.add(number, BACKGROUND, box_between(corner, (corner[0] + 40, corner[1] + 40)))
    return marks


@pytest.fixture(scope="module")
def taught(pictures: Pictures, tmp_path_factory: pytest.TempPathFactory) -> Session:
    """A sitting in which the colours were clicked on and saved."""
    session = begun(pictures, tmp_path_factory.mktemp("taught") / "studio")
    marks = mark_colours(pictures, session)
    marks.keep(marks.learn())
    return session


def again(session: Session, tmp_path: Path, pictures: Pictures) -> Session:
    """Another sitting, begun with the colours of this one."""
    folder = tmp_path / "studio"
    folder.mkdir()
    (folder / "params.yaml").write_text(session.parameters.read_text().replace("../../", f"{pictures.folder.parent}/"))
    return begun(pictures, folder)


def test_a_click_takes_what_is_of_one_colour_and_hangs_together() -> None:
    image = np.full((40, 60, 3), 40, np.uint8)
    image[10:20, 10:24] = (30, 40, 200)
    image[10:20, 30:44] = (30, 40, 200)  # like it, but apart
    outline = patch_around(image, 12.3, 14.9)
    assert outline.min(axis=0).tolist() == [10, 10] and outline.max(axis=0).tolist() == [23, 19]
    assert np.ptp(patch_around(image, 50, 35), axis=0).max() <= 24, "a background is taken near the click alone"
    with pytest.raises(ConfigError, match="outside the image of 60x40"):
        patch_around(image, 60, 3)


def test_a_single_pixel_is_a_region_too() -> None:
    image = np.zeros((9, 9, 3), np.uint8)
    image[4, 4] = 255
    outline = patch_around(image, 4, 4)
    assert outline.shape == (4, 2) and (outline == 4).all()


def test_colours_are_those_of_the_command(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    written = tmp_path / "colours.yaml"
    regions = str(taught.folder / "regions.json")
    assert main(["learn-colours", "--annotations", regions, "--classes", "team=2", "accent=3", "-o", str(written)]) == 0
    assert written.read_text() == (taught.folder / "colours.yaml").read_text()
    by_command = load_parameters(pictures.parameters, written)
    assert taught.setup.image == by_command.image == load_parameters(taught.parameters).image


def test_a_persons_comments_stay_in_the_parameter_file(taught: Session) -> None:
    assert "# what is looked for" in taught.parameters.read_text()


def test_a_preview_shows_the_classes_that_have_enough(pictures: Pictures, tmp_path: Path) -> None:
    session = begun(pictures, tmp_path / "studio")
    marks = ColourMarks(session)
    with pytest.raises(ConfigError, match="nothing is marked yet"):
        marks.preview()
    for place in pictures.middles(0, "team"):
        marks.add(0, "team", patch_around(session.stills.image(0), *place))
    marks.add(0, BACKGROUND, box_between((0, 0), (40, 40)))
    preview = marks.preview()
    assert preview.lacking == {"accent": 20}
    assert preview.learned is not None and list(preview.learned.image.classes) == ["team"]
    with pytest.raises(ConfigError, match="class 'accent': 0 pixels"):
        marks.learn()


def test_marks_are_there_again_in_the_next_sitting(pictures: Pictures, tmp_path: Path) -> None:
    before = mark_colours(pictures, begun(pictures, tmp_path / "studio"), (1,))
    after = ColourMarks(begun(pictures, tmp_path / "studio"))
    assert [p.name for p in after.of(1)] == [p.name for p in before.of(1)] and not after.of(0)
    place = pictures.middles(1, "team")[0]
    found = after.at(1, *place)
    assert found is not None and found.name == "team"
    after.remove(found)
    assert len(ColourMarks(begun(pictures, tmp_path / "studio")).patches) == len(before.patches) - 1


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
    assert marking.next_key == ("accent", "patch") and marking.drawn is not None and marking.drawn.incomplete
    marking.drag(np.array([20.0, 21.0]), np.array([30.0, 20.0]))
    assert marking.drawn is None and marking.next_key == ("team", "patch")
    marking.drag(np.array([50.0, 50.0]), np.array([60.0, 50.0]))
    marking.skip()
    assert marking.drawn is None and [o.incomplete for o in marking.examples.objects] == [False, True]
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


def test_training_is_that_of_the_command(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    session = again(taught, tmp_path, pictures)
    examples = Examples(session)
    with pytest.raises(ConfigError, match="no example is marked yet"):
        train_examples(session, examples)
    target = session.setup.targets[0]
    for number in range(4):
        for robot in pictures.axes(number):
            examples.new(number, target, ("team", "team"), *robot["team"])
    trained = train_examples(session, examples)
    written = tmp_path / "by_command.yaml"
    arguments = ["--object", str(pictures.folder / "robot.yaml"), "--annotations", str(examples.path)]
    assert main(["train", *arguments, "-o", str(written)]) == 0
    assert trained.written[0].read_text() == written.read_text()
    assert "robot: 1 pairs, the first constraints" in trained.changes
    assert load_parameters(session.parameters).targets[0].constraints is not None
    examples.with_axis(examples.objects[0], ("accent", "accent"), np.array([9.0, 9.0]), np.array([30.0, 9.0]))
    assert any("accent/accent: distance_m" in line for line in train_examples(session, examples).changes)


def test_examples_that_fit_no_object_are_named(pictures: Pictures, tmp_path: Path) -> None:
    content = {
        "images": [{"id": 1, "file_name": "00.png"}],
        "categories": [{"id": 1, "name": "robot", "keypoints": ["wheel/rim.tail", "wheel/rim.head"]}],
        "annotations": [{"id": 1, "image_id": 1, "category_id": 1, "keypoints": [1, 2, 2, 3, 4, 2]}],
    }
    (tmp_path / "coco.json").write_text(json.dumps(content))
    with pytest.raises(ArtrecError, match=r"coco.json.*wheel/rim.tail.*robot"):
        Examples(begun(pictures, tmp_path / "studio"), [tmp_path / "coco.json"])


def test_frames_in_which_objects_are_missing_come_first(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    session = again(taught, tmp_path, pictures)
    full = session.recognise(1)
    none = dataclasses.replace(full, detections=())
    parts = {"robot": 2}
    assert doubt_of(0, none, 3, parts).why == "3 of the usual 3 objects missing"
    assert doubt_of(0, none, 3, parts).worth > doubt_of(0, full, 3, parts).worth
    assert doubt_of(0, FrameResult((3, 3)), 0, parts).worth == 0
    half = dataclasses.replace(full.detections[0], components=full.detections[0].components[:1], score=1.0, margin=1.0)
    doubt = doubt_of(0, dataclasses.replace(full, detections=(half,)), 1, parts)
    assert doubt.why.endswith("1 of the usual 2 components") and doubt.worth == 0.5
    shares: list[float] = []
    examples = Examples(session)
    examples.set_empty(2)
    order = ranked(session, examples, shares.append)
    assert {d.number for d in order} == {0, 1, 3, 4, 5} and shares[-1] == 1
    assert [d.worth for d in order] == sorted((d.worth for d in order), reverse=True)


def test_settings_are_tried_and_kept(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    session = again(taught, tmp_path, pictures)
    settings = Settings(session)
    assert "recognizer.min_probability" in settings.specs() and "expert.fit.steps" not in settings.changes
    settings.change("recognizer.min_probability", 0.97)
    before, after = settings.both(0, lambda share: None)
    assert len(after.detections) <= len(before.detections)
    with pytest.raises(ConfigError, match="min_probability"):
        settings.change("recognizer.min_probability", 1.5)
    assert settings.value("recognizer.min_probability") == 0.97
    settings.save()
    assert not settings.changes
    assert load_parameters(session.parameters).recognizer.min_probability == 0.97
    settings.change("recognizer.min_probability", 0.97)
    assert not settings.changes, "the session's own value is no change"


def test_scores_are_those_of_frames_marked_by_hand(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    session = again(taught, tmp_path, pictures)
    settings = Settings(session)
    with pytest.raises(ConfigError, match="no frame is marked"):
        settings.scored(lambda share: None)
    examples = Examples(session)
    for number in (4, 5):
        for robot in pictures.axes(number):
            examples.new(number, session.setup.targets[0], ("team", "team"), *robot["team"])
    (first, *_) = [line for line in settings.scored(lambda share: None) if "frames," in line]
    assert first.startswith("2 frames, 6 objects in view, ") and int(first.split(", ")[2].split()[0]) >= 4
    settings.change("recognizer.min_probability", 0.9)
    assert any("after" in line for line in settings.scored(lambda share: None))


@pytest.mark.parametrize(("text", "values"), [("1, 2", [1, 2]), ("[0.5, a]", [0.5, "a"]), ("", [])])
def test_lists_are_read_as_people_write_them(text: str, values: list[object]) -> None:
    assert read_list(text) == values


def test_a_list_that_is_none_is_told() -> None:
    with pytest.raises(ConfigError, match="is no list"):
        read_list("1, {")


def test_a_bag_becomes_files_that_are_taken_again(tmp_path: Path) -> None:
    simulated = ["simulate", str(ROOT / "config/objects/excavator.yaml"), "--frames", "5", "-o", str(tmp_path / "sim")]
    assert main(simulated) == 0
    said: list[str] = []
    options = SourceOptions(image_kind="labels")
    stills = open_stills(tmp_path / "sim/bag", options, 3, tmp_path / "frames", said.append)
    assert len(stills) == 3 and stills.camera is not None and len(said) == 1
    assert stills.stamps_ns[0] >= 1_700_000_000_000_000_000, "files are named by their stamps"
    np.testing.assert_array_equal(stills.image(0), read_image(tmp_path / "sim/images/0000.png"))
    taken = open_stills(tmp_path / "sim/bag", options, 3, tmp_path / "frames", said.append)
    assert len(said) == 1 and taken.files == stills.files and taken.camera is not None


def test_a_video_is_a_source(tmp_path: Path) -> None:
    writer = cv2.VideoWriter(str(tmp_path / "film.mp4"), cv2.VideoWriter.fourcc(*"mp4v"), 10.0, (64, 48))
    for level in range(6):
        writer.write(np.full((48, 64, 3), 40 * level, np.uint8))
    writer.release()
    stills = open_stills(tmp_path / "film.mp4", SourceOptions(), 3, tmp_path / "frames", print)
    assert stills.stamps_ns == [0, 200_000_000, 400_000_000]
    assert abs(float(stills.image(2).mean()) - 160) < 6


@pytest.mark.parametrize("name", ["none", "none.mp4"])
def test_a_source_that_is_not_there_is_named(name: str, tmp_path: Path) -> None:
    with pytest.raises(SourceError, match=name):
        open_stills(tmp_path / name, SourceOptions(), 3, tmp_path / "frames", print)


def test_examples_give_colours_and_limits_of_the_scale(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    session = again(taught, tmp_path, pictures)
    examples = Examples(session)
    for learn in (learn_colours, keep_scale_limits):
        with pytest.raises(ConfigError, match="no example is marked yet"):
            learn(session, examples)
    for number in (0, 1):
        for robot in pictures.axes(number):
            examples.new(number, session.setup.targets[0], ("team", "team"), *robot["team"])
    lines = learn_colours(session, examples)
    written = tmp_path / "by_command.yaml"
    arguments = ["--annotations", str(examples.path), "--params-file", str(pictures.parameters)]
    assert main(["learn-colours", *arguments, "-o", str(written)]) == 0
    assert written.read_text() == (session.folder / "colours.yaml").read_text()
    low, high = keep_scale_limits(session, examples)
    kept = load_parameters(session.parameters).recognizer
    assert (kept.min_scale, kept.max_scale) == (low, high)
    assert f"recognizer.min_scale {low:.4g} and max_scale {high:.4g}" in lines[-1]


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
    assert middle(target).keys() == ranges.keys()
    flat = Target("vss", load_object(ROOT / "config/objects/vss.yaml", {}), 2)
    assert picture(flat, {}, 0, 0) is None, "its file does not say where the markers sit"


def test_label_images_have_no_colours_to_learn(pictures: Pictures, tmp_path: Path) -> None:
    text = pictures.parameters.read_text().replace("kind: colour", "kind: palette")
    given = (pictures.folder / "palette.yaml",)
    given[0].write_text(text.replace("{label: 2}\n      acc", "{label: 2, rgb: [1, 2, 3]}\n      acc").replace(
        "accent: {label: 3}", "accent: {label: 3, rgb: [200, 2, 3]}"
    ))  # fmt: skip
    stills = open_stills(pictures.source, SourceOptions(), 9, tmp_path / "frames", print)
    with pytest.raises(ConfigError, match="image.kind is 'palette'"):
        ColourMarks(Session(stills, tmp_path, given, load_setup(given, tmp_path)))


def test_constraint_files_need_not_be_there_yet(pictures: Pictures, tmp_path: Path) -> None:
    given = pictures.folder / "with_constraints.yaml"
    text = pictures.parameters.read_text().replace("robot.yaml,", "robot.yaml, constraint_file: none.yaml,")
    given.write_text(text)
    assert load_setup((given,), tmp_path).targets[0].constraints is None
    given.write_text(text.replace("constraint_file", "constraints_file"))
    with pytest.raises(ConfigError, match="robot.constraints_file"):
        load_setup((given,), tmp_path)
