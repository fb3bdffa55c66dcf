"""ROS writes a log file for each process, and starts none without a folder for it."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from ..core.base.errors import ConfigError

_WITHOUT_FILES = "--disable-external-lib-logs"


def check_log_folder(arguments: Sequence[str] = ()) -> None:
    """Where ROS could not write its log, it says so in lines about its sources, and names no way out.

    :param arguments: of the command line. :raises ConfigError: it cannot be written.
    """
    if _WITHOUT_FILES in arguments or "RCL_LOGGING_IMPLEMENTATION" in os.environ:  # which may write none
        return
    folder = _log_folder()
    try:
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
        problem = (
            "HOME is not set" if folder is None else "" if os.access(folder, os.W_OK | os.X_OK) else "not writable"
        )
    except OSError as error:
        problem = error.strerror or str(error)
    if problem:
        where = folder or "the folder of ROS' logs"
        raise ConfigError(f"{where}: {problem}: ROS starts nothing without a log; name a folder for it in ROS_LOG_DIR")


def _log_folder() -> Path | None:
    """By the rules of rcl_logging_interface. None: it would be in the home folder, and nothing names that."""
    given, ros_home = os.environ.get("ROS_LOG_DIR"), os.environ.get("ROS_HOME")
    folder = given or f"{ros_home or '~/.ros'}/log"
    home = os.environ.get("HOME")
    if not folder.startswith("~"):
        return Path(folder)
    return Path(home + folder[1:]) if home else None
