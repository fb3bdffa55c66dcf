"""Files that a command writes by names that users give: nothing that they made, or that is read, is written over."""

from __future__ import annotations

import os
from collections.abc import Iterable
from pathlib import Path

from ...core.base.errors import ConfigError
from ...io.base.whole_files import check_place
from ...io.images.writing import DRAWING, DRAWING_SUFFIXES

OF_CONSTRAINTS, OF_COLOURS, OF_OBJECT = (
    "format: artrec_constraints/",
    "# Written by artrec learn-colours",
    "artrec_object/",
)
OF_METRICS, OF_PAGE, OF_RECORDING = '"format": "artrec_metrics/', ": evaluation</title>", "RRF"
OF_PAGES = "artrec model --print"  # a PDF's creator, which stands near its end
_NEAR_BYTES = 2**16  # of a file's beginning and of its end, where its mark stands


def check_output(output: Path, inputs: Iterable[Path], mark: str, *, overwrite: bool = True) -> None:
    """Before the work: whether its outcome can be written there, and nothing is lost by it.

    :param mark: what a file of the command's own holds near its beginning or end: it may be written anew, and so may an
        empty one. Empty: any file may. :param overwrite: False: none may.
    :raises ConfigError: it is one of the inputs, somebody else's file, or cannot be written.
    """
    check_not_read(output, inputs)
    if output.exists() and not overwrite:
        raise ConfigError(f"{output}: is there already; --overwrite replaces it")
    if mark and output.is_file() and not _holds(output, mark):
        raise ConfigError(
            f"{output}: is there already and was not written by this command, or by an earlier version of it; name "
            "another, or remove it"
        )
    check_place(output)


def check_drawing(flag: str, output: Path, inputs: Iterable[Path]) -> None:
    """As `check_output`, of a picture that a command draws: others' are not written over.

    :param flag: the option that names it. :raises ConfigError: also where its name's end is none of a drawing's.
    """
    if output.suffix.lower() not in DRAWING_SUFFIXES:
        raise ConfigError(f"{flag}: '{output}' must end in .png or .jpg")
    check_output(output, inputs, DRAWING)


def check_not_read(output: Path, inputs: Iterable[Path]) -> None:
    """:raises ConfigError: a file or folder to be written is one of the inputs, or an input lies in it."""
    if not (output.is_file() or output.is_dir()):  # devices and pipes hold nothing that could be lost
        return
    for given in inputs:
        if any(place.exists() and os.path.samefile(output, place) for place in (given, *given.absolute().parents)):
            raise ConfigError(f"{output}: is read by this command and would be written over; name another output")


def _holds(path: Path, mark: str) -> bool:
    """Or is empty."""
    try:
        with path.open("rb") as stream:
            head = stream.read(_NEAR_BYTES)
            stream.seek(max(len(head), stream.seek(0, os.SEEK_END) - _NEAR_BYTES))
            end = stream.read()
    except OSError:  # what cannot be read cannot be known
        return False
    return not head or mark.encode() in head + end
