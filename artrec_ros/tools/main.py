"""`artrec`: one command line, one subcommand a file, one place where errors become messages and exit codes."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # more is imported when it is needed: Ctrl-C is answered from the first moment on
    import argparse

DONE, FAILED, WRONG_USAGE, INTERRUPTED = 0, 1, 2, 130
_ENDING = (signal.SIGINT, signal.SIGTERM)  # Ctrl-C, and what service managers and `kill` send

# command -> what `artrec --help` says; its module artrec_ros.tools.COMMAND is imported when it is called for
COMMANDS = {
    "train": "learn an object's constraints from annotated images",
    "learn-colours": "learn a camera's colours from images in which they are told",
    "replay": "run the recogniser over bags, folders of images or videos",
    "evaluate": "score a replay against the truth",
    "tune": "search parameters on frames with truth",
    "simulate": "render scenes with known truth",
    "play": "publish a bag with its stamps and /clock",
    "model": "make an object file from pictures, a drawing or a URDF, and check it",
    "trace": "measure markers' outlines by images in which objects are found",
    "prepare": "compile ahead what recognition needs, as in an image or on a robot",
    "inspect": "print what files hold, and whether they fit together",
    "studio": "look, mark and tune in the browser",
}

# rclpy is imported in `node` alone, and nothing here imports that: what needs ROS is named, and found when it is called
NEEDING_ROS = {"play": "artrec_ros.node.play"}


def main(argv: Sequence[str] | None = None) -> int:
    """Runs a command. Returns 0: done, 1: the work failed, 2: wrong usage, 130: interrupted, by Ctrl-C or SIGTERM.

    :param argv: the words behind `artrec`; None: this is the program itself, which then answers to these in its own
        way, also while it still imports and while it ends, and whose stderr is for its own lines alone.
    """
    if argv is not None:
        return _main(list(argv))
    for number in _ENDING:
        signal.signal(number, _leave)
    from .own_lines import flush_stdout, open_streams, own_lines_only

    stdout = open_streams()
    arguments = sys.argv[1:]
    loud = "--debug" in arguments or _called(arguments) in NEEDING_ROS  # ROS logs from C
    with nullcontext() if loud else own_lines_only():
        code = _main(arguments)
        if problem := flush_stdout(stdout):
            print(f"artrec: {problem}", file=sys.stderr)
        return code or int(bool(problem))


def _leave(*_: object) -> None:
    """Ctrl-C or SIGTERM while nothing is at work: nothing to clean up either."""
    with suppress(OSError):  # nobody may be there to read it
        os.write(sys.stderr.fileno(), b"artrec: interrupted\n")
    os._exit(INTERRUPTED)


@contextmanager
def _at_work() -> Iterator[None]:
    """Ctrl-C and SIGTERM raise KeyboardInterrupt: there is something to clean up."""
    if signal.getsignal(signal.SIGINT) is not _leave:
        yield
        return
    for number in _ENDING:
        signal.signal(number, signal.default_int_handler)
    try:
        yield
    finally:
        for number in _ENDING:
            signal.signal(number, _leave)


def _main(arguments: list[str]) -> int:
    from ..core.base.errors import ArtrecError, one_line
    from ..io.base.working_folder import check_working_folder

    try:
        check_working_folder()
        args = _parse(arguments)
    except ArtrecError as error:
        return _fail(str(error), "--debug" in arguments)
    except SystemExit as leaving:  # argparse has said why
        return leaving.code if isinstance(leaving.code, int) else WRONG_USAGE
    except ImportError as error:
        return _fail(f"{error}; install what is missing", "--debug" in arguments)
    try:
        with _at_work():
            return int(args.run(args))
    except ArtrecError as error:
        return _fail(str(error), args.debug)
    except KeyboardInterrupt as interrupt:
        print(": ".join(["artrec", "interrupted", *map(str, interrupt.args)]), file=sys.stderr)
        return INTERRUPTED
    except OSError as error:
        reason = error.strerror or str(error)
        return _fail(f"{error.filename}: {reason}" if error.filename else reason, args.debug)
    except Exception as error:
        return _fail(f"{one_line(error)}; --debug shows where", args.debug)


def _fail(message: str, debug: bool) -> int:
    """Called while an exception is handled."""
    if debug:
        raise
    print(f"artrec: {' '.join(message.split())}", file=sys.stderr)
    return FAILED


def _called(arguments: Sequence[str]) -> str | None:
    """The command, which comes before all that has no dashes."""
    return next((a for a in arguments if not a.startswith("-")), None)


def _parse(arguments: list[str]) -> argparse.Namespace:
    import argparse
    import importlib

    from .. import __version__
    from .examples import HelpFormatter, epilog
    from .options.one_line_parser import OneLineParser

    parser = OneLineParser(prog="artrec", description="Recognise articulated objects by their markers.")
    parser.add_argument("--version", action="version", version=f"artrec {__version__}")
    parser.add_argument("--debug", action="store_true", help="show a traceback with an error")
    called = _called(arguments)
    subparsers = parser.add_subparsers(metavar="COMMAND", required=called not in COMMANDS)
    for command, summary in COMMANDS.items():
        if command == called:
            module = importlib.import_module(NEEDING_ROS.get(command, f"{__package__}.{command.replace('-', '_')}"))
            module.add_parser(subparsers)
            chosen = subparsers.choices[command]
            chosen.formatter_class, chosen.epilog = HelpFormatter, epilog(command, chosen.epilog)
            chosen.set_defaults(run=module.run)
            # --debug is as good behind the command as before it
            chosen.add_argument("--debug", action="store_true", default=argparse.SUPPRESS, help=argparse.SUPPRESS)
        else:
            subparsers.add_parser(command, help=summary)
    if called not in COMMANDS:
        return parser.parse_args(arguments)  # help, the version, or what is wrong
    place = arguments.index(called)
    args = parser.parse_args(arguments[:place])
    # by the command's own parser: else argparse would let no positionals stand between options, and name the help of
    # `artrec` itself, which helps no one
    return subparsers.choices[called].parse_intermixed_args(arguments[place + 1 :], args)


if __name__ == "__main__":
    sys.exit(main())
