"""Which frames and objects of truth and run belong together; half-written runs; truth that tells only a part."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError, SourceError
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.io.results.summary_file import LookedFor
from artrec_ros.io.truth.records import Told, TrueObject, Truth
from artrec_ros.tools.evaluation.assignment import Choice, choose_objects, match_frames, strangers
from artrec_ros.tools.evaluation.completion import slant_rad, with_components
from artrec_ros.tools.evaluation.runs import Run, load_run, load_runs, run_names
from artrec_ros.tools.evaluation.scoring import Options, evaluate_runs

from .makers import CAMERA, FACING, found_thing, pixel, pose_at, record, true_thing, write_run


def run_of(*stamps: int, objects=None, names=None) -> Run:
    records = [record(t, name=n) for t, n in zip(stamps, names or ["/c"] * len(stamps), strict=True)]
    return Run("r", "folder", tuple(records), objects or {"thing": LookedFor(2, "base")}, {})


def truth_of(*keys, objects=None) -> Truth:
    objects = (true_thing(),) if objects is None else objects
    return Truth({key: objects for key in keys}, "truth")


class TestFrames:
    def test_by_stamp(self):
        assert match_frames(truth_of(10, 20, 30), run_of(30, 10)) == {10: 1, 30: 0}

    def test_by_the_name_of_the_image(self):
        run = run_of(0, 1, names=["b.png", "a.png"])
        assert match_frames(truth_of("a.png", "c.png"), run) == {"a.png": 1}

    def test_frames_of_a_video_by_the_names_of_pictures_that_were_taken_from_it(self):
        run = run_of(0, 1, names=["film_000003", "a.film_000004"])
        truth = truth_of("film_000003.png", "a.film_000004.jpg", "film_000005.png")
        assert match_frames(truth, run) == {"film_000003.png": 0, "a.film_000004.jpg": 1}
        with pytest.raises(SourceError, match="no image of the truth"):  # points are the name's own
            match_frames(truth_of("film.a_000003", "film.a_000004"), run_of(0, names=["film"]))

    def test_the_nearest_within_the_gap_and_no_result_twice(self):
        found = match_frames(truth_of(0, 100, 104, 300), run_of(2, 103, 290, 999), max_gap_ns=5)
        assert found == {0: 0, 104: 1}  # 100 is near 103 too, but 104 is nearer
        assert match_frames(truth_of(0, 100), run_of(7), max_gap_ns=7) == {0: 0}
        assert match_frames(truth_of(0), run_of(2, 2), max_gap_ns=7) == {0: 1}, "of one stamp the last one counts"

    def test_nothing_in_common_says_how_many_and_how_far(self):
        with pytest.raises(
            SourceError, match=r"truth \(2 frames from 0\).*results' \(1 frames from 5000000100\).* 5 s"
        ):
            match_frames(truth_of(0, 100), run_of(5 * 10**9 + 100))
        with pytest.raises(SourceError, match=r"truth \(1, such as 'a.png'\).*\(1, such as 'c'\).*replay their folder"):
            match_frames(truth_of("a.png"), run_of(0))
        with pytest.raises(SourceError, match="the results hold no frame, the truth 1"):
            match_frames(truth_of(0), run_of())

    def test_of_a_video_it_is_told_how_its_frames_are_named_and_stamped(self):
        run = run_of(0, 10**8, names=["a.film_000000", "a.film_000001"])
        with pytest.raises(SourceError, match=r"such as 'a.film_000000'\); pictures of a video go by its name and the"):
            match_frames(truth_of("000000.png"), run)
        stamps = r"100 s apart; .* of a video are its own times, from 0: .* named like its frames \(a.film_000000.png\)"
        with pytest.raises(SourceError, match=stamps):
            match_frames(truth_of(1001 * 10**8), run)


class TestNames:
    two = {"red": LookedFor(3, "base"), "blue": LookedFor(2, "base")}

    def test_by_name_where_the_truth_has_the_runs_names(self):
        truth = truth_of(0, objects=(true_thing(name="red", label=9),))
        assert choose_objects(truth, run_of(0, objects=self.two))["red"] == Choice(name="red")

    def test_a_name_may_say_besides_which_one_it_is(self):
        """As learn-colours takes it: red_gr is a red one. What is an object's own name stays that."""
        objects = {name: LookedFor(3, "team") for name in ("red", "red_gv")}
        model = load_object(Path(__file__).parents[3] / "config/objects/mirosot.yaml")
        run = replace(run_of(0, objects=objects), models=dict.fromkeys(objects, model))
        truth = truth_of(0, objects=tuple(true_thing(name=n) for n in ("red_gr", "red_gv_vr", "red_gv", "red_big")))
        chosen = choose_objects(truth, run)
        names = {run: [o.name for o in choice.of(truth.frames[0])] for run, choice in chosen.items()}
        assert names == {"red": ["red_gr"], "red_gv": ["red_gv_vr", "red_gv"]}
        assert strangers(truth, chosen) == {"red_big": 1}

    def test_else_by_label(self):
        truth = truth_of(0, objects=(true_thing(name="car"),))
        chosen = choose_objects(truth, run_of(0, objects=self.two))
        assert chosen["blue"].of(truth.frames[0]) == list(truth.frames[0]) and not chosen["red"].of(truth.frames[0])

    def test_as_the_user_says(self):
        truth = truth_of(0, objects=(true_thing(name="car"), true_thing(name="van", label=7)))
        chosen = choose_objects(truth, run_of(0, objects=self.two), {"red": "van"})
        assert chosen == {"red": Choice(name="van")} and strangers(truth, chosen) == {"car": 1}
        assert choose_objects(truth, run_of(0, objects=self.two), {"red": "7"}) == {"red": Choice(label=7)}

    @pytest.mark.parametrize(
        ("names", "said"),
        [({"gren": "car"}, "'gren' is no object.*known: red, blue"), ({"red": "cra"}, "no objects 'cra'.*mean 'car'"),
         ({"red": "4"}, "no objects '4'")],
    )  # fmt: skip
    def test_unknown_names(self, names, said):
        with pytest.raises(SourceError, match=said):
            choose_objects(truth_of(0, objects=(true_thing(name="car"),)), run_of(0, objects=self.two), names)

    def test_nothing_in_common_says_what_to_write(self):
        truth = truth_of(0, objects=(true_thing(name="car", label=9),))
        with pytest.raises(SourceError, match=r"objects 'car'.*'red' \(label 3\).*--names red=car"):
            choose_objects(truth, run_of(0, objects=self.two))


class TestRuns:
    def test_a_run_that_was_killed_is_read_as_far_as_it_goes(self, tmp_path):
        folder = write_run(tmp_path / "r", [record(0, found_thing()), record(1)])
        (folder / "summary.json").unlink()
        lines = (folder / "detections.jsonl").read_text()
        (folder / "detections.jsonl").write_text(lines + lines[:50])
        run = load_run(folder)
        assert len(run.records) == 2 and run.objects == {"thing": LookedFor(2, "base")}
        assert "line 3, the last, is cut off: 2 frames" in run.notes[0] and "did not end" in run.notes[1]

    def test_a_damaged_line_within_is_an_error(self, tmp_path):
        folder = write_run(tmp_path / "r", [record(0), record(1)])
        lines = (folder / "detections.jsonl").read_text().splitlines(keepends=True)
        (folder / "detections.jsonl").write_text(lines[0] + lines[0][:50] + "\n" + lines[1])
        with pytest.raises(SourceError, match="line 2: no valid JSON at column 51"):
            load_run(folder)

    def test_an_interrupted_run_and_one_whose_object_file_is_gone_are_told(self, tmp_path):
        folder = write_run(tmp_path / "r", [record(0)])
        summary = json.loads((folder / "summary.json").read_text()) | {"interrupted": True}
        (folder / "summary.json").write_text(json.dumps(summary))
        (folder / "thing.yaml").unlink()
        run = load_run(folder)
        assert "interrupted" in run.notes[0] and "thing.yaml: there is no such file" in run.notes[1] and not run.models

    def test_no_run(self, tmp_path):
        with pytest.raises(SourceError, match="detections.jsonl: there is no such file"):
            load_run(tmp_path)
        (tmp_path / "detections.jsonl").write_text("")
        with pytest.raises(SourceError, match="summary.json: there is no such file.*folder of `artrec replay`"):
            load_run(tmp_path)
        (tmp_path / "summary.json").write_text("[]")
        with pytest.raises(ConfigError, match=r"summary.json: must be a mapping \{key: value\}, not \[\]"):
            load_run(tmp_path)
        (tmp_path / "summary.json").write_text("{")
        with pytest.raises(ConfigError, match="summary.json: line 1: is no valid JSON"):
            load_run(tmp_path)

    def test_names_tell_runs_apart_and_no_run_comes_twice(self, tmp_path):
        assert run_names([tmp_path / "a/x", tmp_path / "b/x"]) == ["a/x", "b/x"]
        assert run_names([tmp_path / "a", tmp_path / "b"]) == ["a", "b"]
        with pytest.raises(SourceError, match="given twice"):
            load_runs([tmp_path, tmp_path / "."])


class TestTruthOfAPart:
    @pytest.fixture
    def model(self, tmp_path):
        write_run(tmp_path / "r", [])
        return load_object(tmp_path / "r/thing.yaml")

    def test_a_pose_tells_how_much_of_the_required_component_is_in_view(self, model):
        o = TrueObject(None, pose_at(0.1), {}, None, "thing", told=Told.REQUIRED)
        seen = with_components(o, model, CAMERA)
        (part,) = seen.components.values()
        area_px = model.required.markers[0].area * 200**2
        assert part.full_px == pytest.approx(area_px, rel=1e-6) and part.visible_px == pytest.approx(area_px, rel=0.05)
        assert list(seen.centre_px) == pytest.approx([pixel(0.1), 59.5])
        half = with_components(replace(o, pose=pose_at(0.4)), model, CAMERA)  # its middle is 160 px: at the right edge
        (part,) = half.components.values()
        assert 0.3 < part.visible_px / part.full_px < 0.6

    def test_a_pose_from_behind_or_behind_the_camera_shows_nothing(self, model):
        away = TrueObject(None, Pose(np.eye(3), [0, 0, 1]), {}, None, told=Told.REQUIRED)
        assert not with_components(away, model, CAMERA).components
        behind = replace(away, pose=Pose(FACING, [0, 0, -1]))
        assert not with_components(behind, model, CAMERA).components

    @pytest.mark.parametrize("turn", [0.0, 0.5, 1.2])
    def test_slant_is_the_turn_away_from_the_camera(self, model, turn):
        pose = Pose(FACING @ Pose.from_xyz_rpy([0, 0, 0], [0, turn, 0]).rotation, [0, 0, 50.0])
        assert slant_rad(pose, model.required) == pytest.approx(turn, abs=2e-3)

    def test_annotated_axes_tell_place_and_area(self, model):
        axis = np.array([[60.0, 60.0], [100.0, 60.0]])  # 0.2 m: 200 px a metre
        o = with_components(TrueObject(None, None, {}, None, axes={"base/plate": axis}), model, None)
        part = o.components["base@plate"]
        assert part.full_px == part.visible_px == pytest.approx(model.required.markers[0].area * 200**2)
        with pytest.raises(SourceError, match="keypoints of 'base/plat'.*mean 'base/plate'"):
            with_components(TrueObject(None, None, {}, None, axes={"base/plat": axis}), model, None)

    def test_what_is_not_told_is_not_judged(self, tmp_path):
        """Poses: no configuration is right or wrong; axes: a component without annotation is not wrong."""
        folder = write_run(tmp_path / "r2", [record(0, found_thing(0.1))])
        poses = Truth({0: (TrueObject(None, pose_at(0.1), {}, None, "thing", told=Told.REQUIRED),)}, "t", CAMERA)
        (e,) = evaluate_runs([load_run(folder)], poses, Options())
        c = e.counts()
        assert (c.objects, c.recognised, c.judged, c.components_wrong) == (1, 1, 0, 0)
        axis = np.array([[pixel(0.1) - 20, 59.5], [pixel(0.1) + 20, 59.5]])
        marked = TrueObject(None, None, {}, None, "thing", axes={"base/plate": axis}, told=Told.LABELLED)
        (e,) = evaluate_runs([load_run(folder)], Truth({0: (marked,)}, "t"), Options())
        c = e.counts()
        assert (c.objects, c.recognised, c.right, c.components_right, c.components_wrong) == (1, 1, 1, 0, 0)
        assert c.position_errors == ()

    def test_what_is_missing_for_poses_is_said(self, tmp_path):
        folder = write_run(tmp_path / "r2", [record(0)])
        poses = Truth({0: (TrueObject(None, pose_at(0.1), {}, None, "thing", told=Told.REQUIRED),)}, "bag")
        with pytest.raises(SourceError, match="bag: no calibration.*--camera-info"):
            evaluate_runs([load_run(folder)], poses, Options())
        (folder / "thing.yaml").unlink()
        with pytest.raises(SourceError, match="needs the object file of 'thing'.*thing.yaml"):
            evaluate_runs([load_run(folder)], poses, Options(camera=CAMERA))
