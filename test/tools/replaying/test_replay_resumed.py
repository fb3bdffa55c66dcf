"""Replays that are interrupted, go on, or meet what is there already."""

from __future__ import annotations

import os
import shutil
import signal
from pathlib import Path

import cv2
import numpy as np
import pytest
from arm_replays import OBJECT, PARAMETERS, bag, folder_of, params_of, run, summary_of

from artrec_ros.io.results.results import read_results


def test_a_replay_goes_on_however_its_paths_are_spelled(tmp_path, params, recogniser, capsys):
    source, link, around = bag(tmp_path / "bag", [1, 2]), tmp_path / "link", tmp_path / "frames" / ".."
    (tmp_path / "frames").mkdir()
    link.symlink_to(source)
    assert run(params, source, tmp_path / "out") == 0
    for spelled in (link, around / "bag"):
        assert run(around / params.name, spelled, tmp_path / "out") == 0, capsys.readouterr().err
    assert recogniser.seen == 2


@pytest.mark.parametrize(
    ("more", "said"),
    [
        (["--images", "none"], "--images was all, now none;"),
        (["--no-video"], "--no-video was not given;"),
        (["--no-timing"], "--no-timing was not given;"),
        (["--labels"], "--labels was not given;"),
        (["--output-bag"], "--output-bag was not given, now mcap;"),
        (["--playback-duration", "3"], "--playback-duration was not given, now 3.0;"),
    ],
)
def test_what_differs_from_an_earlier_run_is_told_in_words_of_the_command(
    tmp_path, params, recogniser, capsys, more, said
):
    source = bag(tmp_path / "bag", [1])
    assert run(params, source, tmp_path / "out") == 0
    assert run(params, source, tmp_path / "out", *more) == 1
    assert said in capsys.readouterr().err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_replay_leaves_what_it_has(tmp_path, params, recogniser, capsys, number):
    recogniser.at_frame[3] = lambda: os.kill(os.getpid(), number)
    before = signal.getsignal(signal.SIGTERM)
    assert run(params, bag(tmp_path / "bag", [1] * 6), tmp_path / "out") == 130
    assert len(list(read_results(tmp_path / "out" / "detections.jsonl"))) == 3  # the frame at hand is finished
    assert summary_of(tmp_path / "out")["interrupted"] is True
    assert "interrupted" in capsys.readouterr().out
    assert signal.getsignal(signal.SIGTERM) is before


def test_results_are_on_disk_frame_by_frame(tmp_path, params, recogniser):
    seen = []
    path = tmp_path / "out" / "detections.jsonl"
    recogniser.at_frame[3] = lambda: seen.extend(read_results(path))
    run(params, bag(tmp_path / "bag", [1] * 4), tmp_path / "out")
    assert len(seen) == 2


def test_existing_results_are_kept_unless_overwritten(tmp_path, params, recogniser, capsys):
    source, out = bag(tmp_path / "bag", [1, 1]), tmp_path / "out"
    assert run(params, source, out) == 0
    (out / "mine.txt").write_text("kept")
    assert run(params, source, out, "--images", "1", "--no-video") == 1
    said = capsys.readouterr().err
    assert "--images was all, now 1" in said and "--overwrite" in said
    assert len(list((out / "frames").iterdir())) == 2 and (out / "video.mp4").exists()
    assert run(params, source, out, "--overwrite", "--images", "1", "--no-video") == 0
    assert len(list((out / "frames").iterdir())) == 1 and not (out / "video.mp4").exists()
    assert (out / "mine.txt").exists()


@pytest.mark.parametrize(
    ("name", "told"),
    [
        ("detections.jsonl", "results already"),
        *((name, name) for name in ("video.mp4", "summary.json", "parameters.yaml", "bag_0")),
    ],
)
def test_files_of_nobody_knows_whom_are_kept(tmp_path, params, recogniser, capsys, name, told):
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / name).write_text("mine")
    assert run(params, bag(tmp_path / "bag", [1]), tmp_path / "out") == 1
    said = capsys.readouterr().err
    assert f"holds {told}" in said and "--overwrite" in said
    assert (tmp_path / "out" / name).read_text() == "mine"
    assert [p.name for p in (tmp_path / "out").iterdir() if p.name != "frames"] == [name]


def test_a_journal_with_a_bad_line_is_gone_on_with_from_there(tmp_path, params, recogniser, capsys):
    source, out = bag(tmp_path / "bag", [1, 2, 3, 4]), tmp_path / "out"
    recogniser.at_frame[3] = lambda: os.kill(os.getpid(), signal.SIGINT)
    run(params, source, out)
    journal = out / "journal.jsonl"
    done = len(journal.read_text().splitlines())
    assert 1 < done < 4
    with journal.open("a") as stream:
        stream.write('{"bad": tru\n')
    seen, recogniser.at_frame = recogniser.seen, {}
    assert run(params, source, out) == 0
    assert recogniser.seen - seen == 4 - done
    assert f"journal.jsonl: line {done + 1} is no frame" in capsys.readouterr().err
    assert len(list(read_results(out / "detections.jsonl"))) == 4


def test_a_finished_replay_is_not_done_again(tmp_path, params, recogniser, capsys):
    source, out = bag(tmp_path / "bag", [1, 1, 9]), tmp_path / "out"
    assert run(params, source, out) == 0
    first, before = capsys.readouterr().out, (out / "summary.json").read_text()
    assert run(params, source, out) == 0
    assert recogniser.seen == 3 and (out / "summary.json").read_text() == before
    again = capsys.readouterr().out
    assert again.splitlines()[:-1] == first.splitlines()[:-1] and "--overwrite" in again


@pytest.mark.parametrize(
    ("content", "said"),
    [("{", "line 1: is no valid JSON"), ('{"looked_for": {}, "frames_with_error": 0}', "sources: this key is missing")],
)
def test_a_damaged_summary_is_told_with_the_way_out(tmp_path, params, recogniser, capsys, content, said):
    source, out = bag(tmp_path / "bag", [1]), tmp_path / "out"
    assert run(params, source, out) == 0
    (out / "summary.json").write_text(content)
    assert run(params, source, out) == 1
    line = capsys.readouterr().err.splitlines()[-1]
    assert line.startswith(f"artrec: {out / 'summary.json'}: {said}") and line.endswith("; --overwrite replays again")


@pytest.mark.parametrize("changed", ["source", "parameters", "object file"])
def test_a_replay_of_something_else_is_not_gone_on_with(tmp_path, params, recogniser, capsys, changed):
    source, out = folder_of(tmp_path / "images", [1]), tmp_path / "out"
    assert run(params, source, out) == 0
    if changed == "source":
        cv2.imwrite(str(source / "1.png"), np.ones((24, 32), np.uint8))
    elif changed == "parameters":
        params_of(params, **PARAMETERS, recognizer={"min_match": 0.5})
    else:
        (tmp_path / "arm.yaml").write_text(OBJECT.replace("0.05", "0.04"))
    assert run(params, source, out) == 1
    told = {"source": "images has changed", "parameters": "min_match was 0.55, not 0.5", "object file": "arm.yaml has"}
    assert told[changed] in capsys.readouterr().err


def test_an_interrupted_replay_goes_on_where_it_was(tmp_path, params, recogniser, monkeypatch):
    """What was interrupted and went on has the same results as what was not; no frame is recognised twice."""
    source = bag(tmp_path / "bag", [4, 5, 9, 30, 31, 0, 7, 8] * 3)
    options = ("--no-timing", "--output-bag")
    assert run(params, source, tmp_path / "whole", *options) == 0
    seen = recogniser.seen
    for stop in (2, 17, 3):
        recogniser.at_frame[recogniser.seen + stop] = lambda: os.kill(os.getpid(), signal.SIGINT)
        assert run(params, source, tmp_path / "out", *options) == 130
    assert run(params, source, tmp_path / "out", *options) == 0
    assert recogniser.seen == 2 * seen
    assert same_files(tmp_path / "whole", tmp_path / "out")


def same_files(first: Path, second: Path) -> bool:
    names = [sorted(p.relative_to(d).as_posix() for p in d.rglob("*") if p.is_file()) for d in (first, second)]
    return names[0] == names[1] and all((first / n).read_bytes() == (second / n).read_bytes() for n in names[0])


def test_no_two_replays_write_to_one_folder(tmp_path, params, recogniser, capsys):
    source, out = bag(tmp_path / "bag", [1, 1]), tmp_path / "out"
    codes = []
    recogniser.at_frame[1] = lambda: codes.append(run(params, source, out, "--overwrite"))
    assert run(params, source, out) == 0
    assert codes == [1] and "another run is writing there" in capsys.readouterr().err
    assert len(list(read_results(out / "detections.jsonl"))) == 2


@pytest.mark.parametrize("anew", [False, True])
def test_a_folder_that_is_removed_meanwhile_ends_the_replay(tmp_path, params, recogniser, capsys, anew):
    """Where another run has made it anew, nothing is written into that one, and nothing removed from it."""
    out, others = tmp_path / "out", "unfinished/video.mp4"

    def removed() -> None:
        out.rename(tmp_path / "old") if anew else shutil.rmtree(out)
        if anew:
            (out / "unfinished").mkdir(parents=True)
            (out / others).touch()

    recogniser.at_frame = {2: removed}
    assert run(params, bag(tmp_path / "bag", [1, 2, 3]), out) == 1
    assert "is gone" in (said := capsys.readouterr().err) and "make room" not in said
    assert recogniser.seen == 2
    assert [p.relative_to(out).as_posix() for p in out.rglob("*") if p.is_file()] == [others] * anew
