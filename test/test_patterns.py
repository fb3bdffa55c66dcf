"""`benchmarks/patterns.py`: patterns of equal markers among clutter, a few of them."""

from pathlib import Path

import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.fixture
def patterns(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    import patterns

    return patterns


@pytest.fixture
def random_patterns(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    import random_patterns

    return random_patterns


def test_patterns_have_4_to_24_equal_markers_and_scenes_clutter_of_their_class(random_patterns):
    for seed in range(9):
        pattern = random_patterns.random_pattern(seed)
        areas = [c.markers[0].area for c in pattern.target.model.components]
        assert 4 <= len(areas) <= 24 and np.ptp(areas) < 1e-9
    frames = list(random_patterns.pattern_frames(pattern, 1, 6, (320, 240)))
    assert [len(f.truths) for f in frames] == [1, 1, 1, 1, 1, 0]
    assert np.mean(frames[-1].labels == random_patterns.LABEL) > 0.05


def test_a_pattern_moved_by_a_pitch_is_not_right_and_one_turned_to_itself_is(random_patterns):
    pattern = next(
        p for p in map(random_patterns.random_pattern, range(100)) if p.kind == "row" and p.shape == "square"
    )
    model, centres = pattern.target.model, pattern.centres
    true = Pose(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, 1.0]))
    pitch = centres[1] - centres[0]
    half = Pose(rotation_from_rotvec([0.0, 0.0, np.pi]), centres[0] + centres[-1])
    assert random_patterns.same_places(model, true, true)
    assert random_patterns.same_places(model, true @ half, true)
    assert not random_patterns.same_places(model, true @ Pose(np.eye(3), pitch), true)


def test_the_benchmark_runs_and_most_are_right(patterns, monkeypatch, capsys):
    monkeypatch.setattr("sys.argv", ["patterns.py", "--patterns", "3", "--scenes", "2", "--first", "2001"])
    patterns.main()
    rows = {line.split()[0]: line.split() for line in capsys.readouterr().out.splitlines() if line}
    assert int(rows["all"][1]) == 6 and float(rows["all"][2]) > 0.6
