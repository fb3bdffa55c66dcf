"""`artrec tune` on a simulated lamp whose parameters are too strict."""

from __future__ import annotations

import json
import resource
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml

pytest.importorskip("optuna", reason="Optuna is not installed (the extra `tune`)")

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.tools.main import main
from artrec_ros.tools.tuning.goal import FIGURES, Goal
from artrec_ros.tools.tuning.search import Search
from artrec_ros.tools.tuning.space import load_space

from .lamp import write_lamp

SPACE = {
    "recognizer.min_match": {"low": 0.4, "high": 0.9},
    "expert.alignment.refine_keep": {"low": 4, "high": 40},
    "expert.alignment.couple_spans": {"choices": [[1], [1, 2]]},
    "recognizer.max_slant_deg": {"low": 0.0, "high": 50.0},
    "expert.grouping.min_alone_match": {"low": 0.4, "high": 0.9},
    "expert.grouping.min_group_match": {"low": 0.4, "high": 0.9},
}
TRIALS = 12


@pytest.fixture(scope="module")
def world(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("lamp")
    write_lamp(folder)
    (folder / "space.yaml").write_text(yaml.safe_dump({"format": "artrec_search/1", "parameters": SPACE}))
    slanted = ["--frames", "40", "--seed", "5", "--tilt-rad", "0.2"]
    assert main(["simulate", str(folder / "lamp.yaml"), *slanted, "-o", str(folder / "sim")]) == 0
    return folder


def command(world: Path, out: Path, *options: str, trials: int = TRIALS) -> list[str]:
    files = ["--params-file", str(world / "params.yaml"), "--search", str(world / "space.yaml")]
    truth = ["--truth", str(world / "sim" / "truth.jsonl")]
    return ["tune", str(world / "sim" / "bag"), *truth, *files, "-o", str(out), "--trials", str(trials), *options]


def test_what_is_searched_in_vain_is_told_before_it_runs(world, tmp_path, capsys, monkeypatch):
    """A lamp of two dimensions is found in the image plane, which reads no probabilities of poses."""
    space = {"format": "artrec_search/1", "parameters": {"recognizer.min_probability": {"low": 0.1, "high": 0.9}}}
    (tmp_path / "space.yaml").write_text(yaml.safe_dump(space))
    monkeypatch.setattr("artrec_ros.tools.tune._tune", lambda *_: True)
    options = ["--search", str(tmp_path / "space.yaml")]
    assert main(command(world, tmp_path / "out", *options)) == 0
    told = [line for line in capsys.readouterr().err.splitlines() if "min_probability" in line]
    assert len(told) == 1 and told[0].startswith("warning: recognizer.min_probability changes nothing here")


def test_what_a_bag_lacks_is_told(world, tmp_path, capsys):
    cut = tmp_path / "sim"
    shutil.copytree(world / "sim", cut)
    file = cut / "bag/bag.mcap"
    file.write_bytes(file.read_bytes()[: file.stat().st_size // 2])
    shutil.copy(world / "lamp.yaml", tmp_path)
    for name in ("params.yaml", "space.yaml"):
        shutil.copy(world / name, tmp_path)
    assert main(command(tmp_path, tmp_path / "out", "--block", "1", trials=1)) == 0
    assert f"{file}: it ends in the middle" in capsys.readouterr().err


def test_where_no_frame_is_read_that_is_told(world, tmp_path, capsys):
    assert main(command(world, tmp_path / "out", "--start-offset", "999")) == 1
    assert f"{world / 'sim/bag'}: there is no frame to tune on\n" in capsys.readouterr().err


def trials_of(out: Path) -> list[tuple]:
    """What was tried and what came of it, but for its timing."""
    trials = json.loads((out / "report.json").read_text())["trials"]
    timed = {f for f in FIGURES if f.startswith("latency")}
    return [(t["values"], {k: v for k, v in t["measured"].items() if k not in timed}) for t in trials]


@pytest.fixture(scope="module")
def tuned(world) -> Path:
    assert main(command(world, world / "tuned")) == 0
    return world / "tuned"


def test_it_finds_better_parameters_and_says_so(world, tuned, capsys):
    report = json.loads((tuned / "report.json").read_text())
    held_out = report["held_out"]
    assert held_out["after"]["f1"]["value"] > held_out["before"]["f1"]["value"] + 0.1
    assert held_out["before"]["f1"]["low"] < held_out["before"]["f1"]["value"] < held_out["before"]["f1"]["high"]
    assert report["frames"] == {"tuned_on": 28, "held_out": 12} and held_out["after"]["counts"]["frames"] == 12
    assert len(report["trials"]) == TRIALS and report["best"]["measured"]["f1"] == max(
        t["measured"]["f1"] for t in report["trials"]
    )
    changed = load_parameters(tuned / "parameters.yaml").recognizer
    assert changed.max_slant_deg == report["changes"]["recognizer.max_slant_deg"] > 0
    assert "# share of the outline" in (tuned / "parameters.yaml").read_text()
    assert main(command(world, tuned)) == 0  # a finished search is told again, without another trial
    printed = capsys.readouterr().out
    assert "recognizer.max_slant_deg: 0.0 -> " in printed and "after against before" in printed
    assert json.loads((tuned / "report.json").read_text())["trials"] == report["trials"]


def test_the_first_trial_is_what_was_given(tuned):
    values, measured = trials_of(tuned)[0]
    assert values["recognizer.min_match"] == 0.8 and values["expert.alignment.couple_spans"] == [1, 2]
    assert 0 < measured["f1"] < 0.9


def test_replay_and_evaluate_agree_on_what_was_found(world, tuned, tmp_path):
    """All frames under the tuned parameters: as many objects as both parts of the search have together."""
    out = str(tmp_path / "replay")
    arguments = ["--params-file", str(tuned / "parameters.yaml"), "-o", out, "--images", "none", "--no-video"]
    assert main(["replay", str(world / "sim" / "bag"), *arguments]) == 0
    assert main(["evaluate", out, "--truth", str(world / "sim" / "truth.jsonl"), "--no-page"]) == 0
    counts = json.loads((tmp_path / "replay" / "metrics.json").read_text())["all"]["counts"]
    report = json.loads((tuned / "report.json").read_text())
    rest = report["best"]["measured"]
    held = report["held_out"]["after"]["counts"]
    assert counts["recognised"] - held["recognised"] == pytest.approx(
        rest["recognition_rate"] * (counts["objects"] - held["objects"]), abs=0.01
    )


def test_more_trials_go_on_and_workers_change_nothing(world, tuned, tmp_path):
    out = tmp_path / "out"
    assert main(command(world, out, "--jobs", "2", trials=5)) == 0
    assert len(trials_of(out)) == 5
    assert main(command(world, out)) == 0
    assert trials_of(out) == trials_of(tuned)


def artrec(arguments: list[str], **options) -> subprocess.Popen:
    program = [sys.executable, "-m", "artrec_ros.tools.main", *arguments]
    return subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGKILL])
def test_a_search_that_was_stopped_goes_on_as_if_it_had_not_been(world, tuned, tmp_path, number):
    out = tmp_path / "out"
    process = artrec(command(world, out, trials=1000))
    end = time.monotonic() + 60
    before = out / "before.jsonl"
    while not (before.exists() and before.read_bytes().count(b"\n") == 40) and time.monotonic() < end:
        time.sleep(0.01)
    time.sleep(0.3)
    process.send_signal(number)
    process.communicate(timeout=60)
    assert not (out / "report.json").exists() and process.returncode == (130 if number == signal.SIGINT else -number)
    assert main(command(world, out)) == 0
    assert trials_of(out)[:TRIALS] == trials_of(tuned)


def test_another_search_is_not_gone_on_with(world, tuned, capsys):
    assert main(command(world, tuned, "--objective", "right_rate")) == 1
    assert "--objective was f1, now right_rate" in capsys.readouterr().err
    assert main(command(world, tuned, "--limit", "precision>=0.1")) == 1
    assert "--limit was not given, now precision>=0.1" in capsys.readouterr().err


def test_limits_are_told_when_none_keeps_them(world, tmp_path, capsys):
    options = ("--objective", "latency_ms_median", "--limit", "f1>=1", "--limit", "latency_ms_p95<=0.001")
    assert main(command(world, tmp_path / "out", *options, trials=2)) == 0
    assert "no trial kept the limits" in capsys.readouterr().out


def test_given_parameters_outside_the_space_are_no_trial(world, tmp_path, capsys):
    space = {"format": "artrec_search/1", "parameters": {"recognizer.min_match": {"low": 0.4, "high": 0.6}}}
    (tmp_path / "narrow.yaml").write_text(yaml.safe_dump(space))
    arguments = command(world, tmp_path / "out", "--search", str(tmp_path / "narrow.yaml"), trials=2)
    assert main(arguments) == 0
    assert "outside" in capsys.readouterr().err
    assert all(0.4 <= values["recognizer.min_match"] <= 0.6 for values, _ in trials_of(tmp_path / "out"))


def test_a_full_disk_is_told_and_what_was_tried_stays(world, tmp_path):
    """A limit on the size of files stands for the disk's end."""
    out = tmp_path / "out"
    assert main(command(world, out, trials=2)) == 0

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        size = (out / "study.db").stat().st_size
        resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))

    arguments = command(world, out, trials=60)
    process = artrec(arguments, preexec_fn=limit)
    said = process.communicate(timeout=120)[1]
    assert process.returncode == 1 and "cannot be written" in said and "Traceback" not in said
    assert main(command(world, out, trials=3)) == 0
    assert len(trials_of(out)) >= 3


def test_a_damaged_search_is_told_with_the_way_out_before_the_work(world, tuned, tmp_path, capsys):
    out = tmp_path / "out"
    shutil.copytree(tuned, out)
    (out / "before.jsonl").unlink()
    (out / "study.db").write_bytes((tuned / "study.db").read_bytes()[:9000])
    capsys.readouterr()
    assert main(command(world, out)) == 1
    said = capsys.readouterr().err.splitlines()[-1]
    assert f"artrec: {out / 'study.db'}: cannot be used: database disk image is malformed" in said
    assert "begin anew with --overwrite" in said and not (out / "before.jsonl").exists()


def test_a_truth_that_matches_no_frame_is_told(world, tmp_path, capsys):
    line = {"stamp_ns": 7, "objects": []}
    (tmp_path / "truth.jsonl").write_text(json.dumps(line) + "\n")
    arguments = command(world, tmp_path / "out")
    arguments[arguments.index("--truth") + 1] = str(tmp_path / "truth.jsonl")
    assert main(arguments) == 1
    told = capsys.readouterr().err
    assert "no stamp of the truth (1 frames" in told and "(40 frames" in told and "s apart" in told


def test_each_source_has_its_own_truth(world, tmp_path):
    """Two bags with the same stamps: with the truth of each, twice the objects of one."""
    shutil.copytree(world / "sim" / "bag", tmp_path / "bag")
    arguments = command(world, tmp_path / "out", "--truth", str(world / "sim" / "truth.jsonl"), trials=1)
    arguments.insert(1, str(tmp_path / "bag"))
    assert main(arguments) == 0
    assert json.loads((tmp_path / "out" / "report.json").read_text())["frames"] == {"tuned_on": 56, "held_out": 24}
    assert main([*arguments, "--truth", "third"]) == 1


def test_the_search_learns_and_tells_which_parameter_mattered(world, tmp_path):
    """A figure that depends on one parameter alone; some values cannot be used."""
    space = load_space(world / "space.yaml", load_parameters(world / "params.yaml"))

    def measure(values):
        if values["expert.alignment.refine_keep"] == 7:
            raise ConfigError("seven")
        return dict.fromkeys(FIGURES) | {"f1": 1 - abs(values["recognizer.min_match"] - 0.6)}

    search = Search(tmp_path, space, Goal("f1"), seed=0)
    for _ in range(40):
        assert search.next(measure)
    assert search.best.values["recognizer.min_match"] == pytest.approx(0.6, abs=0.02)
    importance = search.importance()
    assert max(importance, key=importance.get) == "recognizer.min_match" and importance["recognizer.min_match"] > 0.6
    assert all("seven" in t.problem for t in search.tried if t.values["expert.alignment.refine_keep"] == 7)


def test_an_interrupted_trial_does_not_count(world, tmp_path):
    space = load_space(world / "space.yaml", load_parameters(world / "params.yaml"))
    figures = dict.fromkeys(FIGURES) | {"f1": 0.5}
    search = Search(tmp_path, space, Goal("f1"), seed=0)
    asked = []
    assert not search.next(lambda values: asked.append(values))
    assert search.tried == [] and search.importance() == {}
    assert search.next(lambda values: asked.append(values) or figures)
    assert asked[0] == asked[1] and len(search.tried) == 1
