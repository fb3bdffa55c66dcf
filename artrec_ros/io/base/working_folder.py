"""The folder in which a process works, from which relative names of files start."""

from __future__ import annotations

import os

from ...core.base.errors import SourceError


def check_working_folder() -> None:
    """:raises SourceError: it was removed."""
    try:
        os.getcwd()
    except OSError as error:
        raise SourceError(
            f"the working directory cannot be read: {error.strerror}; change to another one (cd)"
        ) from None
