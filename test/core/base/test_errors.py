"""Errors as users see them."""

import pytest

from artrec_ros.core.base.errors import ConfigError, one_line


@pytest.mark.parametrize("error", [ConfigError("a.yaml: line 3:\n no"), OSError("a.yaml: line 3: no")])
def test_what_was_raised_on_purpose_says_all_in_a_line(error):
    assert one_line(error) == "a.yaml: line 3: no"


def test_a_fault_is_told_in_short_without_a_terminals_colours():
    told = one_line(TypeError("\x1b[1mno match\x1b[0m\n" + "of many words " * 200))
    assert told.startswith("internal error: TypeError: no match of many words")
    assert len(told) < 350 and "\x1b" not in told and told.endswith(" ...")
