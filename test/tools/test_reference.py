"""The pages of reference are what the code says."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from artrec_ros.core.base.config import ImageConfig, NodeConfig, RecognizerConfig
from artrec_ros.io.messages.node_topics import INPUTS, OUTPUTS
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.io.parameters.specs import LIVE, all_specs
from artrec_ros.tools.reference import expert_page, parameters_page, parameters_yaml, topics_page

ROOT = Path(__file__).resolve().parents[2]


@pytest.mark.parametrize(
    ("path", "page", "name"),
    [
        ("docs/parameters.md", parameters_page, "parameters"),
        ("docs/expert_parameters.md", expert_page, "expert"),
        ("docs/topics.md", topics_page, "topics"),
        ("config/all_parameters.yaml", parameters_yaml, "yaml"),
    ],
)
def test_the_pages_are_up_to_date(path: str, page: Callable[[], str], name: str) -> None:
    assert (ROOT / path).read_text(encoding="utf-8") == page(), f"python -m artrec_ros.tools.reference {name} > {path}"


def test_every_parameter_is_told() -> None:
    page, experts, file = parameters_page(), expert_page(), parameters_yaml()
    for name, spec in all_specs(["red"], ["pale"]).items():
        last = name.rpartition(".")[2]
        told = experts if spec.is_expert else page
        assert f"`{last}`" in told or f"`{name}`" in told
        assert f" {last}:" in file
    assert all(f"`{name}`" in page for name in LIVE)


def test_the_file_of_all_parameters_gives_the_defaults() -> None:
    setup = load_parameters(ROOT / "config" / "all_parameters.yaml")
    assert (setup.image, setup.recognizer, setup.node) == (ImageConfig(), RecognizerConfig(), NodeConfig())


def test_the_experts_section_can_be_made_to_count(tmp_path: Path) -> None:
    head, _, experts = parameters_yaml().partition("    # expert:")
    text = head + "    expert:" + experts.replace("    #   ", "      ")
    for folder in ("objects", "constraints"):
        text = text.replace(f'"{folder}/', f'"{ROOT}/config/{folder}/')
    file = tmp_path / "all.yaml"
    file.write_text(text)
    assert load_parameters(file).recognizer == RecognizerConfig()


def test_every_topic_is_told() -> None:
    page = topics_page()
    assert all(f"| `{t.name}` | {t.type.replace('/msg', '')} |" in page for t in (*INPUTS, *OUTPUTS))
