"""`artrec play`: publishes a bag with its stamps and /clock, in its own time or as fast as a node answers."""

from __future__ import annotations

import argparse
import itertools
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ..core.base.errors import ArtrecError, SourceError
from ..io.bags.reader import STORAGES, Bag, RawMessage, Topic
from ..io.bags.topics import INFO_TYPE
from ..io.base.bars import bar, say
from ..io.sources.frames import once
from ..io.sources.look_ahead import AHEAD_NS, own_first
from .main import MISSING

if TYPE_CHECKING:
    from .player import Player


def add_parser(subparsers: Any) -> None:
    p = subparsers.add_parser(
        "play",
        help="publish a bag with its stamps and /clock",
        description=__doc__,
        epilog="With --wait-for nothing is dropped, whatever the node's speed: results are those of `artrec replay`.",
    )
    p.add_argument("bag", metavar="BAG", type=Path, help="rosbag2 folder or file (mcap, sqlite3)")
    p.add_argument("--topics", nargs="+", metavar="TOPIC", help="publish only these (default: all)")
    p.add_argument(
        "-m", "--remap", nargs="+", default=[], metavar="OLD:=NEW", help="publish a topic under another name"
    )
    p.add_argument("-r", "--rate", type=_positive, default=1.0, help="times as fast as recorded (default: 1)")
    p.add_argument("-l", "--loop", action="store_true", help="begin again at the end")
    p.add_argument("--start-offset", type=_seconds, default=0.0, metavar="S", help="skip S seconds")
    p.add_argument("--playback-duration", type=_seconds, metavar="S", help="publish S seconds of it")
    p.add_argument("-s", "--storage", choices=sorted(STORAGES), help="read only bag files of this kind")
    p.add_argument(
        "--wait-for",
        metavar="TOPIC",
        help="send each image that is listened to when the one before was answered on TOPIC",
    )
    p.add_argument("--timeout", type=_positive, default=60.0, metavar="S", help="of --wait-for (default: 60)")


def run(args: argparse.Namespace) -> int:
    """Exit code 0: played to its end; 1: images were not answered on the topic of --wait-for."""
    try:
        import rclpy
        from rclpy.signals import SignalHandlerOptions

        from .graph import check_topic
        from .log_folder import check_log_folder
    except ImportError as error:
        raise ArtrecError(MISSING.format(error)) from error
    with Bag(args.bag, args.storage) as bag:
        topics = _chosen(bag, args.topics)
        names = dict(_renaming(rule, topics) for rule in args.remap)
        for name in names.values():
            check_topic(name, "--remap")
        if args.wait_for:
            check_topic(args.wait_for, "--wait-for")
        check_log_folder()
        rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
        try:
            player = _played(bag, topics, names, args)
        finally:
            rclpy.try_shutdown()
    for name, count in sorted(player.sent.items()):
        print(f"{name}: {count} messages sent")
    if player.unanswered:
        print(
            f"{len(player.unanswered)} images were not answered, the first of {player.unanswered[0]} ns",
            file=sys.stderr,
        )
    return int(bool(player.unanswered))


def _played(bag: Bag, topics: list[Topic], names: dict[str, str], args: argparse.Namespace) -> Player:
    """Plays to the end, and tells what of the bag is lost: what is known before, then what turned up."""
    from rclpy import create_node

    from .player import Player

    tell = once(say)
    for line in bag.problems:
        tell(line)
    node = create_node("artrec_play")
    player = Player(node, topics, names=names, wait_for=args.wait_for, timeout_s=args.timeout, say=say)
    for name, kind in player.skipped.items():
        print(f"{name}: {kind} is not installed here; skipped")
    player.begin()
    whole = not args.start_offset and args.playback_duration is None
    total = sum(t.count for t in topics) if whole else None
    while True:
        player.play(bar(_messages(bag, topics, args), unit="message", total=total), args.rate)
        for line in bag.problems:
            tell(line)
        if not player.sent:
            raise SourceError(f"{args.bag}: nothing to send: {_why_nothing(bag, topics, args)}")
        if not args.loop:
            return player


def _messages(bag: Bag, topics: list[Topic], args: argparse.Namespace) -> Iterator[RawMessage]:
    """What is to be sent, in the order of recording; where images are answered one by one, each behind its own
    calibration, which is no longer waited for then."""
    names = {t.name for t in topics}
    start_ns = bag.start_ns + round(args.start_offset * 1e9)
    stop_ns = None if args.playback_duration is None else start_ns + round(args.playback_duration * 1e9)
    # without bounds, where all is sent: so all is counted
    messages = bag.messages(names, start_ns if args.start_offset else None, stop_ns)
    if not args.wait_for:
        yield from messages
        return
    calibrations = [t.name for t in topics if t.msgtype == INFO_TYPE]
    for topic in calibrations:  # images may come before the first one, which holds for them just as well
        yield from (m._replace(log_ns=start_ns) for m in itertools.islice(bag.messages([topic]), 1))
    stop_ns = None if stop_ns is None else stop_ns + AHEAD_NS
    yield from own_first(messages, bag.messages(calibrations, max(0, start_ns - AHEAD_NS), stop_ns))


def _why_nothing(bag: Bag, topics: list[Topic], args: argparse.Namespace) -> str:
    lasts_s = (bag.end_ns - bag.start_ns) * 1e-9
    if args.start_offset > lasts_s:
        return f"it lasts {lasts_s:.2f} s, --start-offset is {args.start_offset:g}"
    return f"no message on {', '.join(t.name for t in topics) or 'any topic'} in that time, of a type that is installed"


def _chosen(bag: Bag, wanted: list[str] | None) -> list[Topic]:
    if bag.ros1:
        raise SourceError(f"{bag.path}: a ROS 1 bag; convert it first: rosbags-convert --src {bag.path} --dst NEW")
    missing = [name for name in wanted or [] if name not in bag.topics]
    if missing:
        raise SourceError(f"{bag.path}: no topic '{missing[0]}'; there are {', '.join(sorted(bag.topics))}")
    return [t for t in bag.topics.values() if wanted is None or t.name in wanted]


def _renaming(rule: str, topics: list[Topic]) -> tuple[str, str]:
    old, arrow, new = rule.partition(":=")
    if not (arrow and new) or old not in [t.name for t in topics]:
        known = ", ".join(t.name for t in topics)
        raise SourceError(f"--remap {rule}: OLD:=NEW is expected, where OLD is one of {known}")
    return old, new


def _number(text: str, least: float, what: str) -> float:
    try:
        value = float(text)
    except ValueError:
        value = float("nan")
    if not least <= value < float("inf"):
        raise argparse.ArgumentTypeError(f"'{text}' is no {what}")
    return value


def _seconds(text: str) -> float:
    return _number(text, 0.0, "number of seconds")


def _positive(text: str) -> float:
    return _number(text, 1e-6, "positive number")
