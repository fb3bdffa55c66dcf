"""The one family of errors that users see: each names the value, what would be valid and the way out."""

from __future__ import annotations

import re
import textwrap

_MOST_CHARACTERS = 300  # what is longer is no line, as what a compiler says
_COLOURS = re.compile(r"\x1b\[[0-9;]*m")


class ArtrecError(Exception):
    """Base of every error that artrec_ros raises on purpose; its text is one line for the user."""


class ConfigError(ArtrecError):
    """A parameter, object or constraint file, or a value in it, is not valid."""


class ImageError(ArtrecError):
    """One image cannot be used; the next one may be fine."""


class SourceError(ArtrecError):
    """A bag or folder cannot be read."""


class UnreadableError(SourceError):
    """A source is what it should be, but damaged: nothing that a user could say otherwise would help, and others may be
    fine."""


def one_line(error: BaseException) -> str:
    """An error as users see it: what was raised on purpose says all; of a fault of this package the kind of it and the
    beginning of what it says, without a terminal's colours."""
    if isinstance(error, (ArtrecError, OSError)):
        return " ".join(str(error).split())
    text = textwrap.shorten(_COLOURS.sub("", str(error)), _MOST_CHARACTERS, placeholder=" ...")
    return f"internal error: {type(error).__name__}: {text}"
