"""Compiled code is ready before the first image."""

import json
import os
import subprocess
import sys
import time
from pathlib import Path

import pytest

from artrec_ros.core import warm_up
from artrec_ros.core.base import kernel_cache

ROOT = Path(__file__).parents[2]
SIGNATURES = """
from artrec_ros.core import recognizer  # all kernels are imported
from artrec_ros.core.base.jit import kernels
from artrec_ros.core.warm_up_pieces import ROOMS

def compiled_for():
    found = kernels({room for rooms in ROOMS.values() for room in rooms})
    assert len(found) > 60
    return {f"{k.py_func.__module__}.{k.py_func.__qualname__}": k.signatures for k in found}
"""
PROGRAM = (
    SIGNATURES
    + """
from artrec_ros.core.base.config import RecognizerConfig
from artrec_ros.io.parameters.parameter_file import load_parameters
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
)
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


VARIED_PROGRAM = (
    SIGNATURES
    + """
from dataclasses import replace

import pickle
import numpy as np
from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.objects import Component, Marker, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.warm_up import get_ready
from artrec_ros.core.warm_up_pieces import PLANE, SPACE
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.simulator import pinhole_camera, simulate

get_ready((SPACE, PLANE))
before = compiled_for()
several = {name: kinds for name, kinds in before.items() if len(kinds) > 1}
assert not several, several  # one memory layout, one kind of number

aibo = load_parameters("config/aibo.yaml")
outline = np.array([[0, 0], [0.3, 0], [0.3, 0.2], [0.1, 0.2], [0, 0.1]])
flat = Marker("flat", outline, np.zeros(2), np.array([0.1, 0.0]), None, Pose(np.eye(3), np.zeros(3)))
alone = Target("alone", ObjectModel("alone", (Component("only", (flat,), required=True),)), 3)
plain = pinhole_camera((320, 240), 60.0)
bent = replace(plain, distortion=np.array([-0.2, 0.05, 0.001, 0.001, 0.0]))
scene = SceneConfig(objects=(1, 2), size=(0.5, 0.7), facing=1.0, distractors=2)
found = 0
for targets in (aibo.targets, (alone,), (alone, *aibo.targets)):
    for profile in ("default", "paper"):
        each = Recognizer(targets, RecognizerConfig(profile=profile), Segmenter(ImageConfig()))
        for camera in (plain, bent, pickle.loads(pickle.dumps(bent))):  # the last as from another process
            for n, frame in enumerate(simulate(targets, camera, scene, SensorConfig(), 2, 5)):
                for known in (camera, None)[: 1 + (n == 0 and profile == "default")]:
                    result = each.recognize(frame.labels, known)
                    list(result.rejected)
                    found += len(result.detections)
each.recognize(np.zeros((240, 320), np.uint8), plain)
assert found > 4, found
late = {name: kinds for name, kinds in compiled_for().items() if kinds != before[name]}
assert not late, late
"""
)


FACING_PROGRAM = (
    SIGNATURES
    + """
import numpy as np
from artrec_ros.core.base.config import ClassConfig, ImageConfig, RecognizerConfig
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.target import Target
from artrec_ros.core.recognizer import Recognizer
from squares import TEAM, Placing, gate, rendered, robot
from solids import sign

rgb = {TEAM: (230, 200, 30), 4: (40, 160, 60), 5: (210, 40, 60), 6: (120, 60, 170), 7: (30, 90, 200)}
classes = {f"c{label}": ClassConfig(label=label, rgb=colour) for label, colour in rgb.items()}
table = np.array([rgb.get(n, (60, 60, 62))[::-1] for n in range(256)], np.uint8)
one, two = Placing(40.3, 40.2, 0.4, 330.0, "gr", 0.3), Placing(100.3, 70.2, 2.4, 330.0, "vr", -0.2)
late, found = [], 0
for models in ((robot(),), (gate(), sign()), (sign(),)):
    targets = [Target(model.name, model, TEAM) for model in models]
    for kind in ("labels", "colour"):
        image = ImageConfig(kind=kind, classes=classes if kind == "colour" else {})
        recognizer = Recognizer(targets, RecognizerConfig(), Segmenter(image), calibrated=False)
        before = compiled_for()
        for placed in ((one,), (one, two), ()):
            labels = rendered(*placed)
            result = recognizer.recognize(labels if kind == "labels" else table[labels])
            list(result.rejected)
            found += len(result.detections)
        late += [(kind, name) for name, kinds in compiled_for().items() if kinds != before[name]]
assert found > 8, found
assert not late, late
"""
)


@pytest.mark.parametrize(
    "program",
    [PROGRAM, SIGNATURES + FLAT_PROGRAM, VARIED_PROGRAM, FACING_PROGRAM],
    ids=["whole objects", "image plane", "all sorts", "facing"],
)
def test_the_first_images_compile_nothing(program):
    environment = {**os.environ, "PYTHONPATH": f"{ROOT}:{ROOT / 'test' / 'core'}"}
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stderr


ANSWERS = """
import json, sys
from artrec_ros.core.base.jit import kernels
from artrec_ros.core.warm_up_pieces import PLANE, ROOMS, SPACE
from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.simulator import simulate
from numba.core import event
from artrec_ros.core.model.target import Target
from solids import RED, camera_of, truck

compiled = []

class Listener(event.Listener):
    def on_start(self, begun):
        compiled.append(begun.data["dispatcher"].py_func.__qualname__)

    def on_end(self, ended):
        pass

event.register("numba:compile", Listener())
told = []
target, camera = Target("truck", truck(), RED), camera_of()
recognizer = Recognizer((target,), RecognizerConfig(), Segmenter(ImageConfig()), told=told.append)
in_frames = len(compiled)
own = set(ROOMS[SPACE]) - set(ROOMS[PLANE])  # of what both need some is the other one's alone
never = [k.py_func.__qualname__ for k in kernels(own) if not (k.signatures or k._cache.has_results)]
answers = []
scene = SceneConfig(objects=(1, 2), size=(0.4, 0.7), facing=1.0, distractors=1)
for frame in simulate((target,), camera, scene, SensorConfig(), 3, 7):
    result = recognizer.recognize(frame.labels, camera)
    answers.append((result.complete, repr(result.detections), repr(list(result.rejected))))
print(json.dumps({"answers": answers, "told": told, "in_frames": compiled[in_frames:], "never": never}))
"""


def answers(folder):
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(folder), "PYTHONPATH": f"{ROOT}:{ROOT / 'test' / 'core'}"}
    done = subprocess.run(
        [sys.executable, "-c", ANSWERS], env=environment, cwd=folder, capture_output=True, text=True, timeout=900
    )
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_the_first_start_answers_as_later_ones_do(tmp_path):
    """Of an object with places in space, in colours that neither its bodies nor anything else has."""
    cold, warm = answers(tmp_path), answers(tmp_path)
    assert all(complete for complete, _, _ in cold["answers"])
    assert any("Detection(" in found for _, found, _ in cold["answers"])
    assert cold["answers"] == warm["answers"]
    assert not cold["in_frames"] and not warm["in_frames"]
    assert not cold["never"], "what other objects or pictures need would be compiled in one of their frames"
    assert not warm["told"] and cold["told"] == sorted(cold["told"]) and cold["told"][-1] > 0.5


def test_where_nothing_can_be_kept_it_is_told_how_far_it_is_from_the_first_moment_on(monkeypatch, tmp_path):
    told, seen = [], []

    def run():
        seen.append(list(told))
        end_s = time.monotonic() + 30
        while len(told) < 3 and time.monotonic() < end_s:
            time.sleep(0.01)

    monkeypatch.setattr(kernel_cache, "writable", lambda: None)
    monkeypatch.setattr(kernel_cache, "folders", lambda: (tmp_path,))
    monkeypatch.setattr(warm_up, "_ready", set())
    monkeypatch.setattr(warm_up, "WHOLE", {"space": (run,)})
    monkeypatch.setattr(warm_up, "kernels", lambda rooms: ["one"])
    monkeypatch.setattr(warm_up, "share_compiled", lambda some: 0.1 * len(told))
    warm_up.get_ready(["space"], told.append)
    assert seen == [[0.0]] and len(told) >= 3
    count = len(told)
    time.sleep(3 * warm_up._LOOK_S)
    assert len(told) == count, "nothing more when it is done"
    assert warm_up.compiling() == "compiling, at every start"
    assert not warm_up.is_kept(), "another process would begin anew"
    (tmp_path / "space.ready").touch()
    assert warm_up.is_kept()


def test_a_process_whose_results_cannot_be_kept_ends_and_says_why():
    program = """
from artrec_ros.core import warm_up
from artrec_ros.core.base import kernel_cache
kernel_cache.note_failed_write("/there: compiled code cannot be written: No space left on device")
warm_up._end_in_vain()
"""
    done = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (3, "")
    assert done.stdout == "/there: compiled code cannot be written: No space left on device"


def test_where_one_process_has_no_room_for_its_results_the_others_end_and_it_is_known_why(monkeypatch, tmp_path):
    program = tmp_path / "python"  # the first one that is started has no room, the others have much to do
    program.write_text("#!/bin/sh\nmkdir \"$0.first\" 2>&- || exec sleep 60\nprintf '/there: full'\nexit 3\n")
    program.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(program))
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: {0, 1})
    monkeypatch.setattr(kernel_cache, "_problem", "")
    monkeypatch.setattr(kernel_cache, "writable", lambda: tmp_path)
    monkeypatch.setattr(warm_up, "kernels", lambda rooms: ["one"])
    began_s = time.monotonic()
    warm_up._compile(["space"], lambda: None)
    assert time.monotonic() - began_s < 30
    assert kernel_cache.problem().startswith("/there: full; each start compiles anew, which takes minutes: make room")
