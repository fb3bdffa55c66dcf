"""How the shipped parameter files read images. Their constraint files, which training writes, are not needed."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from artrec_ros.core.base.config import ClassConfig, ImageConfig

CONFIG = Path(__file__).parents[1] / "config"


def image_config(name: str) -> ImageConfig:
    """The image section of config/NAME.yaml."""
    text = (CONFIG / f"{name}.yaml").read_text(encoding="utf-8")
    values = yaml.safe_load(text)["/**"]["ros__parameters"]["image"]
    classes = {
        name: ClassConfig(**{k: _as_read(v) for k, v in values.pop(name).items()}) for name in values.pop("classes")
    }
    return ImageConfig(classes=classes, blank=tuple(values.pop("blank")), **values)


def _as_read(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value
