"""`artrec replay` with worker processes, on a cluster, and when machines fail: always the same results."""

from __future__ import annotations

import os
import resource
import signal
import subprocess
import sys
import time
from pathlib import Path

import cv2
import numpy as np
import pytest
import yaml

from artrec_ros.core.base.errors import ArtrecError
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.io.results.results import read_results
from artrec_ros.tools.main import main
from artrec_ros.tools.replaying.cluster import ClusterEngine
from artrec_ros.tools.replaying.engines import Engine, InlineEngine, Job
from artrec_ros.tools.replaying.processes import ProcessEngine

OBJECT = """
format: artrec_object/1
name: arm
markers: {patch: {outline: [[0, 0], [0.2, 0], [0.2, 0.1], [0, 0.1]], axis: [[0, 0.05], [0.2, 0.05]]}}
components: {base: {required: true, markers: {patch: {pose: {xyz: [0, 0, 0]}}}}}  # in space: frames are handed on
"""
PARAMETERS = {
    "objects": ["arm"],
    "arm": {"object_file": "arm.yaml", "label": 3},
    "image": {"kind": "labels"},
    "recognizer": {"min_components": 1, "time_budget_ms": 600000.0},
}
FRAMES = 37  # parts do not divide it


@pytest.fixture(scope="module")
def world(tmp_path_factory) -> Path:
    """A folder with params.yaml, a bag, and a folder of images of which one is damaged."""
    folder = tmp_path_factory.mktemp("world")
    (folder / "arm.yaml").write_text(OBJECT)
    (folder / "params.yaml").write_text(yaml.safe_dump({"/**": {"ros__parameters": PARAMETERS}}))
    (folder / "images").mkdir()
    camera = Camera(np.array([[200, 0, 80], [0, 200, 60], [0, 0, 1.0]]), np.zeros(5), (160, 120), "eye")
    with BagWriter(folder / "bag") as bag:
        for i in range(FRAMES):
            bag.write_camera("/cam/camera_info", i * 10**8 + 1, camera)
            bag.write_image("/cam/labels", i * 10**8 + 1, "eye", picture(i))
    for i in range(5):
        cv2.imwrite(str(folder / "images" / f"{i}.png"), picture(i))
    (folder / "images" / "2.png").write_bytes(b"none")
    return folder


def picture(i: int) -> np.ndarray:
    image = np.zeros((120, 160), np.uint8)
    corners = cv2.boxPoints(((60 + i, 60), (60, 30), 3 * i))
    cv2.fillPoly(image, [np.int32(np.round(corners))], 3)
    return image


def command(world: Path, out: Path, *options: str) -> list[str]:
    sources = [str(world / "bag"), str(world / "images")]
    return ["replay", *sources, "--params-file", str(world / "params.yaml"), "-o", str(out), *options]


def contents(folder: Path) -> dict[str, bytes]:
    files = (p for p in folder.rglob("*") if p.is_file())
    return {p.relative_to(folder).as_posix(): p.read_bytes() for p in files}


@pytest.fixture(scope="module")
def whole(world) -> dict[str, bytes]:
    """All files of a replay by one process, without timing."""
    assert main(command(world, world / "whole", "--no-timing", "--output-bag")) == 0
    records = list(read_results(world / "whole" / "detections.jsonl"))
    assert sum(len(r.detections) for r in records) >= FRAMES  # it is no replay of nothing
    return contents(world / "whole")


def artrec(arguments: list[str], **options) -> subprocess.Popen:
    program = [sys.executable, "-m", "artrec_ros.tools.main", *arguments]
    return subprocess.Popen(program, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)


def test_two_workers_give_the_same_bytes_as_one(world, whole, tmp_path):
    assert main(command(world, tmp_path / "out", "--no-timing", "--output-bag", "--jobs", "2")) == 0
    assert contents(tmp_path / "out") == whole
    assert "bag_0/metadata.yaml" in whole and "bag_1/metadata.yaml" in whole and "video.mp4" in whole


def children_of(pid: int) -> list[int]:
    """Worker processes: those that have begun to hold a recogniser's libraries."""
    task = Path(f"/proc/{pid}/task/{pid}/children")
    found = [int(child) for child in task.read_text().split()] if task.exists() else []
    return [c for c in found if "spawn_main" in Path(f"/proc/{c}/cmdline").read_text()]


def lines(path: Path) -> int:
    return path.read_bytes().count(b"\n") if path.exists() else 0


def wait_until(reached, process: subprocess.Popen) -> None:
    end = time.monotonic() + 120
    while not reached() and process.poll() is None and time.monotonic() < end:
        time.sleep(0.01)


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs /proc to find the workers")
def test_a_killed_worker_costs_nothing_but_time(world, whole, tmp_path):
    out = tmp_path / "out"
    process = artrec(command(world, out, "--no-timing", "--output-bag", "--jobs", "2"))
    wait_until(lambda: lines(out / "journal.jsonl") > 3, process)
    victims = children_of(process.pid)
    os.kill(victims[0], signal.SIGKILL)
    said = process.communicate(timeout=100)
    assert process.returncode == 0, said
    assert contents(out) == whole


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_a_replay_that_was_killed_or_interrupted_goes_on(world, whole, tmp_path, number):
    out = tmp_path / "out"
    arguments = command(world, out, "--no-timing", "--output-bag", "--jobs", "2")
    process = artrec(arguments)
    wait_until(lambda: lines(out / "detections.jsonl") > 3, process)
    process.send_signal(number)
    process.communicate(timeout=100)
    assert process.returncode != 0
    noted = lines(out / "journal.jsonl")
    written = (out / "detections.jsonl").read_bytes()
    assert noted > 3 and written.endswith(b"\n") and whole["detections.jsonl"].startswith(written)
    assert main(arguments) == 0
    assert contents(out) == whole


@pytest.mark.skipif(not Path("/proc/self/task").exists(), reason="needs /proc to find the workers")
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("workers", [1, 2], ids=["while workers start", "when all have started"])
def test_a_signal_that_reaches_all_processes_leaves_no_traceback(world, tmp_path, workers, number):
    process = artrec(command(world, tmp_path / "out", "--jobs", "2"), start_new_session=True)
    wait_until(lambda: len(children_of(process.pid)) >= workers, process)
    time.sleep(0.2 * (workers - 1))  # the workers import
    os.killpg(process.pid, number)
    told = process.communicate(timeout=100)[1]
    assert process.returncode == 130
    assert told in ("artrec: interrupted\n", "finishing the frames at hand; once more ends at once\n")


def test_a_full_disk_is_told_and_leaves_whole_results(world, whole, tmp_path):
    """A limit on the size of files stands for the disk's end."""

    def limit() -> None:
        signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
        resource.setrlimit(resource.RLIMIT_FSIZE, (30000, 30000))

    arguments = command(world, tmp_path / "out", "--no-timing", "--images", "none", "--no-video")
    process = artrec(arguments, preexec_fn=limit)
    said = process.communicate(timeout=100)[1]
    assert process.returncode == 1
    (line,) = (row for row in said.splitlines() if row.startswith("artrec:"))
    assert str(tmp_path / "out") in line and "cannot be written" in line and "frames done so far are whole" in line
    done = (tmp_path / "out" / "detections.jsonl").read_bytes()
    assert done.endswith(b"\n") and whole["detections.jsonl"].startswith(done) and 0 < done.count(b"\n") < FRAMES
    assert main(arguments) == 0
    assert (tmp_path / "out" / "detections.jsonl").read_bytes() == whole["detections.jsonl"]


def test_a_cluster_gives_the_same_bytes_though_a_worker_is_killed(world, whole, tmp_path):
    distributed = pytest.importorskip("distributed", reason="Dask distributed is not installed")
    cluster = distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None, silence_logs="CRITICAL"
    )
    with cluster:
        pids = list(distributed.Client(cluster, set_as_default=False).run(os.getpid).values())
        address = cluster.scheduler_address
        out = tmp_path / "out"
        process = artrec(command(world, out, "--no-timing", "--output-bag", "--scheduler", address))
        wait_until(lambda: lines(out / "journal.jsonl") > 3, process)
        os.kill(pids[0], signal.SIGKILL)
        said = process.communicate(timeout=100)
        assert process.returncode == 0, said
    assert contents(out) == whole


def test_an_address_that_is_none_is_told_at_once(monkeypatch):
    distributed = pytest.importorskip("distributed", reason="Dask distributed is not installed")
    monkeypatch.setattr(distributed, "Client", lambda *_, **__: pytest.fail("it would wait for its end"))
    with pytest.raises(ArtrecError, match="--scheduler: nonsense: is no address such as tcp://HOST:8786: missing port"):
        ClusterEngine("nonsense")


def test_a_scheduler_that_does_not_answer_is_named(world, tmp_path, capsys, monkeypatch):
    pytest.importorskip("distributed", reason="Dask distributed is not installed")
    monkeypatch.setattr("artrec_ros.tools.replaying.cluster._CONNECT_S", 0.5)
    assert main(command(world, tmp_path / "out", "--scheduler", "tcp://127.0.0.1:9")) == 1
    assert "tcp://127.0.0.1:9: no Dask scheduler answers" in (said := capsys.readouterr().err)
    assert "looking for the Dask scheduler at tcp://127.0.0.1:9, for 0.5 s at most" in said


def count_to(n: int):
    yield from range(n)


def die():
    os.kill(os.getpid(), signal.SIGKILL)
    yield


def fail():
    raise ArtrecError("no such thing")
    yield


def do(engine: Engine, *jobs: Job) -> dict[str, list]:
    """All jobs, of which as many are under way as the engine takes."""
    items: dict[str, list] = {}
    left = list(jobs)
    while left or engine.busy:
        while left and engine.free:
            engine.submit(left.pop(0))
        for done in engine.wait():
            items.setdefault(done.job.name, []).extend(done.items)
    return items


ENGINES = pytest.mark.parametrize("make", [InlineEngine, lambda: ProcessEngine(1)], ids=["inline", "processes"])


@ENGINES
def test_engines_do_jobs_and_pass_on_errors(make):
    with make() as engine:
        jobs = [Job(name, None, count_to, (n,)) for name, n in (("a", 3), ("b", 2), ("c", 1))]
        assert do(engine, *jobs) == {"a": [0, 1, 2], "b": [0, 1], "c": [0]}
        with pytest.raises(ArtrecError, match="no such thing"):
            do(engine, Job("d", None, fail, ()))


def test_an_error_is_of_its_own_job_alone():
    with ProcessEngine(1) as engine:
        engine.submit(Job("bad", None, fail, ()))
        engine.submit(Job("good", None, count_to, (2,)))
        with pytest.raises(ArtrecError, match="no such thing"):
            list(engine.wait())
        assert [(done.job.name, done.items) for done in engine.wait()] == [("good", (0, 1))]
        assert not engine.busy and not list(engine.wait())


class OddError(Exception):
    def __init__(self, one, two):
        super().__init__(f"{one} and {two}")


def fail_oddly():
    raise OddError(1, 2)
    yield


def give_what_cannot_be_sent():
    yield lambda: None


@pytest.mark.parametrize("function, told", [(fail_oddly, "1 and 2"), (give_what_cannot_be_sent, "pickle")])
def test_what_cannot_be_sent_is_told_as_it_is(function, told):
    with ProcessEngine(1) as engine, pytest.raises(Exception, match=told):
        do(engine, Job("a", None, function, ()))


def test_a_job_that_kills_every_worker_is_given_up():
    with ProcessEngine(1) as engine, pytest.raises(ArtrecError, match="bag, frames 0 to 3: 3 workers died over it"):
        do(engine, Job("bag, frames 0 to 3", None, die, ()))


def hand_over():
    yield bytes(20_000_000)  # more than a pipe holds: the worker waits until it is read


def test_a_worker_killed_while_it_hands_items_over_is_replaced():
    with ProcessEngine(1) as engine:
        engine.submit(Job("a", None, hand_over, ()))
        engine.submit(Job("b", None, count_to, (2,)))
        (worker,) = engine._workers
        assert worker.connection.poll(60.0)  # it is in the midst of sending
        os.kill(worker._process.pid, signal.SIGKILL)
        done = do(engine)
    assert [len(items) for items in done["a"]] == [20_000_000] and done["b"] == [0, 1]


def test_a_worker_killed_while_it_rests_is_replaced():
    with ProcessEngine(1) as engine:
        for name in "abcde":  # more than MOST_DEATHS: none of them is a job's fault
            assert do(engine, Job(name, None, count_to, (1,))) == {name: [0]}
            engine._workers[0]._process.kill()
            engine._workers[0]._process.join()


def test_the_environment_is_as_it_was_after_processes(monkeypatch):
    monkeypatch.delenv("OMP_NUM_THREADS", raising=False)
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "3")
    with ProcessEngine(1):
        assert os.environ["OMP_NUM_THREADS"] == "1"
    assert "OMP_NUM_THREADS" not in os.environ and os.environ["OPENBLAS_NUM_THREADS"] == "3"
