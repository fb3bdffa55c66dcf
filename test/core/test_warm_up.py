"""Compiled code is ready before the first image."""

import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
SIGNATURES = """
import importlib, pkgutil
from artrec_ros import core

KERNELS = [m.name for m in pkgutil.walk_packages(core.__path__, core.__name__ + ".") if m.name.endswith("_kernels")]
assert len(KERNELS) > 10

def compiled_for():
    found = [f for name in KERNELS for f in vars(importlib.import_module(name)).values()]
    functions = [f for f in found if hasattr(f, "signatures")]
    return {f"{f.__module__}.{f.__name__}": f.signatures for f in functions}
"""
PROGRAM = SIGNATURES + """
from artrec_ros.core.base.config import RecognizerConfig
from artrec_ros.io.parameters import load_parameters
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.simulator import pinhole_camera, simulate

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
FLAT_PROGRAM = """
import numpy as np
from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.model.target import Target
from artrec_ros.core.model.objects import Component, Marker, ObjectModel
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.image.segmentation import Segmenter

square = Marker("square", np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]]), np.zeros(2), np.array([1.0, 0]))
bar = Marker("bar", 0.5 * square.outline * [2, 0.5], np.zeros(2), np.array([1.0, 0]))
labels = np.zeros((200, 300), np.uint8)
labels[40:100, 40:100] = labels[110:125, 40:100] = labels[60:130, 180:250] = 1
late = []
for profile in ("default", "paper"):
    for components in ((square,), (square, bar)):
        parts = tuple(Component(m.name, (m,), required=m is square) for m in components)
        target = Target("sign", ObjectModel("sign", parts), 1)
        recognizer = Recognizer((target,), RecognizerConfig(profile=profile), Segmenter(ImageConfig()))
        before = compiled_for()
        for _ in range(2):
            list(recognizer.recognize(labels).rejected)
        late += [(profile, name) for name, kinds in compiled_for().items() if kinds != before[name]]
assert not late, late
"""


@pytest.mark.parametrize("program", [PROGRAM, SIGNATURES + FLAT_PROGRAM], ids=["whole objects", "image plane"])
def test_the_first_images_compile_nothing(program):
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr
