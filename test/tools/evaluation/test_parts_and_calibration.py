"""Conditions, calibration and paired changes on outcomes that are known by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.tools.evaluate import evaluate
from artrec_ros.tools.evaluation.calibration import calibrate, expected_error
from artrec_ros.tools.evaluation.figures import figures_of, written
from artrec_ros.tools.evaluation.intervals import Estimate
from artrec_ros.tools.evaluation.metrics import Counts
from artrec_ros.tools.evaluation.scoring import Options
from artrec_ros.tools.evaluation.strata import range_edges, stratify

from .makers import found_thing, record, true_thing, write_run, write_truth


def evaluation_of(tmp_path, truth, records, name="r"):
    path = write_truth(tmp_path / f"{name}.jsonl", truth)
    ((result,), _) = evaluate([write_run(tmp_path / name, records)], path)
    return result


def parts(result, key):
    (stratum,) = [s for s in result.strata if s.key == key]
    return {b.name: (b.counts.objects, b.counts.recognised, b.counts.false) for b in stratum.bins}


def test_objects_and_false_detections_belong_where_their_range_is(tmp_path):
    """A false detection 3 m away lowers precision there and nowhere else."""
    truth = {1: [true_thing(z=1.1)], 2: [true_thing(z=3.1)]}
    records = [record(1, found_thing(z=1.1)), record(2, found_thing(z=3.1), found_thing(1.0, z=3.0))]
    result = evaluation_of(tmp_path, truth, records)
    found = parts(result, "range")
    assert list(found.values()) == [(1, 1, 0), (1, 1, 1)]
    assert [float(name.split()[0]) <= r < float(name.split()[2]) for name, r in zip(found, (1.1, 3.1), strict=True)]
    (stratum,) = [s for s in result.strata if s.key == "range"]
    assert [b.figures["precision"].value for b in stratum.bins] == [1, 0.5]


@pytest.mark.parametrize(("azimuth", "sector"), [(0, "0"), (44, "45"), (179, "180"), (-179, "180"), (-90, "-90")])
def test_azimuth_is_where_the_camera_stands_in_the_objects_frame(tmp_path, azimuth, sector):
    """The object's x, y and z in the camera's frame, looked at level from `azimuth`."""
    a = np.radians(azimuth)
    x, z = np.array([-np.sin(a), 0, -np.cos(a)]), np.array([0.0, -1, 0])
    pose = Pose(np.stack([x, np.cross(z, x), z], axis=1), [0, 0, 2.0])
    result = evaluation_of(tmp_path, {1: [true_thing(pose=pose)]}, [record(1)])
    assert parts(result, "azimuth") == {sector: (1, 0, 0)}
    assert parts(result, "elevation") == {"0 to 30": (1, 0, 0)}


def test_an_object_that_faces_the_camera_is_seen_from_above_without_slant(tmp_path):
    """Its marker lies in its x, y plane."""
    result = evaluation_of(tmp_path, {1: [true_thing(z=2)]}, [record(1)])
    assert parts(result, "elevation") == {"60 to 90": (1, 0, 0)} and parts(result, "slant") == {"0 to 15": (1, 0, 0)}


def test_a_place_on_a_plane_says_nothing_of_where_the_camera_is(tmp_path):
    """A false detection whose pose is in a field's frame has no range, and no side that the camera would see."""
    on_field = replace(found_thing(0.3, z=3.0), pose_from="plane", frame_id="field")
    truth, records = {1: [true_thing(z=2)]}, [record(1, found_thing(z=2), on_field)]
    result = evaluation_of(tmp_path, truth, records)
    for key in ("range", "azimuth", "elevation", "slant"):
        assert list(parts(result, key).values()) == [(1, 1, 0)], key
        (stratum,) = [s for s in result.strata if s.key == key]
        assert [b.figures["precision"] for b in stratum.bins] == [Estimate()]


def test_a_part_by_size_tells_no_precision(tmp_path):
    truth = {1: [true_thing(z=1)], 2: [true_thing(z=2)]}
    result = evaluation_of(tmp_path, truth, [record(1, found_thing(), found_thing(0.3)), record(2)])
    (stratum,) = [s for s in result.strata if s.key == "size"]
    assert [b.figures["precision"] for b in stratum.bins] == [Estimate(), Estimate()]
    assert [b.false for b in stratum.bins] == ["-", "-"]
    (stratum,) = [s for s in result.strata if s.key == "range"]
    assert stratum.bins[0].figures["precision"].value == 0.5


def test_false_detections_without_a_pose_leave_precision_by_range_untold(tmp_path):
    result = evaluation_of(tmp_path, {1: [true_thing()]}, [record(1, found_thing(), found_thing(0.3, pose=None))])
    (stratum,) = [s for s in result.strata if s.key == "range"]
    assert [b.figures["precision"] for b in stratum.bins] == [Estimate()]
    assert [b.figures["recognition_rate"].value for b in stratum.bins] == [1]


@pytest.mark.parametrize("ranges", [[0.61, 1.7], [2.0], [10.0, 10.001], [0.02, 93.0], [1.0, 1.5]])
def test_ranges_are_few_round_and_hold_all(ranges):
    edges = range_edges(ranges)
    assert 1 <= len(edges) <= 6
    assert all(sum(low <= r < high for _, low, high in edges) == 1 for r in ranges)
    assert all(a[2] == b[1] for a, b in zip(edges[:-1], edges[1:], strict=True))
    assert range_edges([]) == []


def test_runs_are_told_in_the_same_parts(tmp_path):
    truth = write_truth(tmp_path / "t.jsonl", {1: [true_thing(z=1)], 2: [true_thing(z=3)]})
    full = write_run(tmp_path / "a", [record(1, found_thing(z=1)), record(2, found_thing(z=3))])
    empty = write_run(tmp_path / "b", [record(1), record(2, found_thing(2, z=9))])
    results, _ = evaluate([full, empty], truth)
    a, b = stratify([r.evaluation for r in results])
    assert [[x.name for x in s.bins] for s in a] == [[x.name for x in s.bins] for s in b]


class TestCalibration:
    def test_scores_that_mean_what_they_say(self):
        rng = np.random.default_rng(0)
        scores = rng.uniform(0, 1, 20000)
        c = calibrate(list(zip(scores, rng.uniform(0, 1, 20000) < scores, strict=True)))
        assert len(c.bins) == 10 and c.error.value < 0.02
        assert c.brier.value == pytest.approx(1 / 6, abs=0.01)  # the mean of p (1 - p)
        inside = [b.precision.low <= b.score <= b.precision.high for b in c.bins]
        assert sum(inside) >= 8

    def test_scores_that_promise_too_much(self):
        c = calibrate([(0.9, True)] * 5 + [(0.9, False)] * 5)
        assert c.error.value == pytest.approx(0.4) and c.bins[0].precision.value == 0.5
        assert c.brier.value == pytest.approx((0.01 + 0.81) / 2)

    def test_the_error_weighs_bins_by_their_counts(self):
        rows = np.array([(0.95, 1)] * 3 + [(0.25, 1)])
        assert expected_error(rows) == pytest.approx((3 * 0.05 + 0.75) / 4)

    def test_no_detections_and_scores_beyond_one(self):
        assert calibrate([]).bins == () and calibrate([]).brier == Estimate()
        assert calibrate([(1.2, True)]).bins[0].score == 1

    def test_excused_detections_say_nothing(self, tmp_path):
        hidden = true_thing(components={}, z=1)  # not in view: its detection is neither right nor false
        result = evaluation_of(tmp_path, {1: [hidden], 2: [true_thing()]}, [record(1, found_thing()), record(2)])
        assert result.calibration.bins == () and result.overall["precision"] == Estimate()


class TestChanges:
    def test_pairs_are_of_the_same_object(self, tmp_path):
        """Both find one of two: the same figures, and yet one gained and one lost."""
        truth = write_truth(tmp_path / "t.jsonl", {1: [true_thing()], 2: [true_thing()]})
        a = write_run(tmp_path / "a", [record(1, found_thing()), record(2)])
        b = write_run(tmp_path / "b", [record(1), record(2, found_thing())])
        results, (change,) = evaluate([a, b], truth)
        assert results[0].overall["recognition_rate"] == results[1].overall["recognition_rate"]
        rate = change["recognition_rate"]
        assert (rate.difference.value, rate.gained, rate.lost, rate.p) == (0, 1, 1, 1)

    def test_errors_are_compared_where_both_found(self, tmp_path):
        truth = write_truth(tmp_path / "t.jsonl", {t: [true_thing(0.02 * t)] for t in range(1, 6)})
        a = write_run(tmp_path / "a", [record(t, found_thing(0.02 * t + 0.01)) for t in range(1, 6)])
        b = write_run(
            tmp_path / "b", [record(t, *([found_thing(0.02 * t + 0.03)] if t > 2 else [])) for t in range(1, 6)]
        )
        _, (change,) = evaluate([a, b], truth)
        error = change["position_error_m_median"].difference
        assert error.n == 3 and error.value == pytest.approx(0.02) and error.low == pytest.approx(0.02)

    def test_names_that_mean_different_objects_are_not_paired(self, tmp_path):
        truth = write_truth(tmp_path / "t.jsonl", {1: [true_thing(name=None), true_thing(0.4, name=None, label=3)]})
        a, b = (write_run(tmp_path / n, [record(1, found_thing())]) for n in "ab")
        summary = (b / "summary.json").read_text().replace('"label": 2', '"label": 3')
        (b / "summary.json").write_text(summary)
        _, (change,) = evaluate([a, b], truth)
        assert change["recognition_rate"].difference == Estimate()
        _, (change,) = evaluate([a, b], truth, options=Options({"thing": "2"}))
        assert change["recognition_rate"].difference.n == 1


def test_figures_equal_the_counts_own_ratios():
    c = Counts(frames=9, objects=8, recognised=6, judged=8, right=5, false=2, components_right=7, components_wrong=1,
               components_missed=3, position_errors=(0.1, 0.3, 0.2))  # fmt: skip
    rates = c.rates()
    figures = figures_of(c)
    assert {key: figures[key].value for key in rates if key in figures} == {
        k: v for k, v in rates.items() if k in figures
    }
    assert written("position_error_median", figures["position_error_median"]).startswith("20.00 (")
    assert written("joint_error_m_median", figures["joint_error_m_median"]) == "-"
