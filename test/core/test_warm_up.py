"""Compiled code is ready before the first image."""

import subprocess
import sys
from pathlib import Path

import pytest

from artrec_ros.core.base.jit import COMPILED

ROOT = Path(__file__).parents[2]
PROGRAM = """
import importlib, pkgutil
from artrec_ros.core import compiled
from artrec_ros.core.config import RecognizerConfig
from artrec_ros.io.parameters import load_parameters
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.simulator import pinhole_camera, simulate

def compiled_for():
    names = [f"{compiled.__name__}.{m.name}" for m in pkgutil.iter_modules(compiled.__path__)]
    functions = [f for name in names for f in vars(importlib.import_module(name)).values() if hasattr(f, "signatures")]
    return {f"{f.__module__}.{f.__name__}": f.signatures for f in functions}

setup = load_parameters("config/excavator.yaml")
recognizer = setup.build()
before = compiled_for()
camera = pinhole_camera((320, 240), 60.0)
found = []  # in each frame: of one target, several are described together
for objects, size, seed in (((1, 1), (0.5, 0.6), 3), ((3, 3), (0.3, 0.35), 4)):
    scene = SceneConfig(objects=objects, size=size, facing=1.0, distractors=1)
    for frame in simulate(setup.targets, camera, scene, SensorConfig(), 3, seed):
        found.append(len(recognizer.recognize(frame.labels, camera).detections))
assert min(found[:3]) < 2 <= max(found), found
late = [name for name, kinds in compiled_for().items() if kinds != before[name]]
assert not late, late
"""


@pytest.mark.skipif(not COMPILED, reason="numba is not installed")
def test_the_first_images_of_whole_objects_compile_nothing():
    done = subprocess.run([sys.executable, "-c", PROGRAM], cwd=ROOT, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
