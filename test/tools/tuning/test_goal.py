from __future__ import annotations

import argparse

import pytest

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.tools.tuning.goal import FIGURES, Goal, goal_of, limit


def measured(**figures):
    return dict.fromkeys(FIGURES) | figures


def test_better_figures_are_worth_more_in_their_own_sense():
    assert Goal("f1").worth(measured(f1=0.9)) > Goal("f1").worth(measured(f1=0.8))
    errors = Goal("position_error_median")
    assert errors.worth(measured(position_error_median=0.01)) > errors.worth(measured(position_error_median=0.02))


def test_limits_go_before_the_figure():
    goal = Goal("f1", (limit("latency_ms_p95<=30"), limit("precision >= 0.9")))
    kept = measured(f1=0.1, latency_ms_p95=30.0, precision=0.9)
    slow = measured(f1=0.9, latency_ms_p95=33.0, precision=0.9)
    slower = measured(f1=0.99, latency_ms_p95=60.0, precision=0.9)
    nothing = measured(f1=0.9, latency_ms_p95=10.0)
    order = [goal.worth(m) for m in (kept, slow, slower, nothing)]
    assert order == sorted(order, reverse=True) and len(set(order)) == 4
    assert goal.keeps_limits(kept) and not goal.keeps_limits(slow)
    assert str(goal) == "f1 with latency_ms_p95<=30 and precision>=0.9"


def test_speed_alone_is_no_goal():
    with pytest.raises(ConfigError, match="finding nothing is fastest"):
        goal_of("latency_ms_median", [])
    assert goal_of("latency_ms_median", [limit("f1>=0.9")]).worth(measured(f1=0.95, latency_ms_median=5.0)) == -5.0


@pytest.mark.parametrize("text", ["f1", "f1=0.9", "f2>=1", "f1>=many", "f1>=", "f1>=1e999"])
def test_what_is_no_limit(text):
    with pytest.raises(argparse.ArgumentTypeError):
        limit(text)
