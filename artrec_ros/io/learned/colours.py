"""Learned colours as a parameter file: the part under `image`, to be pasted into the node's or given beside it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from ...core.base.config import ClassConfig, ImageConfig
from ..base.whole_files import save_file

_HEADER = (
    "# Written by artrec learn-colours: reference colours r,g,b,... in the light that is usual (docs/colours.md).\n"
)


def save_colours(path: str | Path, image: ImageConfig) -> None:
    """Writes what differs from the defaults, and what was decided, as it is read after colours learned before;
    `ConfigError` where that is not possible."""
    decided = {name: getattr(image, name) for name in ("kind", "gamma", "blur_px", "sharpen_px")}
    values: dict[str, Any] = decided | _changed(image, ImageConfig())
    if image.background:
        values["background_light"] = list(image.background_light)
    values["classes"] = list(image.classes)
    values |= {name: {**_changed(cls, ClassConfig()), "light": list(cls.light)} for name, cls in image.classes.items()}
    text = yaml.safe_dump({"/**": {"ros__parameters": {"image": values}}}, sort_keys=False, default_flow_style=None)
    save_file(path, _HEADER + text)


def _changed(config: Any, default: Any) -> dict[str, Any]:
    changed = {k: v for k, v in vars(config).items() if k != "classes" and v != getattr(default, k)}
    return {k: list(v) if isinstance(v, tuple) else v for k, v in changed.items()}
