"""`artrec inspect` as users call it, and bags and truth for it to look at."""

import json
from pathlib import Path

import numpy as np

from artrec_ros.io.bags.writer import BagWriter
from artrec_ros.simulation.simulator import pinhole_camera
from artrec_ros.tools.main import main

CONFIG = Path(__file__).parents[3] / "config"

STAMP = 1_700_000_000_000_000_000

PATCH_ON_BODY = np.repeat(np.array([[2] * 20 + [6] * 20], np.uint8), 30, axis=0)  # (30, 40) the excavator's labels


def inspect(capsys, *paths):
    """(exit code, all that is printed, the problems)."""
    code = main(["inspect", *map(str, paths)])
    printed = capsys.readouterr().out
    return code, printed, [line for line in printed.splitlines() if line.startswith("problem: ")]


def write_bag(path, labels=(0, 2, 6), size=(40, 30), camera=(40, 30), topic="/camera/segmentation", frames=3):
    image = np.zeros((size[1], size[0]), np.uint8)
    for n, label in enumerate(labels):
        image[:, 4 * n : 4 * n + 4] = label
    with BagWriter(path) as bag:
        for n in range(frames):
            stamp = STAMP + n * 10**8
            if camera is not None:
                bag.write_camera("/camera/camera_info", stamp, pinhole_camera(camera, 60))
            bag.write_image(topic, stamp, "cam", image)
    return path


def write_truth(path, label=2, first=STAMP):
    record = {"team": label, "position": [0, 0, 1], "rotation": np.eye(3).tolist(), "joints": {}, "components": {}}
    path.write_text(json.dumps({"stamp_ns": first, "objects": [record | {"centre_px": [1, 1]}]}) + "\n")
    return path
