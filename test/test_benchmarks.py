"""Programs in `benchmarks/`: nothing that they import has moved, and those that have options tell of them."""

import importlib
import runpy
import sys
from pathlib import Path

import pytest

PROGRAMS = sorted((Path(__file__).parents[1] / "benchmarks").glob("*.py"))


@pytest.mark.parametrize("program", PROGRAMS, ids=lambda path: path.stem)
def test_a_program_imports_and_takes_its_arguments(program, monkeypatch, capsys):
    monkeypatch.syspath_prepend(str(program.parent))
    importlib.import_module(program.stem)
    text = program.read_text(encoding="utf-8")
    if "__main__" not in text or "argparse" not in text:
        return  # what others import; or its words are not looked at before it works
    monkeypatch.setattr(sys, "argv", [str(program), "--help"])
    with pytest.raises(SystemExit) as ended:
        runpy.run_path(str(program), run_name="__main__")
    assert ended.value.code in (None, 0) and f"usage: {program.name}" in capsys.readouterr().out
