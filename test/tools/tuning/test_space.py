from __future__ import annotations

import pytest
import yaml

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.parameters.parameter_file import Setup, load_parameters
from artrec_ros.tools.tuning.space import changed, distributions, load_space, suggested_of, values_of

from .lamp import write_lamp


@pytest.fixture
def setup(tmp_path) -> Setup:
    return load_parameters(write_lamp(tmp_path))


def space(tmp_path, setup, parameters):
    path = tmp_path / "space.yaml"
    path.write_text(yaml.safe_dump({"format": "artrec_search/1", "parameters": parameters}, sort_keys=False))
    return load_space(path, setup)


NUMBERS = {"low": 0.4, "high": 0.8}


@pytest.mark.parametrize(
    ("parameters", "told"),
    [
        ({"recognizer.min_mach": NUMBERS}, "did you mean 'recognizer.min_match'"),
        ({"recogniser.min_match": NUMBERS}, "did you mean 'recognizer.min_match'"),
        ({"tracking.speed": NUMBERS}, "does not change what is found"),
        ({"lamp.object_file": {"choices": ["a", "b"]}}, "does not change what is found"),
        ({"recognizer.min_match": {"low": 0.4}}, "high is missing"),
        ({"recognizer.min_match": {"low": 0.4, "high": 1.4}}, "recognizer.min_match.high"),
        ({"recognizer.min_match": {"low": 0.8, "high": 0.4}}, "low 0.8 is not below high 0.4"),
        ({"recognizer.min_match": {"low": 0.0, "high": 0.4, "log": True}}, "log: needs a low above 0"),
        ({"recognizer.min_match": {"lowest": 0.4, "high": 0.5}}, "unknown key"),
        ({"recognizer.min_match": {"choices": [0.5]}}, "two choices or more"),
        ({"recognizer.min_match": {"choices": [0.5, 3.0]}}, "choices"),
        ({"recognizer.min_match": {"choices": [0.5, 0.6], "low": 0.1}}, "has choices, so"),
        ({"expert.alignment.refine_keep": {"low": 4.5, "high": 9}}, "whole number"),
        ({"expert.alignment.refine_keep": {"low": 4, "high": 9, "step": 0.5}}, "whole number"),
        ({"recognizer.profile": NUMBERS}, "needs choices"),
        ({"recognizer.profile": {"choices": ["default", "papre"]}}, "papre"),
        ({"expert.alignment.couple_spans": {"low": 1, "high": 3}}, "expert.alignment.couple_spans[0]"),
        ({"expert.alignment.couple_spans[2]": {"low": 1, "high": 3}}, "has no element 2"),
        ({"recognizer.min_match[0]": NUMBERS}, "has no element 0"),
        ({}, "names no parameter"),
    ],
)
def test_what_is_no_search_space_is_refused(tmp_path, setup, parameters, told):
    with pytest.raises(ConfigError) as caught:
        space(tmp_path, setup, parameters)
    assert told in str(caught.value) and "space.yaml" in str(caught.value) and "\n" not in str(caught.value)


PARAMETERS = {
    "recognizer.min_match": NUMBERS,
    "expert.alignment.tolerance_px": {"low": 0.5, "high": 8.0, "log": True},
    "expert.alignment.refine_keep": {"low": 4, "high": 40, "step": 4},
    "expert.alignment.couple_spans": {"choices": [[1], [1, 2]]},
    "recognizer.profile": {"choices": ["default", "paper"]},
    "expert.blobs.anchor_tolerances_px[1]": {"low": 1.0, "high": 4.0},
}


def test_values_become_a_set_up(tmp_path, setup):
    dimensions = space(tmp_path, setup, PARAMETERS)
    suggested = {
        "recognizer.min_match": 0.512345, "expert.alignment.tolerance_px": 3.0, "expert.alignment.refine_keep": 8,
        "expert.alignment.couple_spans": "[1]", "recognizer.profile": '"paper"',
        "expert.blobs.anchor_tolerances_px[1]": 2.5,
    }  # fmt: skip
    values = values_of(dimensions, suggested)
    config = changed(setup, dimensions, values).recognizer
    assert (config.min_match, config.alignment.tolerance_px, config.alignment.refine_keep) == (0.5123, 3.0, 8)
    assert (config.alignment.couple_spans, config.profile) == ((1,), "paper")
    assert config.blobs.anchor_tolerances_px == (1.0, 2.5)


def test_rounding_keeps_to_the_limits(tmp_path, setup):
    (dimension,) = space(tmp_path, setup, {"recognizer.min_match": {"low": 0.400049, "high": 0.499999}})
    assert dimension.rounded(0.400049) == 0.400049 and dimension.rounded(0.499999) == 0.499999


def test_the_given_values_are_found_in_the_space_or_not(tmp_path, setup):
    inside = space(tmp_path, setup, {k: v for k, v in PARAMETERS.items() if k != "expert.alignment.refine_keep"})
    suggested = suggested_of(inside, setup.resolved)
    assert suggested is not None and suggested["expert.alignment.couple_spans"] == "[1, 2]"
    assert changed(setup, inside, values_of(inside, suggested)).resolved == setup.resolved
    outside = space(tmp_path, setup, {"recognizer.min_match": {"low": 0.1, "high": 0.2}})
    off_grid = space(tmp_path, setup, {"expert.alignment.refine_keep": {"low": 5, "high": 40, "step": 4}})
    assert suggested_of(outside, setup.resolved) is None and suggested_of(off_grid, setup.resolved) is None


def test_values_that_do_not_go_together_are_an_error(tmp_path, setup):
    scales = {f"recognizer.{name}_scale": {"low": 1, "high": 900} for name in ("min", "max")}
    dimensions = space(tmp_path, setup, scales)
    with pytest.raises(ConfigError, match="do not go together.*max_scale"):
        changed(setup, dimensions, {"recognizer.min_scale": 500.0, "recognizer.max_scale": 100.0})


def test_optuna_takes_them_all(tmp_path, setup):
    pytest.importorskip("optuna")
    assert list(distributions(space(tmp_path, setup, PARAMETERS))) == list(PARAMETERS)
