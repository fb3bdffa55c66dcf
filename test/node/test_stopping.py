"""SIGINT and SIGTERM at any moment: the executable ends with 0 and prints no traceback."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

from peer import ROOT, WAIT_S, ros

# Runs the node and sends itself the signal when it gets to a place: the import of a module, or the call of a function,
# which goes on at once (call), or when the signal has had time to work (late).
PROGRAM = """
import importlib, os, signal, sys, time
number, place = signal.Signals[sys.argv[1]], sys.argv[2]
if sys.argv[3] == "ignored":
    signal.signal(signal.SIGINT, signal.SIG_IGN)

def strike():
    print("struck", file=sys.stderr, flush=True)
    os.kill(os.getpid(), number)
    if place.startswith("late "):
        time.sleep(0.5)

class AtImport:
    def find_spec(self, name, path=None, target=None):
        if name == place:
            sys.meta_path.remove(self)
            strike()

def at_call(owner, name):
    original = getattr(owner, name)
    def wrapped(*arguments, **keywords):
        setattr(owner, name, original)
        strike()
        return original(*arguments, **keywords)
    setattr(owner, name, wrapped)

kind, _, rest = place.partition(" ")
if kind in ("call", "late"):
    module, _, path = rest.partition(":")
    owner = importlib.import_module(module)
    *owners, name = path.split(".")
    for each in owners:
        owner = getattr(owner, each)
    at_call(owner, name)
else:
    sys.meta_path.insert(0, AtImport())
from artrec_ros.node.main import main
sys.exit(main(sys.argv[4:]))
"""
NODE = "call artrec_ros.node.node:RecognizerNode"
PLACES = (
    "rclpy.executors",
    "artrec_ros.node.node",
    "cv2",
    "call rclpy:init",
    f"{NODE}.__init__",
    "call artrec_ros.node.parameters:_declare",
    f"{NODE}.on_configure",
    "call artrec_ros.io.parameters.parameter_file:Setup.build",
    f"{NODE}.on_activate",
    "late rclpy.executors:SingleThreadedExecutor.__init__",
    f"{NODE}._report",
)
CASES = [(place, "SIGTERM", "default") for place in PLACES] + [
    (place, "SIGINT", inherited) for place in PLACES[1::3] for inherited in ("default", "ignored")
]


def run(place: str, name: str, inherited: str, *arguments: str) -> tuple[int, list[str]]:
    """Exit code and what was printed but the log's news."""
    path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, name, place, inherited, *arguments],
        env={**os.environ, "PYTHONPATH": path}, capture_output=True, text=True, timeout=WAIT_S,
    )  # fmt: skip
    printed = (done.stdout + done.stderr).splitlines()
    assert "struck" in printed, f"never came to {place}: {printed}"
    return done.returncode, [line for line in printed if "[INFO]" not in line and line != "struck"]


@pytest.mark.parametrize(("place", "name", "inherited"), CASES)
def test_it_ends_cleanly_wherever_it_is(place: str, name: str, inherited: str, parameter_file: Path) -> None:
    code, printed = run(place, name, inherited, *ros(parameter_file))
    assert code == 0, printed
    assert len(printed) <= 1 and "Traceback" not in str(printed)


def test_what_ends_it_anyway_keeps_its_exit_code(parameter_file: Path) -> None:
    """A signal while a node that could not start is taken down."""
    arguments = ros(parameter_file, "-p", "toy.constraint_file:=nowhere")
    code, printed = run("call rclpy:try_shutdown", "SIGTERM", "default", *arguments)
    assert code == 1, printed
    assert any("nowhere" in line for line in printed) and "Traceback" not in str(printed)
