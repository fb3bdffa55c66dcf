"""The parameters' page is what the dataclasses say."""

from __future__ import annotations

from pathlib import Path

from artrec_ros.io.specs import all_specs
from artrec_ros.tools.reference import parameters_page

PAGE = Path(__file__).resolve().parents[2] / "docs" / "parameters.md"


def test_the_page_is_up_to_date() -> None:
    assert PAGE.read_text(encoding="utf-8") == parameters_page(), (
        "python -m artrec_ros.tools.reference > docs/parameters.md"
    )


def test_every_parameter_is_on_the_page() -> None:
    page = parameters_page()
    for name in all_specs(["red"], ["pale"]):
        assert f"`{name.rpartition('.')[2]}`" in page or f"`{name}`" in page
