"""Which way of recognition an object takes: the profile, its model and the camera decide."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from .base.config import RecognizerConfig
from .model.target import Target

PAPER, PLANE, FACING, SPACE = "paper", "plane", "facing", "space"


def way_of(target: Target, config: RecognizerConfig, *, calibrated: bool) -> str:
    """PAPER: as published. PLANE: markers one by one, grouped by learned constraints. As a whole, where markers have
    places: FACING the camera, where the object is flat, and lies on a known plane or the camera is not calibrated; in
    SPACE, where it is."""
    if config.profile == "paper":
        return PAPER
    if not (config.whole_object and target.model.is_spatial):
        return PLANE
    if target.model.is_flat and (config.scene.plane.is_given or not calibrated):
        return FACING
    return SPACE if calibrated else PLANE


def of_way(way: str, targets: Sequence[Target], config: RecognizerConfig, *, calibrated: bool) -> tuple[Target, ...]:
    """The targets that take a way, by their names: of two that look the same whose turn comes first is found first."""
    mine = (t for t in targets if way_of(t, config, calibrated=calibrated) == way)
    return tuple(sorted(mine, key=lambda t: t.name))


def all_on_plane(targets: Sequence[Target], config: RecognizerConfig) -> bool:
    """Whether every target gets its metric poses from the scene's plane, and needs no calibration for them."""
    return config.scene.plane.is_given and not of_way(SPACE, targets, config, calibrated=True)


def remembers(targets: Sequence[Target], config: RecognizerConfig, calibrated: Iterable[bool]) -> bool:
    """Whether one image tells something of the next, of images with or without calibration."""
    ways = {way_of(t, config, calibrated=c) for t in targets for c in calibrated}
    return config.memory and not ways.isdisjoint((SPACE, FACING))
