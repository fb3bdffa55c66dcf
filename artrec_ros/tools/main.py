"""`artrec`: one command line, one subcommand a file, one place where errors become messages and exit codes."""

from __future__ import annotations

import argparse
import importlib
import os
import sys
from collections.abc import Sequence
from contextlib import nullcontext

from ..core.errors import ArtrecError
from .examples import HelpFormatter, epilog
from .own_lines import own_lines_only

DONE, FAILED, WRONG_USAGE, INTERRUPTED = 0, 1, 2, 130

# command -> what `artrec --help` says; its module artrec_ros.tools.COMMAND is imported when it is called for
COMMANDS = {
    "train": "learn an object's constraints from annotated images",
    "learn-colours": "learn a camera's colours from images in which they are told",
    "replay": "run the recogniser over bags or folders of images",
    "evaluate": "score a replay against the truth",
    "tune": "search parameters on frames with truth",
    "simulate": "render scenes with known truth",
    "play": "publish a bag with its stamps and /clock",
    "model": "make an object file from pictures, a drawing or a URDF, and check it",
    "inspect": "print what files hold, and whether they fit together",
}

# rclpy is imported in `node` alone, and nothing here imports that: what needs ROS is named, and found when it is called
NEEDING_ROS = {"play": "artrec_ros.node.play"}


def main(argv: Sequence[str] | None = None) -> int:
    """Runs a command. Returns 0: done, 1: the work failed, 2: wrong usage, 130: interrupted.

    :param argv: None: those of the process, whose stderr is then for our own lines alone.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    loud = argv is not None or "--debug" in arguments or _called(arguments) in NEEDING_ROS  # ROS logs from C
    with nullcontext() if loud else own_lines_only():
        return _run(arguments)


def _run(arguments: list[str]) -> int:
    try:
        args = _parse(arguments)
    except SystemExit as leaving:  # argparse has said why
        return leaving.code if isinstance(leaving.code, int) else WRONG_USAGE
    except ImportError as error:
        return _fail(f"{error}; install what is missing", "--debug" in arguments)
    try:
        return int(args.run(args))
    except ArtrecError as error:
        return _fail(str(error), args.debug)
    except KeyboardInterrupt:
        print("artrec: interrupted", file=sys.stderr)
        return INTERRUPTED
    except BrokenPipeError:  # the reader of our output has left, as `| head` does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return FAILED
    except OSError as error:
        return _fail(str(error), args.debug)
    except Exception as error:
        return _fail(f"internal error: {type(error).__name__}: {error}; --debug shows where", args.debug)


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
    parser = argparse.ArgumentParser(prog="artrec", description="Recognise articulated objects by their markers.")
    parser.add_argument("--debug", action="store_true", help="show a traceback with an error")
    subparsers = parser.add_subparsers(dest="command", metavar="COMMAND", required=True)
    called = _called(arguments)
    for command, summary in COMMANDS.items():
        if command == called:
            module = importlib.import_module(NEEDING_ROS.get(command, f"{__package__}.{command.replace('-', '_')}"))
            module.add_parser(subparsers)
            chosen = subparsers.choices[command]
            chosen.formatter_class, chosen.epilog = HelpFormatter, epilog(command, chosen.epilog)
            chosen.set_defaults(run=module.run)
            # --debug is as good behind the command as before it
            subparsers.choices[command].add_argument(
                "--debug", action="store_true", default=argparse.SUPPRESS, help=argparse.SUPPRESS
            )
        else:
            subparsers.add_parser(command, help=summary)
    return parser.parse_args(arguments)


if __name__ == "__main__":
    sys.exit(main())
