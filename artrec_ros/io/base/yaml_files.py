"""Strict reading of YAML files: every value knows its place, every error names file, key and what would be valid."""

from __future__ import annotations

import difflib
import math
import os
import stat
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from ...core.base.errors import ArtrecError, ConfigError
from ...core.geometry.transforms import Array
from .kinds import kind_by_format, mistaken
from .yaml_loader import OF_LIBYAML, TOO_DEEP, parsed_yaml

MOST_BYTES = 2**28
"""Of any file that is read as a whole: a larger one is taken for something else."""
_MOST_YAML_BYTES = 2**20  # a second of reading; what this package writes has some ten thousand
_MOST_POINTS = 5000  # of an outline
LFS_MAGIC = b"version https://git-lfs.github.com/spec/"
LFS_POINTER = "is a pointer of Git LFS, which stands for the file itself: fetch that with 'git lfs pull'"

_FEW = 12  # names that a message may list
_NEAR_NAME = 0.75  # likeness of file names from which on one may be meant for the other


def nearest(name: str, known: Iterable[str]) -> str:
    """The rest of a message about an unknown name: the nearest known one, and all that are known if they are few."""
    known = list(known)
    group = name[: name.rfind(".") + 1]
    if any(not key.startswith(group) for key in known):
        group = ""
    own = {key.removeprefix(group): key for key in known}  # what all share makes none of them near
    close = difflib.get_close_matches(name.removeprefix(group), own, 1, cutoff=0.6)
    hint = f"; did you mean '{own[close[0]]}'?" if close else ""
    if hint and len(known) > _FEW:
        return hint
    return f"{hint} (known: {few(known) if known else 'none'})"


def few(names: Sequence[str]) -> str:
    """Names in a message: the first ones, and how many more there are."""
    more = f" and {len(names) - _FEW} more" if len(names) > _FEW else ""
    return ", ".join(names[:_FEW]) + more


@dataclass(frozen=True)
class Value:
    """A value of a file together with its place, so that errors can name it."""

    file: Path
    key: str
    raw: Any

    def error(self, message: str) -> ConfigError:
        place = f"{self.file}: {self.key}" if self.key else str(self.file)
        return ConfigError(f"{place}: {message}")

    def _child(self, key: str, raw: Any) -> Value:
        printable = key if key.isprintable() else repr(key)  # an error is one line
        return Value(self.file, f"{self.key}.{printable}" if self.key else printable, raw)

    def _wrong(self, wanted: str) -> ConfigError:
        return self.error(f"must be {wanted}, not {shown(self.raw)}")

    def entries(self) -> dict[str, Value]:
        """A mapping whose keys are names of the user's choice."""
        if not isinstance(self.raw, dict):
            raise self._wrong("a mapping (key: value)")
        for key in self.raw:
            if not isinstance(key, str):
                raise self.error(f"the name {key!r} is read as {type(key).__name__}; put it in quotes")
        return {key: self._child(key, raw) for key, raw in self.raw.items()}

    def fields(self, required: Sequence[str] = (), optional: Sequence[str] = ()) -> dict[str, Value]:
        """A mapping whose keys are fixed. Optional keys that are not given are left out."""
        entries, known = self.entries(), [*required, *optional]
        for key, value in entries.items():
            if key not in known:
                raise value.error(f"unknown key{nearest(key, known)}")
        for key in required:
            if key not in entries:
                raise self._child(key, None).error(f"this key is missing (needed: {', '.join(required)})")
        return entries

    def items(self) -> list[Value]:
        if not isinstance(self.raw, (list, tuple)):
            raise self._wrong("a list")
        return [Value(self.file, f"{self.key}[{i}]", raw) for i, raw in enumerate(self.raw)]

    def text(self, choices: Sequence[str] = ()) -> str:
        if not isinstance(self.raw, str) or not self.raw:
            raise self._wrong("text")
        if choices and self.raw not in choices:
            raise self.error(f"'{self.raw}' is not known{nearest(self.raw, choices)}")
        return self.raw

    def boolean(self) -> bool:
        if not isinstance(self.raw, bool):
            raise self._wrong("true or false")
        return self.raw

    def number(self, low: float | None = None, high: float | None = None, above: float | None = None) -> float:
        """A finite number, low <= number <= high, number > above."""
        if isinstance(self.raw, bool) or not isinstance(self.raw, (int, float)):
            raise self._wrong("a number")
        return float(self._in_range(self.raw, low, high, above))

    def integer(self, low: float | None = None, high: float | None = None) -> int:
        if isinstance(self.raw, bool) or not isinstance(self.raw, int):
            raise self._wrong("a whole number")
        return int(self._in_range(self.raw, low, high, None))

    def _in_range(self, value: float, low: float | None, high: float | None, above: float | None) -> float:
        if not is_finite(value):
            raise self._wrong("a finite number")
        if low is not None and value < low:
            raise self.error(f"{value} is below its least value {low:g}")
        if high is not None and value > high:
            raise self.error(f"{value} is above its greatest value {high:g}")
        if above is not None and not value > above:
            raise self.error(f"{value} must be greater than {above:g}")
        return value

    def vector(self, length: int, most: float = math.inf) -> Array:
        """(length,) numbers, none greater than `most` on either side of zero."""
        if not isinstance(self.raw, (list, tuple)) or len(self.raw) != length:
            raise self._wrong(f"{length} numbers [..]")
        return np.array([item.number(-most, most) for item in self.items()])

    def points(self, least: int, most: float = math.inf) -> Array:
        """(n, 2) points, n >= least, of coordinates up to `most`."""
        items = self.items()
        if len(items) < least:
            raise self.error(f"needs {least} points [x, y] or more, has {len(items)}")
        if len(items) > _MOST_POINTS:
            raise self.error(f"has {len(items)} points, more than {_MOST_POINTS}: no camera sees such detail")
        return np.array([item.vector(2, most) for item in items])


def shown(raw: Any) -> str:
    """A wrong value as a message shows it."""
    try:
        got = "nothing" if raw is None else repr(raw)
    except ValueError:  # Python writes no more digits than it reads
        got = "a number of thousands of digits"
    return got if len(got) <= 60 else f"{got[:57]}..."


def is_finite(value: float) -> bool:
    """Whether a number is finite, and no integer beyond all of type float."""
    try:
        return math.isfinite(value)
    except OverflowError:
        return False


def like_it(path: str | Path) -> str:
    """The end of a message about a path that is not there: what has nearly that name beside it."""
    path = Path(path)
    try:
        beside = [entry.name for entry in path.parent.iterdir() if entry.name != path.name]
    except (OSError, ValueError):
        return ""
    close = difflib.get_close_matches(path.name, beside, 1, cutoff=_NEAR_NAME)
    return f"; did you mean '{path.with_name(close[0])}'?" if close else ""


def size_of_file(path: str | Path, error: type[ArtrecError] = ConfigError) -> int:
    """Bytes of a regular file: others, such as pipes and devices, may never end.

    :param error: what is raised where it is none.
    """
    try:
        about = os.stat(path)
    except FileNotFoundError:
        raise error(f"{path}: there is no such file{like_it(path)}") from None
    except (OSError, ValueError) as reason:
        raise error(f"{path}: cannot be read: {getattr(reason, 'strerror', None) or reason}") from None
    if not stat.S_ISREG(about.st_mode):
        what = "a folder" if stat.S_ISDIR(about.st_mode) else "a pipe or device"
        raise error(f"{path}: is {what}; a file is wanted here")
    return about.st_size


def check_size(path: str | Path, most_bytes: int) -> None:
    """:raises ConfigError: it is no regular file, or a larger one."""
    size = size_of_file(path)
    if size > most_bytes:
        raise ConfigError(f"{path}: has {size} bytes, more than the {most_bytes} that such a file may have")


def read_bytes(path: str | Path, most_bytes: int = MOST_BYTES) -> bytes:
    """A file's content. :raises ConfigError: it is none, larger than that, or a pointer that stands for a file."""
    check_size(path, most_bytes)
    try:
        with open(path, "rb") as stream:
            content = stream.read(most_bytes)
    except OSError as error:
        raise ConfigError(f"{path}: cannot be read: {error.strerror}") from None
    if content.startswith(LFS_MAGIC):
        raise ConfigError(f"{path}: {LFS_POINTER}")
    return content


def read_text(path: str | Path, most_bytes: int = MOST_BYTES) -> str:
    """A text file's content; `ConfigError` as of `read_bytes`, and where it is no text."""
    try:
        return read_bytes(path, most_bytes).decode("utf-8-sig")  # some editors put a byte order mark before it
    except UnicodeDecodeError:
        raise ConfigError(f"{path}: is no text file (UTF-8)") from None


def load_value(path: str | Path, *, others: bool = False) -> Value:
    """A YAML file of any content as a `Value`. :param others: see `parsed_yaml`."""
    text = read_text(path, _MOST_YAML_BYTES)
    try:
        raw = parsed_yaml(text, others=others)
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        line, problem = f" line {mark.line + 1}:" if mark else "", str(error.problem or error.context)
        if OF_LIBYAML in problem:
            problem = TOO_DEEP
        elif "cannot start any token" in problem and mark and "\t" in text.splitlines()[mark.line]:
            problem = "a tab: YAML wants spaces"
        elif "another document" in problem:
            problem = "a second document begins; one file holds one: leave out '---' and what follows, or put it apart"
        raise ConfigError(f"{path}:{line} {problem}") from None
    except (yaml.YAMLError, TypeError, RecursionError) as error:
        raise ConfigError(f"{path}: is no valid YAML: {str(error).splitlines()[0]}") from None
    except (ValueError, LookupError, AttributeError, OverflowError):  # of PyYAML's constructors, each in its own way
        raise ConfigError(f"{path}: is no valid YAML: a value in it is none of its kind, or too long") from None
    if raw is None:
        raise ConfigError(f"{path}: the file is empty")
    return Value(Path(path), "", raw)


def load_yaml(path: str | Path, format: str) -> Value:
    """A file of this package: checks its `format: NAME/VERSION` line and returns the rest."""
    value = load_value(path)
    wanted = kind_by_format(format)
    if wanted and (problem := mistaken(value.raw, wanted)):
        raise value.error(f"{problem} (format: {format})")
    entries = value.entries()
    if "format" not in entries:
        raise value.error(f"format: this key is missing; the file must begin with 'format: {format}'")
    given = entries["format"].text()
    if given != format:
        kind, _, version = format.rpartition("/")
        same = given.rpartition("/")[0] == kind
        reason = f"this release reads version {version} only" if same else "another kind of file is wanted here"
        raise entries["format"].error(f"'{given}' cannot be read: {reason} ({format})")
    return Value(value.file, "", {k: v for k, v in value.raw.items() if k != "format"})
