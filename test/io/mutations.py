"""Damages bags of ten formats at random and replays what is left: every frame comes back, or its loss is told.

    python test/io/mutations.py --count 1000 --seed 1

prints, for each format, how often all frames were read, a loss was told, and lost frames were not told (which must
never be), and exits with 1 if one was. `test_mutations.py` runs a few of them.
"""

from __future__ import annotations

import argparse
import hashlib
import shutil
import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import lz4.frame
import numpy as np
import yaml
from bag_messages import Messages, Script
from rosbags import rosbag1, rosbag2

from artrec_ros.core.base.errors import ArtrecError
from artrec_ros.io.sources.opening import open_sources

if sys.version_info >= (3, 14):
    from compression import zstd
else:
    from backports import zstd

FRAMES, SIZE, CHUNK_BYTES, STEP_NS = 40, (12, 16), 1500, 10**8
START_NS = 1_700_000_000 * 10**9


@dataclass(frozen=True)
class Content:
    """What a replay reads of a bag: for each frame, its stamp and a digest of its pixels."""

    frames: tuple[tuple[int, str], ...]
    told: tuple[str, ...] = ()
    crash: str = ""

    def lost_from(self, whole: Content) -> int:
        """Frames of the whole bag of which neither the stamp nor the pixels came back, or that are fewer."""
        stamps, pixels = ({frame[i] for frame in self.frames} for i in (0, 1))
        gone = sum(stamp not in stamps and digest not in pixels for stamp, digest in whole.frames)
        return max(gone, len(whole.frames) - len(self.frames))


def replayed(path: Path) -> Content:
    """As `artrec replay` reads it: in parts, each opened anew."""
    told: list[str] = []
    frames: list[tuple[int, str]] = []
    try:
        with open_sources([path], report=told.append) as sources:
            for part in sources.parts[0].parts(16):
                with open_sources([path]) as again:
                    read = list(again.parts[0].read(part))
                if len(read) != part.count:
                    told.append("it changed while it was read")  # what a worker says
                for frame in read:
                    if frame.image is None:
                        told.append(frame.error or "")
                    else:
                        frames.append((frame.stamp_ns, hashlib.sha1(frame.image.tobytes()).hexdigest()))
            told += sources.problems
    except ArtrecError as error:
        told.append(str(error))
    except Exception as error:  # no bag whatever may bring the reader down
        return Content((), (), f"{type(error).__name__}: {error}")
    return Content(tuple(frames), tuple(told))


# ---------------------------------------------------------------------------------------------------------- formats


def script(messages: Messages, first: int = 0, count: int = FRAMES) -> Script:
    rng = np.random.default_rng(7)
    images = [rng.integers(0, 8, SIZE, np.uint8) for _ in range(FRAMES)]
    lines: Script = []
    for i in range(first, first + count):
        stamp = START_NS + i * STEP_NS
        lines.append(("/camera_info", stamp, messages.info(stamp, 100.0, SIZE[::-1])))
        lines.append(("/image", stamp + 1000, messages.image(stamp, images[i])))
    return lines


def write_mcap(path: Path, lines: Script, compression: str = "") -> None:
    """Small chunks, compressed as is wanted; rosbags' writer knows neither."""
    store = Messages().store
    with rosbag2.Writer(path, version=9, storage_plugin=rosbag2.StoragePlugin.MCAP) as writer:
        storage: Any = writer.storage
        compressors = {"": bytes, "zstd": zstd.compress, "lz4": lz4.frame.compress}
        storage.compression, storage.compressor = compression, compressors[compression]
        connections: dict[str, Any] = {}
        for topic, log_ns, (msgtype, message) in lines:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, msgtype, typestore=store)
            writer.write(connections[topic], log_ns, store.serialize_cdr(message, msgtype))
            if storage.chunk.bio.tell() > CHUNK_BYTES:
                storage.close_chunk()


def write_split(path: Path) -> None:
    path.mkdir()
    parts = []
    for part in range(4):
        one = path.parent / f"{path.name}_{part}"
        write_mcap(one, script(Messages(), part * FRAMES // 4, FRAMES // 4))
        parts.append(yaml.safe_load((one / "metadata.yaml").read_text())["rosbag2_bagfile_information"])
        shutil.move(one / f"{one.name}.mcap", path)
        shutil.rmtree(one)
    whole = parts[0]
    whole["relative_file_paths"] = [name for part in parts for name in part["relative_file_paths"]]
    whole["files"] = [file for part in parts for file in part["files"]]
    for topic in whole["topics_with_message_count"]:
        topic["message_count"] *= 4
    whole["message_count"] *= 4
    (path / "metadata.yaml").write_text(yaml.safe_dump({"rosbag2_bagfile_information": whole}))


def write_sqlite3(path: Path, mode: rosbag2.CompressionMode | None = None) -> None:
    writer = rosbag2.Writer(path, version=9, storage_plugin=rosbag2.StoragePlugin.SQLITE3)
    if mode is not None:
        writer.set_compression(mode, rosbag2.CompressionFormat.ZSTD)
    write_all(writer, Messages(), Messages().store.serialize_cdr)


def write_ros1(path: Path, compression: str | None = None) -> None:
    writer = rosbag1.Writer(path)
    writer.chunk_threshold = CHUNK_BYTES
    if compression:
        writer.set_compression(rosbag1.Writer.CompressionFormat[compression])
    write_all(writer, Messages(ros1=True), Messages(ros1=True).store.serialize_ros1)


def write_all(writer: Any, messages: Messages, serialize: Callable[..., Any]) -> None:
    connections: dict[str, Any] = {}
    with writer:
        for topic, log_ns, (msgtype, message) in script(messages):
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, msgtype, typestore=messages.store)
            writer.write(connections[topic], log_ns, serialize(message, msgtype))


def write_packed(path: Path) -> None:
    """A file that is compressed as a whole, without metadata."""
    write_mcap(path.parent / "inner", script(Messages()))
    path.write_bytes(zstd.compress((path.parent / "inner" / "inner.mcap").read_bytes()))


MESSAGE, FILE = rosbag2.CompressionMode.MESSAGE, rosbag2.CompressionMode.FILE
FORMATS: dict[str, tuple[str, Callable[[Path], None]]] = {
    "mcap": ("bag", lambda p: write_mcap(p, script(Messages()))),
    "mcap zstd": ("bag", lambda p: write_mcap(p, script(Messages()), "zstd")),
    "mcap lz4": ("bag", lambda p: write_mcap(p, script(Messages()), "lz4")),
    "mcap split": ("bag", write_split),
    "mcap.zstd file": ("bag.mcap.zstd", write_packed),
    "sqlite3": ("bag", write_sqlite3),
    "sqlite3 messages zstd": ("bag", lambda p: write_sqlite3(p, MESSAGE)),
    "sqlite3 file zstd": ("bag", lambda p: write_sqlite3(p, FILE)),
    "ros1": ("bag.bag", write_ros1),
    "ros1 lz4": ("bag.bag", lambda p: write_ros1(p, "LZ4")),
    "ros1 bz2": ("bag.bag", lambda p: write_ros1(p, "BZ2")),
}


# -------------------------------------------------------------------------------------------------------- mutations

Rng = np.random.Generator
OUTCOMES = ("all", "told", "silent", "crash")


def flipped(data: bytes, rng: Rng) -> bytes:
    changed = bytearray(data)
    for place in rng.integers(0, len(data), rng.integers(1, 4)):
        changed[place] ^= 1 << rng.integers(8)
    return bytes(changed)


def zeroed(data: bytes, rng: Rng) -> bytes:
    begin, end = span(data, rng)
    return data[:begin] + bytes(end - begin) + data[end:]


def cut(data: bytes, rng: Rng) -> bytes:
    return data[: rng.integers(0, len(data))]


def cut_tail(data: bytes, rng: Rng) -> bytes:
    return data[: -rng.integers(1, min(5000, len(data)))]


def cut_out(data: bytes, rng: Rng) -> bytes:
    begin, end = span(data, rng)
    return data[:begin] + data[end:]


def inserted(data: bytes, rng: Rng) -> bytes:
    place = rng.integers(0, len(data))
    return data[:place] + rng.bytes(rng.integers(1, 400)) + data[place:]


def doubled(data: bytes, rng: Rng) -> bytes:
    begin, end = span(data, rng)
    return data[:end] + data[begin:end] + data[end:]


def overwritten(data: bytes, rng: Rng) -> bytes:
    begin, end = span(data, rng)
    place = rng.integers(0, len(data) - (end - begin) + 1)
    return data[:place] + data[begin:end] + data[place + end - begin :]


def swapped(data: bytes, rng: Rng) -> bytes:
    begin, end = span(data, rng, len(data) // 3)
    size = end - begin
    other = rng.integers(0, begin + 1) - size if begin >= size else end + rng.integers(0, len(data) - end - size + 1)
    first, second = sorted((max(0, int(other)), begin))
    if second - first < size:
        return doubled(data, rng)
    middle = data[first + size : second]
    return data[:first] + data[second : second + size] + middle + data[first : first + size] + data[second + size :]


def span(data: bytes, rng: Rng, most: int = 0) -> tuple[int, int]:
    """Places of a few bytes or many."""
    size = min(int(np.exp(rng.uniform(0, np.log(most or len(data))))), len(data) - 1)
    begin = int(rng.integers(0, len(data) - size))
    return begin, begin + max(1, size)


def pieces_moved(data: bytes, rng: Rng) -> bytes:
    """Records, chunks or pages as wholes: one lost, doubled, written over another, or two swapped."""
    pieces = pieces_of(data)
    if len(pieces) < 4:
        return flipped(data, rng)
    a, b = rng.choice(np.arange(1, len(pieces)), 2, replace=False)
    kind = rng.integers(4)
    if kind == 0:
        del pieces[a]
    elif kind == 1:
        pieces.insert(a, pieces[b])
    elif kind == 2:
        pieces[a] = pieces[b]
    else:
        pieces[a], pieces[b] = pieces[b], pieces[a]
    return b"".join(pieces)


def pieces_of(data: bytes) -> list[bytes]:
    """Top-level records of an mcap or ROS 1 bag, pages of a database; empty for what is packed."""
    if data.startswith(b"SQLite format 3\0"):
        size = int.from_bytes(data[16:18], "big")
        return [data[i : i + size] for i in range(0, len(data), size)]
    if data.startswith(b"\x89MCAP0\r\n"):
        head, sized = 8, lambda p: 9 + int.from_bytes(data[p + 1 : p + 9], "little")
    elif data.startswith(b"#ROSBAG"):

        def sized(p: int) -> int:
            header = int.from_bytes(data[p : p + 4], "little")
            return 8 + header + int.from_bytes(data[p + 4 + header : p + 8 + header], "little")

        head = 13
    else:
        return []
    pieces = [data[:head]]
    while head < len(data) - 8:
        size = sized(head)
        pieces.append(data[head : head + size])
        head += size
    return [*pieces, data[head:]]


KINDS = (flipped, zeroed, cut, cut_tail, cut_out, inserted, doubled, overwritten, swapped, pieces_moved, pieces_moved)


def mutate(bag: Path, rng: Rng) -> str:
    """Damages one file of a bag, seldom its metadata.yaml; says how."""
    files = sorted(p for p in bag.iterdir()) if bag.is_dir() else [bag]
    storage = [f for f in files if f.name != "metadata.yaml"]
    file = files[-1] if rng.random() < 0.05 else storage[rng.integers(len(storage))]
    if len(storage) > 1 and rng.random() < 0.1:
        other = storage[rng.integers(len(storage))]
        file.write_bytes(other.read_bytes())
        return f"{file.name} written over by {other.name}"
    if len(storage) > 1 and rng.random() < 0.05:
        file.unlink()
        return f"{file.name} removed"
    kind = KINDS[rng.integers(len(KINDS))]
    data = file.read_bytes()
    file.write_bytes(kind(data, rng))
    return f"{kind.__name__} {file.name}"


def run(count: int, seed: int, folder: Path, say: Callable[[str], None] = print) -> dict[str, Counter[str]]:
    """:return: for each format, how often there was each of OUTCOMES."""
    results: dict[str, Counter[str]] = {}
    wholes: dict[str, Content] = {}
    for name, (file, write) in FORMATS.items():
        (folder / name).mkdir()
        write(folder / name / file)
        wholes[name] = replayed(folder / name / file)
        assert len(wholes[name].frames) == FRAMES and not wholes[name].told, (name, wholes[name].told)
        results[name] = Counter()
    names = list(FORMATS)
    for number in range(count):
        name = names[number % len(names)]
        rng = np.random.default_rng([seed, number])
        damaged = folder / "damaged"
        shutil.copytree(folder / name, damaged)
        how = mutate(damaged / FORMATS[name][0], rng)
        content = replayed(damaged / FORMATS[name][0])
        lost = content.lost_from(wholes[name])
        outcome = "crash" if content.crash else "all" if not lost else "told" if content.told else "silent"
        results[name][outcome] += 1
        if outcome in ("silent", "crash"):
            what = content.crash or f"{lost} of {FRAMES} frames lost"
            say(f"{outcome}: seed {seed}, number {number}, {name}: {how}: {what}")
        shutil.rmtree(damaged)
    return results


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--count", type=int, default=1000)
    parser.add_argument("--seed", type=int, default=1)
    args = parser.parse_args()
    with TemporaryDirectory() as folder:
        results = run(args.count, args.seed, Path(folder))
    results["together"] = sum(results.values(), Counter())
    for name, counts in results.items():
        shown = "  ".join(f"{outcome} {counts[outcome]:4}" for outcome in OUTCOMES)
        print(f"{name:22} {counts.total():5}  {shown}")
    return int(results["together"]["silent"] + results["together"]["crash"] > 0)


if __name__ == "__main__":
    sys.exit(main())
