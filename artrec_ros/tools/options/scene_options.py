"""Options for the fields of the simulation's configurations, which hold defaults, units and meanings."""

from __future__ import annotations

import argparse
import dataclasses
from collections.abc import Collection
from typing import Any


def add_options(group: Any, config: type, names: Collection[str] | None = None) -> None:
    """One option for each field of a `param` dataclass, or for those that are named."""
    for field in dataclasses.fields(config):
        if names is not None and field.name not in names:
            continue
        default, meta = field.default, field.metadata
        paired = isinstance(default, tuple)
        sample = default[0] if isinstance(default, tuple) and default else default
        shown = " ".join(map(str, default)) if isinstance(default, tuple) else str(default)
        shown = f"{shown} {meta['unit']}".strip() if shown else meta["unit"]
        group.add_argument(
            "--" + field.name.replace("_", "-"),
            type=int if isinstance(sample, int) else float,
            nargs=2 if paired else None,
            metavar=("MIN", "MAX") if paired else "VALUE",
            help=meta["description"] + (f" ({shown})" if shown else ""),
        )


def given_options(args: argparse.Namespace, config: type) -> dict[str, Any]:
    """The values that the user gave, by the field's name."""
    given = {f.name: getattr(args, f.name, None) for f in dataclasses.fields(config)}
    return {k: tuple(v) if isinstance(v, list) else v for k, v in given.items() if v is not None}
