"""Files that are whole whatever happens: a full disk or a kill leaves what was there before."""

from __future__ import annotations

import errno
import fcntl
import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial
from itertools import islice
from pathlib import Path

from ...core.base.errors import ConfigError, SourceError

_IN_PLACE = {errno.EBUSY, errno.EACCES, errno.EPERM, errno.EROFS}


def write_whole(path: Path, content: bytes | str) -> None:
    """The file is replaced at once, or not at all. :raises OSError: it cannot be written."""
    part = path.with_name(path.name + ".part")
    try:
        part.write_bytes(_bytes(content))
        if path.exists():
            shutil.copymode(path, part)
        os.replace(part, path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise


def save_file(path: str | Path, content: bytes | str) -> None:
    """A file by the name that a user gave, whole or not at all, where it can be replaced; folders are made, links
    followed.

    :raises ConfigError: it cannot be written; what could be replaced is as it was.
    """
    path = Path(path)
    with _told(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.is_file() or not path.exists():
            try:
                return write_whole(path.resolve(), content)
            except OSError as error:  # a folder that is read only, or a file that is mounted, may yet be written to
                if error.errno not in _IN_PLACE or not path.exists():
                    raise
        path.write_bytes(_bytes(content))  # such as /dev/stdout, beside which nothing can be written


def check_place(path: str | Path) -> None:
    """Whether `save_file` can write there, before the work whose outcome it is; folders are made.

    :raises ConfigError: it cannot.
    """
    path = Path(path)
    with _told(path):
        path.parent.mkdir(parents=True, exist_ok=True)
        if path.is_dir():
            raise IsADirectoryError(errno.EISDIR, os.strerror(errno.EISDIR))
        if path.exists() and not path.is_file():
            return  # a pipe, or a device
        target = path.resolve()
        part = target.with_name(target.name + ".part")
        try:
            part.touch()
            part.unlink()
        except OSError as error:
            if error.errno not in _IN_PLACE or not path.exists():
                raise
            os.close(os.open(path, os.O_WRONLY))


def make_folder(path: Path) -> None:
    """A folder by the name that a user gave. :raises ConfigError: it cannot be made."""
    with _told(path):
        path.mkdir(parents=True, exist_ok=True)


@contextmanager
def _told(path: Path) -> Iterator[None]:
    """:raises ConfigError: an OSError came up, of what cannot be written."""
    try:
        yield
    except OSError as error:
        raise ConfigError(f"{path}: cannot be written: {why_unwritable(path, error)}") from None
    except RuntimeError:  # Python's word for it
        raise ConfigError(f"{path}: cannot be written: its link leads back to itself") from None


def why_unwritable(path: Path, error: OSError) -> str:
    """What stands in the way of a file or folder by the name that a user gave, and the way out."""
    if isinstance(error, (FileExistsError, NotADirectoryError)):
        blocking = next((p for p in (path, *path.parents) if os.path.lexists(p) and not p.is_dir()), path)
        return f"{blocking} is no folder"
    if isinstance(error, FileNotFoundError):  # though folders are made: it is a place of another kind, such as /proc
        there = next((p for p in path.parents if p.is_dir()), path)
        return f"nothing can be made in {there}; name another place"
    elsewhere = "; name another place" if isinstance(error, PermissionError) or error.errno == errno.EROFS else ""
    return f"{error.strerror or error}{elsewhere}"


@contextmanager
def held(folder: Path) -> Iterator[Callable[[], None]]:
    """One process at a time holds a folder. Gives a check, which raises `SourceError` once it is gone.

    :raises SourceError: another process holds it. :raises OSError: no such folder.
    """
    handle = os.open(folder, os.O_RDONLY)
    try:
        fcntl.flock(handle, fcntl.LOCK_EX | fcntl.LOCK_NB)
        yield partial(_check_there, folder, handle)
    except BlockingIOError as error:
        raise SourceError(f"{folder}: another run is writing there; wait for it, or name another folder") from error
    finally:
        os.close(handle)


def _check_there(folder: Path, handle: int) -> None:
    """Whether a folder's name still leads to the one that is open: another run may have made it anew."""
    try:
        same = os.path.samestat(os.fstat(handle), os.stat(folder))
    except OSError:
        same = False
    if not same:
        raise SourceError(f"{folder} is gone: it was removed or renamed while results were written; begin anew")


def _bytes(content: bytes | str) -> bytes:
    return content if isinstance(content, bytes) else content.encode()


class LineFile:
    """A text file that grows by whole lines; one that is cut off at its end loses that line. A context manager.

    :ivar count: the lines that it holds.
    """

    def __init__(self, path: Path) -> None:
        """:raises OSError: it cannot be opened."""
        self._handle = os.open(path, os.O_RDWR | os.O_CREAT, 0o666)
        self._path = path
        whole = [line for line in _raw_lines(path) if line.endswith(b"\n")]
        self.count = len(whole)
        self._end = sum(map(len, whole))
        os.ftruncate(self._handle, self._end)

    def __enter__(self) -> LineFile:
        return self

    def __exit__(self, *raised: object) -> None:
        os.close(self._handle)

    def lines(self) -> Iterator[str]:
        """What it holds, without the ends of the lines."""
        for line in _raw_lines(self._path):
            yield line.decode(errors="replace").removesuffix("\n")

    def cut(self, count: int) -> None:
        """Leaves the first `count` lines. :raises OSError: it cannot be written."""
        self._end, self.count = sum(map(len, islice(_raw_lines(self._path), count))), count
        os.ftruncate(self._handle, self._end)

    def append(self, line: str) -> None:
        """:raises OSError: it cannot be written; the file is as it was before. :raises SourceError: it was removed."""
        if not os.fstat(self._handle).st_nlink:  # writing to it would go on without an error
            raise SourceError(f"{self._path} is gone: it was removed while it was written; begin anew")
        data = f"{line}\n".encode()
        try:
            written = 0
            while written < len(data):
                written += os.pwrite(self._handle, data[written:], self._end + written)
        except BaseException:
            os.ftruncate(self._handle, self._end)
            raise
        self._end += len(data)
        self.count += 1


def _raw_lines(path: Path) -> Iterator[bytes]:
    with path.open("rb") as stream:
        yield from stream
