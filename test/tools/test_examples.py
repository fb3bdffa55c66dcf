"""Each command's help has examples, and they are valid command lines."""

import shlex

import pytest

from artrec_ros.tools.examples import EXAMPLES, epilog
from artrec_ros.tools.main import COMMANDS, NEEDING_ROS, _parse, main


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_an_example_that_parses(command):
    if command in NEEDING_ROS:
        pytest.importorskip("rclpy")
    assert EXAMPLES.get(command), f"artrec {command} has no example"
    for example in EXAMPLES[command]:
        program, *arguments = shlex.split(example)
        assert (program, arguments[0]) == ("artrec", command)
        assert _parse(arguments).run.__module__.endswith(f".{command.replace('-', '_')}")


def test_examples_stand_in_the_help_each_on_a_line_of_its_own(capsys):
    assert main(["simulate", "--help"]) == 0
    printed = capsys.readouterr().out.splitlines()
    assert all(f"  {example}" in printed for example in EXAMPLES["simulate"])
    assert max(len(line) for line in printed if not line.startswith("  artrec")) <= 120


def test_examples_follow_a_commands_own_words():
    assert epilog("evaluate", "Own words.").startswith("Own words.\n\nexample")
    assert epilog("nothing", "Own words.") == "Own words." and epilog("nothing", None) == ""
