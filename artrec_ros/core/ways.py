"""Which way of recognition an object takes: the profile, its model and the camera decide."""

from __future__ import annotations

from collections.abc import Sequence

from .base.config import RecognizerConfig
from .model.target import Target

PAPER, PLANE, FACING, SPACE = "paper", "plane", "facing", "space"


def way_of(target: Target, config: RecognizerConfig, *, calibrated: bool) -> str:
    """PAPER: as published. PLANE: markers one by one, grouped by learned constraints. As a whole: in SPACE, where
    markers have places and the camera is calibrated; FACING the camera, where it is not and the object is flat."""
    if config.profile == "paper":
        return PAPER
    if not (config.whole_object and target.model.is_spatial):
        return PLANE
    if calibrated:
        return SPACE
    return FACING if target.model.is_flat else PLANE


def of_way(way: str, targets: Sequence[Target], config: RecognizerConfig, *, calibrated: bool) -> tuple[Target, ...]:
    """The targets that take a way."""
    return tuple(t for t in targets if way_of(t, config, calibrated=calibrated) == way)
