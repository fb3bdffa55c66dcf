"""`artrec tune`: searches parameters on frames with truth, and judges what it finds on frames that it never used."""

from __future__ import annotations

import argparse
from collections.abc import Callable
from contextlib import ExitStack
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core.base.errors import ArtrecError, ConfigError, SourceError
from ..io.base.bars import bar, say
from ..io.base.whole_files import held, make_folder
from ..io.parameters.parameter_file import Setup, load_parameters
from ..io.parameters.unread import unread
from ..io.sources.frames import once
from ..io.sources.opening import open_sources
from ..io.truth.reading import read_truth
from .evaluation.scoring import Options
from .getting_ready import get_setup_ready
from .interrupting import interruptible
from .main import DONE, INTERRUPTED
from .options.outputs import check_not_read
from .options.paths import path
from .options.seed import seed
from .options.work_options import (
    add_source_options,
    add_sources,
    add_worker_options,
    engine_of,
    number,
    order_of,
    seconds,
    source_options,
)
from .replaying.plan import check_plan, digest, plan_of, write_plan
from .tuning.goal import FIGURES, Goal, goal_of, limit, measures
from .tuning.space import Dimension, changed, load_space

if TYPE_CHECKING:  # both need Optuna, an extra
    from .tuning.search import Search, Tried
    from .tuning.session import Session

_EPILOG = """\
The search space is a file with `format: artrec_search/1` and `parameters:`, under which each parameter has limits
(low, high, and log: true or a step) or choices; recognizer.NAME, image.NAME, and elements of lists such as
image.red.saturation[0]. Figures are those of artrec evaluate.

Written to DIR: parameters.yaml, which the node loads, report.json, and study.db, where the search is kept. The same
command again goes on with a search that was interrupted; with more --trials, with one that was finished. Latencies are
those of a machine with nothing else to do: leave --jobs at 1 where they matter.
"""
PLAN_FILE = "search.json"
_KEPT_OPTIONS = ("topic", "camera_info_topic", "camera_info", "start_offset", "playback_duration", "storage", "rate",
                 "max_gap", "held_out", "block", "seed", "objective")  # fmt: skip


def add_parser(subparsers: Any) -> None:
    p = subparsers.add_parser(
        "tune", help="search parameters on frames with truth", description=__doc__, epilog=_EPILOG
    )
    add_sources(p)
    p.add_argument(
        "--params-file", required=True, type=path, action="append",
        help="where to begin: the node's ROS parameter file; may be given again: later ones go before",
    )  # fmt: skip
    p.add_argument(
        "--search", required=True, type=path, metavar="SPACE.yaml", help="what may change, within which limits"
    )
    p.add_argument(
        "--truth", required=True, type=path, metavar="PATH", action="append",
        help="truth.jsonl, a bag, or a COCO file: one for all sources, or one for each, in their order",
    )  # fmt: skip
    p.add_argument("-o", "--output", required=True, type=path, metavar="DIR", help="where the results go")
    p.add_argument("--overwrite", action="store_true", help="begin anew, whatever search DIR holds")
    p.add_argument("--objective", choices=FIGURES, default="f1", metavar="FIGURE",
                   help=f"what to improve (f1): {', '.join(FIGURES)}")  # fmt: skip
    p.add_argument("--limit", type=limit, action="append", default=[], metavar="FIGURE<=N",
                   help="what must hold besides, as 'latency_ms_p95<=30' or 'f1>=0.9'; may be given again")  # fmt: skip
    p.add_argument("--trials", type=_count, default=100, metavar="N", help="how many sets of values are tried (100)")
    p.add_argument(
        "--held-out", type=_share, default=0.3, metavar="SHARE", help="of the frames: they judge alone (0.3)"
    )
    p.add_argument("--block", type=_count, default=1, metavar="N",
                   help="frames in a row that stay together, where neighbours are alike (1)")  # fmt: skip
    p.add_argument("--seed", type=seed, default=0, help="the same seed gives the same search (0)")
    p.add_argument("--max-gap", type=seconds, default=0.0, metavar="S", help="how far stamps may differ (0 s)")
    add_source_options(p)
    add_worker_options(p)
    p.set_defaults(run=run)


def run(args: argparse.Namespace) -> int:
    """Exit code 0: done; 130: interrupted."""
    for name in _written():
        check_not_read(args.output / name, [*args.params_file, args.search, *args.truth, *args.sources])
    setup = load_parameters(*args.params_file)
    space = load_space(args.search, setup)
    goal = goal_of(args.objective, args.limit)
    if len(args.truth) not in (1, len(args.sources)):
        raise ConfigError(f"--truth: {len(args.truth)} given for {len(args.sources)} sources; one for all, or one each")
    from .tuning.session import Session

    options = source_options(args, setup)
    with open_sources(args.sources, options, say) as sources, ExitStack() as stack:
        calibrated = sources.calibrated
        for line in unread(setup, calibrated, {dimension.spec.name for dimension in space}):
            say(f"warning: {line}")
        _begin_folder(args, setup, stack)
        get_setup_ready(setup, calibrated)
        engine = stack.enter_context(engine_of(args))
        named = list(zip(map(str, args.sources), sources.parts, strict=True))
        session = Session(args.output, engine, order_of(setup, args.sources, sources, options), named, once(say))
        for line in sources.problems:  # all of them was read for their parts
            say(line)
        try:
            with interruptible(session.stop):
                scoring = Options(max_gap_ns=round(args.max_gap * 1e9), camera=options.camera)
                done = _tune(args, session, space, goal, scoring)
        except OSError as error:
            raise _unwritable(args.output, error) from error
    if not done:
        print(f"interrupted; the same command goes on; what was tried so far is in {args.output}")
    return DONE if done else INTERRUPTED


def _tune(
    args: argparse.Namespace, session: Session, space: tuple[Dimension, ...], goal: Goal, scoring: Options
) -> bool:
    """Whether it came to an end."""
    from .tuning.outcome import Outcome
    from .tuning.search import Search
    from .tuning.session import HoldOut

    truths = [read_truth(path) for path in args.truth]
    search = Search(args.output, space, goal, args.seed)
    say("recognising all frames with the given parameters")
    if not session.begin(truths, scoring, HoldOut(args.held_out, args.block, args.seed)):
        return False
    if not search.begin(session.setup.resolved, measures(session.before(session.split.tuned_on))):
        say(f"the given parameters lie outside {args.search}: they are no trial")
    with bar(total=args.trials, initial=len(search.tried), unit="trial") as shown:
        if not session.search(search, space, args.trials, _progress(shown, goal)):
            return False
    best = _best(search)
    found = changed(session.setup, space, best.values)
    after = session.after(found, session.split.held_out)
    if after is None:
        return False
    before = session.before(session.split.held_out)
    outcome = Outcome(goal, session.split, search.tried, best, search.importance(), session.setup, found, before, after)
    written = outcome.write(args.output, args.params_file)
    for line in outcome.lines():
        print(line)
    print(f"written: {', '.join(map(str, written))}")
    return True


def _best(search: Search) -> Tried:
    best = search.best
    if best is None:
        raise ArtrecError(f"no trial could be used; the last one: {search.tried[-1].problem}")
    return best


def _progress(bar: Any, goal: Goal) -> Callable[[Tried | None], None]:
    def tell(best: Tried | None) -> None:
        bar.update()
        if best is not None:
            bar.set_postfix({goal.figure: best.measured[goal.figure]})

    return tell


def _begin_folder(args: argparse.Namespace, setup: Setup, stack: ExitStack) -> None:
    """New, or of the same search; held by one process at a time."""
    folder: Path = args.output
    plan = plan_of(setup, args.sources, _plan_options(args))
    try:
        make_folder(folder)
        stack.enter_context(held(folder))
        if args.overwrite:
            for name in _written():
                (folder / name).unlink(missing_ok=True)
        if any((folder / name).exists() for name in _written()):
            check_plan(folder / PLAN_FILE, plan)
        else:
            write_plan(folder / PLAN_FILE, plan)
    except OSError as error:
        raise _unwritable(folder, error) from error


def _written() -> tuple[str, ...]:
    """Names of the files in DIR."""
    from .tuning.outcome import PARAMETERS_FILE, REPORT_FILE
    from .tuning.search import STUDY_FILE
    from .tuning.session import BEFORE_FILE

    return BEFORE_FILE, STUDY_FILE, PARAMETERS_FILE, REPORT_FILE, PLAN_FILE


def _plan_options(args: argparse.Namespace) -> dict[str, Any]:
    """What the search depends on besides sources and parameters; not how many trials are wanted."""
    options = {key: value for key in _KEPT_OPTIONS if (value := getattr(args, key)) is not None}
    plain = {key: str(value.resolve()) if isinstance(value, Path) else value for key, value in options.items()}
    search = args.search.read_text(encoding="utf-8")
    truths = [digest(p.read_bytes()) if p.is_file() else str(p.resolve()) for p in args.truth]
    return {**plain, "limits": [str(x) for x in args.limit], "search": search, "truth": truths}


def _unwritable(folder: Path, error: OSError) -> SourceError:
    return SourceError(
        f"{folder}: cannot be written: {error.strerror or error}; what was tried is whole: make room, and the same "
        "command goes on"
    )


def _share(text: str) -> float:
    return number(text, lambda v: 0 < v < 1, "share between 0 and 1")


def _count(text: str) -> int:
    return int(number(text, lambda v: v >= 1 and v == int(v), "whole number from 1 on"))
