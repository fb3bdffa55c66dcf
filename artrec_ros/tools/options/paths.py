"""Names of files and folders, as options give them."""

from __future__ import annotations

import argparse
from pathlib import Path


def path(text: str) -> Path:
    """An empty one would be the current folder: it is what a variable that is not set leaves."""
    if not text:
        raise argparse.ArgumentTypeError("the name is empty, as of a variable that is not set; '.' is this folder")
    return Path(text)
