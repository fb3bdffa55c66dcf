"""What an object, a component or a marker may be called."""

from __future__ import annotations

import re

from ..base.errors import ConfigError

_NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_-]{0,79}")


def is_name(name: str) -> bool:
    """Whether `check_name` passes it."""
    return _NAME.fullmatch(name) is not None


def check_name(name: str, what: str) -> None:
    """Names become topics, joints' and frames' names, keypoints, file names and HTML: all of these bear what passes.

    :param what: 'component', for the error. :raises ConfigError: it is no name.
    """
    if not is_name(name):
        shown = repr(name) if len(name) <= 40 else f"{name[:37]!r}..."
        raise ConfigError(f"{what} {shown}: a name has 1 to 80 letters (a to z), digits, '_' and '-', no '-' in front")
