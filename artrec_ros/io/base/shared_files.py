"""Where the shipped files are (config/, launch/): in the source tree, a pip install or a colcon install."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from pathlib import Path

from ...core.base.errors import ConfigError

PACKAGE = "artrec_ros"
SCHEME = "package://"


def share_directory(package: str = PACKAGE) -> Path:
    """The folder that `package://<package>/` stands for.

    :raise ConfigError: the package is not installed in any known prefix.
    """
    if package == PACKAGE:
        source_tree = Path(__file__).resolve().parents[3]
        if (source_tree / "package.xml").is_file() and (source_tree / "config").is_dir():
            return source_tree
    prefixes = list(_prefixes())
    for prefix in prefixes:
        share = prefix / "share" / package
        if share.is_dir():
            return share
    raise ConfigError(
        f"{SCHEME}{package}: no such package in the {len(prefixes)} prefixes searched; source the workspace it is in "
        "(AMENT_PREFIX_PATH), or give a plain path"
    )


def resolve_path(path: str, base_dir: Path) -> Path:
    """An absolute path from what a user wrote: absolute, relative to `base_dir`, or package://NAME/REST."""
    if path.startswith(SCHEME):
        package, _, rest = path[len(SCHEME) :].partition("/")
        return share_directory(package) / rest
    return (base_dir / Path(path).expanduser()).absolute()


def _prefixes() -> Iterator[Path]:
    # Every install scheme puts lib/pythonX/site-packages (or dist-packages) and share/ under one prefix.
    yield from Path(__file__).absolute().parents
    yield Path(sys.prefix)
    yield from (Path(p) for p in os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p)
