"""Bags: rosbag2 (sqlite3, mcap; split, compressed) and ROS 1, read without ROS. rosbags is imported here and,
for writing, in writer.py alone.

Only standard messages are read (Image, CompressedImage, CameraInfo), and their layouts never changed: so their
definitions come from the library, and a bag's own definitions, missing or odd, are of no concern.
"""

from __future__ import annotations

import shutil
import sys
from collections.abc import Callable, Collection, Iterator
from contextlib import ExitStack
from dataclasses import dataclass, replace
from functools import cache
from itertools import chain, pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from rosbags.interfaces import QosDurability
from rosbags.rosbag1 import Reader as Ros1Reader
from rosbags.rosbag1 import ReaderError as Ros1ReaderError
from rosbags.rosbag2 import Reader as Ros2Reader
from rosbags.rosbag2 import ReaderError as Ros2ReaderError
from rosbags.typesys import Stores, get_typestore

from ...core.base.errors import ImageError, SourceError, UnreadableError
from ..base.yaml_files import like_it, size_of_file
from .heads import Head, head_of
from .index import index_problem
from .metadata import BAG_SUFFIXES, STORAGES, Metadata, is_storage, storage_suffix
from .recovery import RawMessage, full_type, scan
from .tally import Tally

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

_NO_INDEX = "it has no index, which its recorder writes last; read front to back (rosbag reindex gives it one)"
_NAMED = 3  # bags that a message names
_ZSTD_MAGIC = b"\x28\xb5\x2f\xfd"


@dataclass(frozen=True, order=True)
class Topic:
    """A topic of a bag and how many messages it holds.

    :param latched: who subscribed late was sent what had been published before (durability transient local).
    """

    name: str
    msgtype: str
    count: int
    latched: bool = False


@cache
def _typestore(ros1: bool) -> Any:
    return get_typestore(Stores.ROS1_NOETIC if ros1 else Stores.ROS2_JAZZY)


def _one_line(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__


def _why(error: BaseException) -> str:
    """Why a file cannot be read: what rosbags found, or stumbled over."""
    found = isinstance(error, (Ros1ReaderError, Ros2ReaderError))
    return _one_line(error).rstrip(".") if found else f"damaged: {_one_line(error)}"


class _StorageFile:
    """One file of a bag: read through its index, or front to back where the index is missing or damaged.

    `problem` says what is wrong with the file, as far as it has been read.
    """

    def __init__(self, path: Path, shown: Path) -> None:
        """:param path: the file itself. :param shown: its name for users (of the file it was unpacked from)."""
        self.path, self.shown = path, shown
        self.ros1 = storage_suffix(path) == ".bag"
        self.problem: str | None = None
        try:
            with self._reader() as reader:
                self.topics = [
                    Topic(c.topic, full_type(c.msgtype), c.msgcount, self._was_latched(c.ext))
                    for c in reader.connections
                ]
                self.start_ns, self.end_ns = reader.start_time, reader.end_time
                self.problem = index_problem(path, reader)
        except Exception as error:  # rosbags raises whatever damaged bytes lead to: assertions, struct and type errors
            text = _why(error)
            self.problem = _NO_INDEX if "not indexed" in text else text
        self.indexed = self.problem is None
        if not self.indexed:
            self._survey()

    def _reader(self) -> Any:
        return Ros1Reader(self.path) if self.ros1 else Ros2Reader(self.path)

    def _was_latched(self, recorded: Any) -> bool:
        """:param recorded: what rosbags says of a connection beyond its topic and type."""
        if self.ros1:
            return bool(recorded.latching)
        return any(qos.durability == QosDurability.TRANSIENT_LOCAL for qos in recorded.offered_qos_profiles)

    def _survey(self) -> None:
        """Topics and start of a file without index."""
        counts: dict[tuple[str, str], int] = {}
        self.start_ns, self.end_ns = sys.maxsize, 0
        for message in self._scan():
            key = (message.topic, message.msgtype)
            counts[key] = counts.get(key, 0) + 1
            self.start_ns = min(self.start_ns, message.log_ns)
            self.end_ns = max(self.end_ns, message.log_ns)
        self.topics = [Topic(*key, count) for key, count in counts.items()]

    def _scan(self) -> Iterator[RawMessage]:
        try:
            yield from scan(self.path)
        except SourceError as error:
            self.problem = str(error)

    def messages(self, names: Collection[str], start_ns: int | None, stop_ns: int | None) -> Iterator[RawMessage]:
        if self.indexed:
            yield from self._read_indexed(names, start_ns, stop_ns)
            return
        start, stop = start_ns or 0, sys.maxsize if stop_ns is None else stop_ns
        for message in self._scan():
            if message.topic in names and start <= message.log_ns < stop:
                yield message

    def _read_indexed(self, names: Collection[str], start_ns: int | None, stop_ns: int | None) -> Iterator[RawMessage]:
        try:
            with self._reader() as reader:
                wanted = [c for c in reader.connections if c.topic in names]
                if not wanted:
                    return
                for connection, log_ns, data in reader.messages(wanted, start_ns, stop_ns):
                    yield RawMessage(connection.topic, full_type(connection.msgtype), log_ns, bytes(data))
        except Exception as error:  # as in __init__
            self.problem = _why(error)


class Bag:
    """A bag: one file, or a folder of rosbag2 files. Use it as a context manager.

    :ivar topics: by name. :ivar start_ns, end_ns: when its first and its last message were recorded.

    Whenever all messages of a topic were read, they are held against what the bag says of itself; `problems` tells.
    """

    def __init__(self, path: Path, storage: str | None = None) -> None:
        """:raises SourceError: if `path` is no bag, or nothing in it can be read."""
        self.path = path
        self._metadata = Metadata.of(path)
        self._tally = Tally()
        self._stack = ExitStack()
        try:
            # a split bag's files follow each other in time, whatever their names and whether metadata.yaml lists them
            self._files = sorted((self._open(file) for file in bag_files(path, storage)), key=lambda f: f.start_ns)
        except BaseException:
            self._stack.close()
            raise
        self.topics: dict[str, Topic] = {}
        for topic in (topic for file in self._files for topic in file.topics):
            if known := self.topics.get(topic.name):
                topic = replace(topic, count=topic.count + known.count, latched=topic.latched or known.latched)
            self.topics[topic.name] = topic
        self.start_ns = min((file.start_ns for file in self._files), default=0)
        self.end_ns = max((file.end_ns for file in self._files), default=0)
        self.ros1 = any(file.ros1 for file in self._files)
        if not self.topics and self.problems:
            self._stack.close()
            raise UnreadableError(f"{self.problems[0]}; nothing could be read")

    def __enter__(self) -> Bag:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    @property
    def lost(self) -> list[Topic]:
        """Topics of which no message can be read, though the bag tells of some; as far as it has been read."""
        told = self._metadata
        return [Topic(n, told.types[n], c) for n, c in told.counts.items() if c > 0 and n not in self.topics]

    @property
    def in_order(self) -> bool:
        """Whether messages come in the order of their times, so that those from a time on are the rest of all."""
        indexed = all(file.indexed for file in self._files)
        return indexed and all(a.end_ns <= b.start_ns for a, b in pairwise(self._files))

    @property
    def problems(self) -> list[str]:
        """One line for every file that is damaged, and for what does not add up, as far as it has been read."""
        damaged = [f"{file.shown}: {file.problem}" for file in self._files if file.problem]
        copies = [
            f"{b.shown}: holds the same messages as {a.shown.name}: one was written over, or is a copy"
            for a, b in pairwise(self._files)
            if (a.start_ns, a.end_ns, a.topics) == (b.start_ns, b.end_ns, b.topics) and a.topics
        ]
        indexed = {} if damaged else {name: topic.count for name, topic in self.topics.items()}
        about = [self._metadata.problem] if self._metadata.problem else []
        gaps = self._metadata.gaps(self.path, self.topics)
        miscounts = self._tally.problems(self._metadata.counts, indexed)
        return [*damaged, *copies, *(f"{self.path}: {line}" for line in chain(about, gaps, miscounts))]

    def messages(
        self, names: Collection[str], start_ns: int | None = None, stop_ns: int | None = None
    ) -> Iterator[RawMessage]:
        """Messages of these topics, recorded in [start_ns, stop_ns), in the order of recording.

        A damaged file gives what can be read; `problems` then says so.
        """
        raw = chain.from_iterable(file.messages(names, start_ns, stop_ns) for file in self._files)
        for message in raw if (start_ns, stop_ns) != (None, None) else self._tally.over(raw, names):
            if not self.ros1 and message.data.startswith(_ZSTD_MAGIC):  # plain CDR starts with 00
                message = message._replace(data=_unpacked_message(message))
            yield message

    def head(self, message: RawMessage) -> Head:
        """Stamp and frame of a message that begins with a header."""
        return head_of(message.data, message.log_ns, self.ros1)

    def parse(self, message: RawMessage) -> Any:
        """The message as an object with the fields of its type.

        :raises ImageError: if its bytes do not fit its type.
        """
        store = _typestore(self.ros1)
        parse: Callable[[bytes, str], Any] = store.deserialize_ros1 if self.ros1 else store.deserialize_cdr
        try:
            return parse(message.data, message.msgtype)
        except Exception as error:  # rosbags raises whatever damaged bytes lead to
            what = f"damaged {message.msgtype} message of {len(message.data)} bytes"
            raise ImageError(f"{what}: {_one_line(error)}") from error

    def cdr(self, message: RawMessage) -> bytes:
        """The message's bytes as ROS 2 serialises it. :raises ImageError: they do not fit its type."""
        try:
            return bytes(_typestore(False).ros1_to_cdr(message.data, message.msgtype)) if self.ros1 else message.data
        except Exception as error:  # as in `parse`
            raise ImageError(f"damaged {message.msgtype} message: {_one_line(error)}") from error

    def _open(self, path: Path) -> _StorageFile:
        if path.suffix != ".zstd":
            return _StorageFile(path, path)
        folder = Path(self._stack.enter_context(TemporaryDirectory()))
        unpacked = folder / path.stem
        problem = None
        with path.open("rb") as packed, unpacked.open("wb") as plain:
            try:
                shutil.copyfileobj(zstd.open(packed, "rb"), plain, 2**16)
            except (zstd.ZstdError, EOFError) as error:
                problem = f"its compression is damaged or cut off: {_one_line(error)}"
        file = _StorageFile(unpacked, path)
        file.problem = problem or file.problem
        return file


def _unpacked_message(message: RawMessage) -> bytes:
    try:
        return bytes(zstd.decompress(message.data))
    except zstd.ZstdError:
        return b""  # `parse` reports a message without bytes


def bag_files(path: Path, storage: str | None) -> list[Path]:
    """The storage files of a bag: of a folder, those that metadata.yaml lists, else all.

    :param storage: 'mcap' or 'sqlite3': only files of that kind.
    :raises SourceError: no such path, no bag in it, or a file that metadata.yaml lists is missing.
    """
    if not path.exists():
        raise SourceError(f"{path}: no such file or folder{like_it(path)}")
    if path.is_dir():
        listed = [path / name for name in Metadata.of(path).files]
        if missing := [f for f in listed if not f.exists()]:
            raise UnreadableError(f"{missing[0]}: metadata.yaml lists it, but it does not exist")
        files = listed or [p for p in path.iterdir() if is_storage(p) and storage_suffix(p) != ".bag"]
    else:
        files = [path]
    wanted = (STORAGES[storage],) if storage else BAG_SUFFIXES
    found = [f for f in files if storage_suffix(f) in wanted]
    if not found and path.is_dir() and (inside := _bags_in(path)):
        several = f"several bags ({len(inside)})" if len(inside) > 1 else "a bag"
        raise SourceError(f"{path}: is no bag but holds {several}; name {' or '.join(map(str, inside[:_NAMED]))}")
    if not found:
        raise SourceError(f"{path}: no bag ({', '.join(wanted)}; or those with .zstd) there")
    for file in found:
        size_of_file(file, SourceError)
    return found


def _bags_in(folder: Path) -> list[Path]:
    """Files of ROS 1, each of which is a bag, and folders of rosbag2."""
    return sorted(
        p
        for p in folder.iterdir()
        if (p.is_file() and storage_suffix(p) == ".bag")
        or (p.is_dir() and any(f.name == "metadata.yaml" or is_storage(f) for f in p.iterdir()))
    )
