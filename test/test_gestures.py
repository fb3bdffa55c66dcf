"""Gestures of a made-up figure, from files alone to the class that is told: `benchmarks/gestures.py`, a few frames."""

from __future__ import annotations

from pathlib import Path

import pytest

from artrec_ros.simulation.config import SensorConfig

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


def test_taught_gestures_are_told_and_others_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(BENCHMARKS))
    gestures = pytest.importorskip("gestures")
    sensor = SensorConfig()
    gestures.write_object(tmp_path)
    gestures.train(tmp_path, 12, gestures.HEADING_RAD["flat"], sensor)
    rates = {p: gestures.report(p, gestures.recognise(tmp_path, p, n, sensor)) for p, n in (("flat", 3), ("space", 1))}
    for path, rate in rates.items():
        assert rate["right"] >= 0.75
        assert rate["refused"] > 0.6
        assert (tmp_path / f"{path}_up_0.png").is_file()
