"""Names of files and folders, as options give them."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path


def path(text: str) -> Path:
    """One that is not empty, as a variable leaves it that is not set: it would be the current folder. One that is text:
    OpenCV dies of others, and no file of results can hold them."""
    if not text:
        raise argparse.ArgumentTypeError("the name is empty, as of a variable that is not set; '.' is this folder")
    given = Path(text)
    try:
        str(given.absolute()).encode()
    except UnicodeEncodeError as error:
        shown = error.object.encode("utf-8", "backslashreplace").decode()
        encoding = sys.getfilesystemencoding()
        raise argparse.ArgumentTypeError(f"{shown} is no text in {encoding}; rename it, or set its locale") from None
    return given
