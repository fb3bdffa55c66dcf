"""A truth in other units, or with a joint or its rotations the wrong way round, is told."""

import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import Pose
from artrec_ros.tools.evaluate import evaluate

from .makers import found_thing, record, true_thing, write_run, write_truth

TURNS = np.linspace(0.3, 1.2, 8)
JOINT = "the truth's joint 'arm' of 'thing': "


def notes(tmp_path, joint=lambda q: q, position=lambda p: p, rotation=lambda R: R):
    """Of eight things that are found as they are, and a truth that says so in its own way."""
    truth, records = {}, []
    for stamp, turn in enumerate(TURNS, start=1):
        pose = Pose.from_xyz_rpy([0.02, 0, 1.0], [np.pi - 0.3, turn, 0.5 * turn])
        records.append(record(stamp, found_thing(0.02, pose=pose, joints={"arm": float(turn) + 0.01})))
        told = Pose(rotation(pose.rotation), position(pose.position))
        truth[stamp] = [true_thing(0.02, pose=told, joints={"arm": float(joint(turn))})]
    ((result,), _) = evaluate([write_run(tmp_path / "r", records)], write_truth(tmp_path / "t.jsonl", truth))
    return list(result.evaluation.notes)


def test_of_a_truth_that_is_one_nothing_is_said(tmp_path):
    assert notes(tmp_path) == []


@pytest.mark.parametrize(
    ("slip", "said"),
    [
        ({"joint": np.degrees}, JOINT + "in degrees?"),
        ({"joint": np.negative}, JOINT + "with the other sign"),
        ({"joint": lambda q: -np.degrees(q)}, JOINT + "in degrees, and with the other sign?"),
        ({"position": lambda p: 1000 * p}, "the truth's positions of 'thing': in millimetres?"),
        ({"rotation": np.transpose}, "the truth's rotations of 'thing': transposed?"),
    ],
)
def test_slips_are_told(slip, said, tmp_path):
    (note,) = notes(tmp_path, **slip)
    assert note.startswith(said)
