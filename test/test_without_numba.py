"""Where numba is not installed, numpy does the same work."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

from artrec_ros.tools.main import main

ROOT = Path(__file__).resolve().parents[1]

PROGRAM = """
import sys
sys.modules["numba"] = None  # importing it raises ImportError
from artrec_ros.core.compiled.jit import COMPILED
from artrec_ros.tools.main import main
assert not COMPILED
sys.exit(main(sys.argv[1:]))
"""


def detections(folder: Path) -> list[dict]:
    lines = (folder / "detections.jsonl").read_text().splitlines()
    return [found for line in lines for found in json.loads(line)["objects"]]


def test_a_scene_is_recognised_the_same_without_numba(tmp_path: Path) -> None:
    model, params = ROOT / "config/objects/excavator.yaml", ROOT / "config/excavator.yaml"
    scene = ["--frames", 1, "--seed", 5, "--size", 0.5, 0.7, "--image-size", 240, 180, "--facing", 1, "--noise", 0]
    steps = [str(word) for word in ["simulate", model, "-o", tmp_path / "scene", *scene]]
    assert main(steps) == 0
    replay = ["replay", tmp_path / "scene/bag", "--params-file", params, "--no-video", "--images", "none", "-o"]
    assert main([str(word) for word in [*replay, tmp_path / "here"]]) == 0
    command = [sys.executable, "-c", PROGRAM, *map(str, replay), str(tmp_path / "without")]
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    here, without = detections(tmp_path / "here"), detections(tmp_path / "without")
    assert len(here) == len(without) == 1
    for one, other in zip(here, without, strict=True):
        # Sums in another order lead the search along another way to the same place.
        place = [f["pose"]["position"] for f in (one, other)]
        assert all(abs(a - b) < 0.02 * place[0][2] for a, b in zip(*place, strict=True))
        assert {c["name"] for c in one["components"]} == {c["name"] for c in other["components"]}
