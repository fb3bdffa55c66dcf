"""The command line as a whole: help, exit codes, one line an error, tracebacks on demand."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from contextlib import suppress
from importlib.metadata import version
from pathlib import Path

import cv2
import numpy as np
import pytest

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.tools import main as command_line
from artrec_ros.tools import train
from artrec_ros.tools.main import COMMANDS, INTERRUPTED, _parse, main

TRAIN = ["train", "--object", "none.yaml", "--annotations", "none.json", "-o", "out.yaml"]


def test_help_lists_the_commands(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--help"]) == 0
    printed = capsys.readouterr().out
    assert all(command in printed for command in COMMANDS)


@pytest.mark.parametrize("command", COMMANDS)
def test_every_command_has_help(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main([command, "--help"]) == 0
    assert f"usage: artrec {command}" in capsys.readouterr().out


def test_help_imports_no_command() -> None:
    code = "import sys; from artrec_ros.tools.main import main; main(['--help']); print('cv2' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert done.stdout.splitlines()[-1] == "False"


@pytest.mark.parametrize("arguments", [[], ["trian"], ["train"], ["train", "--nonsense"], ["--nonsense"]])
def test_wrong_usage_is_2(arguments: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith("artrec") and "--help tells the usage" in error and len(error.splitlines()) == 1


def test_an_option_of_another_command_leads_to_the_help_of_this_one(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", "p.yaml", "--rate", "15"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("artrec inspect: error: unrecognized arguments: --rate 15; artrec inspect --help")


def test_positionals_may_stand_between_options() -> None:
    words = ["replay", "bag_0", "--params-file", "node.yaml", "bag_1", "--rate", "15", "bag_2", "-o", "out", "--debug"]
    args = _parse(["--debug", *words])
    assert [str(path) for path in args.sources] == ["bag_0", "bag_1", "bag_2"]
    assert (args.debug, args.rate, str(args.output)) == (True, 15.0, "out")


@pytest.mark.parametrize("arguments", [["replay", "--params-file", "p.yaml"], ["train", "a", "-o", "b", "--object"]])
def test_what_is_missing_or_too_much_is_told_by_the_command(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith(f"artrec {arguments[0]}: error: ") and len(error.splitlines()) == 1


def test_failure_is_1_and_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(TRAIN) == 1
    captured = capsys.readouterr()
    assert captured.err == "artrec: none.yaml: there is no such file\n" and captured.out == ""


@pytest.mark.parametrize("arguments", [["--debug", *TRAIN], [*TRAIN, "--debug"]])
def test_debug_lets_the_error_through(arguments: list[str]) -> None:
    with pytest.raises(ConfigError):
        main(arguments)


@pytest.mark.parametrize(
    ("error", "code", "text"),
    [
        (KeyboardInterrupt(), 130, "interrupted"),
        (ConfigError("two\nlines"), 1, "two lines"),
        (PermissionError(13, "Permission denied", "out.yaml"), 1, "artrec: out.yaml: Permission denied"),
        (ZeroDivisionError("division"), 1, "internal error: ZeroDivisionError: division; --debug"),
    ],
)
def test_what_a_command_raises_becomes_a_code(
    error: BaseException, code: int, text: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def fail(_: object) -> int:
        raise error

    monkeypatch.setattr(train, "run", fail)
    assert main(TRAIN) == code
    captured = capsys.readouterr().err
    assert text in captured and captured.count("\n") == 1


def test_the_version_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["--version"]) == 0
    assert capsys.readouterr().out == f"artrec {version('artrec_ros')}\n"


_PROGRAM = "import sys, time; from artrec_ros.tools import main; {}; sys.exit(main.main())"
_SLEEPS = "print('ready', flush=True); time.sleep(60)"
_SLOW_IMPORT = f"main._parse = lambda _: [{_SLEEPS.replace('; ', ', ')}]"
_SLOW_WORK = (
    "import types; main._parse = lambda _: types.SimpleNamespace(debug=False, run=lambda _: "
    f"[{_SLEEPS.replace('; ', ', ')}])"
)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("change", [_SLOW_IMPORT, _SLOW_WORK], ids=["importing", "working"])
def test_ctrl_c_and_sigterm_are_one_line_and_130_at_any_time(change: str, number: int) -> None:
    command = [sys.executable, "-c", _PROGRAM.format(change), "inspect", "."]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        assert process.stdout is not None and process.stdout.readline() == "ready\n"
        process.send_signal(number)
        _, told = process.communicate(timeout=60)
    assert told == "artrec: interrupted\n" and process.returncode == INTERRUPTED


def test_little_is_imported_before_ctrl_c_is_answered() -> None:
    code = "import sys; before = set(sys.modules); import artrec_ros.tools.main; print(*set(sys.modules) - before)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=True)
    assert not {"argparse", "importlib.metadata", "numpy"} & set(done.stdout.split())


def test_a_call_from_another_program_leaves_its_signals_alone() -> None:
    before = signal.getsignal(signal.SIGINT)
    assert main(["--help"]) == 0 and signal.getsignal(signal.SIGINT) is before


@pytest.mark.parametrize(
    "command",
    [
        ["replay", "images", "--params-file", "p.yaml", "-o", ""],
        ["evaluate", "r", "--truth", "t.jsonl", "-o", ""],
        ["inspect", ""],
        ["train", "--object", "", "--from-joints", "-o", "c.yaml"],
    ],
)
def test_an_empty_name_is_no_folder(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert main(command) == 2
    assert "the name is empty, as of a variable that is not set; '.' is this folder" in capsys.readouterr().err


def test_a_name_that_is_no_text_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["inspect", "x\udcfe"]) == 2
    said = capsys.readouterr().err
    assert "/x\\udcfe is no text in utf-8; rename it, or set its locale" in said


def test_what_the_terminal_has_no_letters_for_is_printed_all_the_same(tmp_path: Path) -> None:
    (tmp_path / "größe.txt").touch()
    command = [sys.executable, "-m", "artrec_ros.tools.main", "inspect", str(tmp_path / "größe.txt")]
    environment = {**os.environ, "PYTHONIOENCODING": "ascii"}
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, env=environment, check=False)
    assert done.returncode == 1 and "gr\\xf6\\xdfe.txt" in done.stdout and "internal error" not in done.stderr


@pytest.mark.parametrize("command", ["train", "learn-colours"])
def test_an_output_that_cannot_be_written_is_told_before_the_work(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What would be worked on is not there, which would be told first otherwise."""
    (tmp_path / "file").touch()
    arguments = {
        "train": ["--object", str(tmp_path / "none.yaml"), "--from-joints"],
        "learn-colours": [str(tmp_path / "none"), "--classes", "red=2"],
    }
    assert main([command, *arguments[command], "-o", str(tmp_path / "file/out.yaml")]) == 1
    said = f"artrec: {tmp_path}/file/out.yaml: cannot be written: {tmp_path}/file is no folder\n"
    assert capsys.readouterr().err == said


def test_a_missing_piece_breaks_only_its_command(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(command_line.COMMANDS, "ghost", "needs what is not there")
    assert main(["ghost"]) == 1
    assert "ghost" in capsys.readouterr().err
    assert main(["--help"]) == 0


def test_stderr_is_for_our_own_lines_alone(tmp_path: Path) -> None:
    """What libraries write there from C, and warnings, are not seen; our error is; --debug shows all."""
    code = """
import os, sys, warnings
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.tools import inspect, main
def run(args):
    os.write(2, b"libpng error: bad adaptive filter value\\n")
    warnings.warn("overflow encountered in multiply", RuntimeWarning)
    raise ConfigError("our own line")
inspect.run = run
sys.argv = ["artrec", "inspect", "x", *sys.argv[1:]]
code = main.main()
os.write(2, b"afterwards\\n")
sys.exit(code)
"""
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert (done.returncode, done.stderr) == (1, "artrec: our own line\nafterwards\n")
    loud = subprocess.run([*command, "--debug"], capture_output=True, text=True, timeout=60, check=False)
    assert "libpng error" in loud.stderr and "overflow" in loud.stderr


def test_a_damaged_picture_ends_in_our_words_alone(tmp_path: Path) -> None:
    data = bytearray(cv2.imencode(".png", np.random.default_rng(1).integers(0, 9, (64, 64), np.uint8))[1].tobytes())
    data[60:200] = bytes(140)
    (tmp_path / "0.png").write_bytes(data)
    command = [sys.executable, "-m", "artrec_ros.tools.main", "inspect", str(tmp_path / "0.png")]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1 and "damaged image" in done.stdout and done.stderr == ""


WORKING = """
import sys
from pathlib import Path
from artrec_ros.io.base.bars import bar, say
from artrec_ros.tools import train
from artrec_ros.tools.getting_ready import progress
from artrec_ros.tools.main import main

def run(args):
    with progress() as told:
        told(0.5)
    for n in bar(range(2000), unit="step"):
        say(f"step {n}")
        print(f"figure {n}")  # more than a pipe's reader need wait for, or a buffer holds
    args.output.write_text("done")
    print("done")
    return 0

train.run = run
sys.argv = ["artrec", "train", "--object", "o.yaml", "--annotations", "a.json", "-o", sys.argv[1]]
sys.exit(main())
"""


@pytest.mark.parametrize(
    ("streams", "code"),
    [("2>/dev/full", 0), ("2>&-", 0), (">&- 2>&-", 0), ("2>&1 | head -n 1", 0), ("| head -n 1", 0), (">/dev/full", 1)],
)
def test_work_comes_to_its_end_where_nobody_can_be_told_of_it(streams: str, code: int, tmp_path: Path) -> None:
    (tmp_path / "working.py").write_text(WORKING)
    out = tmp_path / "out.txt"
    command = f"set -o pipefail; '{sys.executable}' '{tmp_path / 'working.py'}' '{out}' {streams}"
    done = subprocess.run(["bash", "-c", command], capture_output=True, text=True, timeout=60,
                          env={k: v for k, v in os.environ.items() if k != "PYTHONUNBUFFERED"})  # fmt: skip
    assert done.returncode == code, done.stderr
    assert out.read_text() == "done"
    last = [line for line in done.stderr.splitlines() if "step" not in line and "getting ready" not in line]
    assert last == (["artrec: stdout: cannot be written: No space left on device"] if code else [])


def test_work_does_not_wait_for_a_full_pipe_that_does_not(tmp_path: Path) -> None:
    """One that nobody reads, and that says so at once instead of holding who writes."""
    (tmp_path / "working.py").write_text(WORKING)
    read, write = os.pipe()
    os.set_blocking(write, False)
    with suppress(BlockingIOError):
        while True:
            os.write(write, b"x")
    out = tmp_path / "out.txt"
    done = subprocess.run([sys.executable, tmp_path / "working.py", out], stderr=write, timeout=60)
    os.close(read)
    os.close(write)
    assert done.returncode == 0 and out.read_text() == "done"


def test_lines_of_stdout_and_stderr_stay_whole_in_one_pipe() -> None:
    """More of stdout than a buffer holds: where it is full, it ends amid a line."""
    code = (
        "import sys; from artrec_ros.tools.own_lines import open_streams; open_streams(); "
        "[print('out', 'o' * 96) for _ in range(300)]; print('err', 'e' * 96, file=sys.stderr); print('end')"
    )
    buffered = {name: value for name, value in os.environ.items() if name != "PYTHONUNBUFFERED"}
    both = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    done = subprocess.run([sys.executable, "-c", code], **both, text=True, env=buffered, timeout=60, check=True)
    assert done.stdout.splitlines() == ["out " + "o" * 96] * 300 + ["err " + "e" * 96, "end"]


@pytest.mark.parametrize("seed", ["-1", "x", "99999999999999999999", "1.5"])
def test_a_seed_that_is_none_tells_the_range(seed: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", "o.yaml", "-o", "out", f"--seed={seed}"]) == 2
    assert f"--seed: '{seed}' is no seed: a whole number of 0 to 2147483647 is wanted" in capsys.readouterr().err


def test_a_working_folder_that_is_gone_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    (gone := tmp_path / "gone").mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    assert main(TRAIN) == 1
    monkeypatch.chdir(tmp_path)
    assert capsys.readouterr().err.startswith("artrec: the working directory cannot be read: No such file")
