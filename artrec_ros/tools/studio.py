"""`artrec studio`: look, mark and tune in the browser; what comes of it are files that the other commands read."""

from __future__ import annotations

import argparse
import contextlib
import getpass
import socket
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core.base.errors import ConfigError
from ..io.base.bars import say
from ..io.base.whole_files import held, make_folder
from ..io.base.yaml_files import like_it
from .options.paths import path
from .options.work_options import add_source_options, source_options

if TYPE_CHECKING:  # the rest is imported when it is needed: Ctrl-C is answered from the first moment on
    from ..io.parameters.parameter_file import Setup
    from .studio_state.ros import Ros
    from .studio_state.stills import Stills

_EPILOG = """\
Needs NiceGUI: pip install artrec_ros[studio]. The page is for this machine alone, unless --host says otherwise; from
another one, `ssh -L 8080:127.0.0.1:8080 THIS_MACHINE` brings it there.
"""


def add_parser(subparsers: Any) -> None:
    p = subparsers.add_parser("studio", help="look, mark and tune in the browser", description=__doc__, epilog=_EPILOG)
    p.add_argument(
        "source", metavar="SOURCE", type=path, nargs="?",
        help="folder of images, bag, or video file; left out: the live topic that --topic names",
    )  # fmt: skip
    p.add_argument(
        "--params-file", required=True, type=path, action="append", metavar="NODE.yaml",
        help="the objects to look for; colours and constraints may yet be missing. May be given again",
    )  # fmt: skip
    p.add_argument(
        "-o", "--output", type=path, default=Path("studio"), metavar="DIR",
        help="where all is written that is made; what lies there is gone on with (default: studio)",
    )  # fmt: skip
    p.add_argument(
        "--annotations", type=path, nargs="+", default=[], metavar="COCO.json", help="examples marked before"
    )
    p.add_argument("--results", type=path, metavar="DIR", help="folder of artrec replay, to see where it failed")
    p.add_argument("--frames", type=_count, default=200, metavar="N", help="of a bag or video N frames at most (200)")
    p.add_argument("--keep", type=_count, default=60, metavar="N", help="of a live topic the last N images (60)")
    add_source_options(p)
    p.add_argument("--host", default="127.0.0.1", help="address to listen at (default: 127.0.0.1: this machine alone)")
    p.add_argument("--port", type=_port, default=8080, metavar="N", help="port to listen at (default: 8080)")
    p.add_argument("--no-open", action="store_true", help="do not open the browser")
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Serves the page until Ctrl-C."""
    from .studio_pages.page import Opened, serve  # without NiceGUI, the reason and the way out
    from .studio_state.examples import Examples
    from .studio_state.ros import Ros
    from .studio_state.session import Session, load_setup

    if args.source is None and args.topic is None:
        raise ConfigError("SOURCE is missing: name a folder, bag or video, or with --topic a live one")
    _check_what_is_named(args)
    given = tuple(args.params_file)
    setup = load_setup(given, args.output)
    make_folder(args.output)
    _tell_what_is_there(args)
    with held(args.output), contextlib.closing(Ros()) as ros:
        session = Session(_stills(args, setup, ros), args.output, given, setup)
        for line in session.stills.problems:
            say(line)
        examples = Examples(session, args.annotations)
        for line in examples.misfits:
            say(f"warning: {line}")
        opened = Opened(session, examples, ros, args.results)
        with contextlib.closing(opened), contextlib.suppress(KeyboardInterrupt):
            serve(opened, args.host, args.port, not args.no_open, lambda: _tell(args))
    say(f"ended; all that was made is in {args.output}")
    return 0


def _stills(args: argparse.Namespace, setup: Setup, ros: Ros) -> Stills:
    """Of the source, or of the live topic."""
    from .studio_state.stills import FRAMES, live_stills, open_stills

    options, folder = source_options(args, setup), args.output / FRAMES
    if args.source is not None:
        return open_stills(args.source, options, args.frames, folder, say)
    live = ros.listen(args.topic, args.camera_info_topic, setup.image.rectified, args.keep)
    return live_stills(live, options, folder, say)


def _check_what_is_named(args: argparse.Namespace) -> None:
    """Before anything is written. A source whose frames an earlier sitting took may be gone."""
    from .studio_state.stills import FRAMES

    taken = any((args.output / FRAMES).glob("*.png"))
    for named in (None if taken else args.source, args.results):
        if named is not None and not named.exists():
            raise ConfigError(f"{named}: no such file or folder{like_it(named)}")


def _tell_what_is_there(args: argparse.Namespace) -> None:
    """Files of an earlier sitting go before what was named."""
    from .studio_state.examples import ANNOTATIONS_FILE
    from .studio_state.session import PARAMETERS_FILE
    from .studio_state.stills import FRAMES, is_folder_of_images

    if (args.output / PARAMETERS_FILE).is_file():
        say(f"going on with {args.output / PARAMETERS_FILE}, not with {', '.join(map(str, args.params_file))}")
    if args.annotations and (args.output / ANNOTATIONS_FILE).is_file():
        say(f"going on with {args.output / ANNOTATIONS_FILE}, not with {', '.join(map(str, args.annotations))}")
    frames = len([*(args.output / FRAMES).glob("*.png")])
    if frames and args.source is None:
        say(f"going on with what is in {args.output / FRAMES} ({frames})")
    elif frames and not is_folder_of_images(args.source):
        say(f"going on with what is in {args.output / FRAMES} ({frames}), not with {args.source}")


def _tell(args: argparse.Namespace) -> None:
    print(f"http://{args.host}:{args.port}  (Ctrl-C ends it; what is made goes to {args.output})", flush=True)
    if args.host in ("127.0.0.1", "localhost"):
        name = f"{getpass.getuser()}@{socket.gethostname()}"
        print(
            f"from another machine: ssh -L {args.port}:127.0.0.1:{args.port} {name}, then the same address there",
            flush=True,
        )
    else:
        say(f"warning: whoever reaches {args.host}:{args.port} may use this page: it asks for no password")


def _number(high: int, what: str) -> Callable[[str], int]:
    def read(text: str) -> int:
        if not text.isdecimal() or not 1 <= int(text) <= high:
            raise argparse.ArgumentTypeError(f"'{text}' is no {what} of 1 to {high}")
        return int(text)

    return read


_port, _count = _number(65535, "port"), _number(100_000, "number of frames")
