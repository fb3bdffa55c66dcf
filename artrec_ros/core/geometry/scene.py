"""What is known of the scene in one camera's images: where objects are looked for, and how large they are there."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..base.config import SceneConfig
from ..base.errors import ConfigError
from .camera import Camera
from .field_plane import FieldPlane
from .floor import Floor
from .range_limits import ROUNDING
from .transforms import Array

_LEAST_AREA_PX = 1.0
_OFF_SCALE = re.compile(r"(\S+) px/m, but scene\.plane has (\S+) px/m there")


@dataclass(frozen=True, eq=False)
class Scene:
    """Nothing is known of what is None.

    :param region: (n, 2) corners of the polygon in which objects are.
    :param plane: on which the markers lie of objects that are found flat.
    :param floor: on which objects stand that are found in space.
    """

    region: Array | None = None
    plane: FieldPlane | None = None
    floor: Floor | None = None

    @classmethod
    def of(cls, config: SceneConfig, camera: Camera | None = None) -> Scene:
        """:param camera: of the images, where it is known.
        :raises ConfigError: a region without an area, or a plane's points that make none.
        """
        region = None
        if config.region:
            region = np.reshape(config.region, (-1, 2)).astype(float)
            if _area(region) < _LEAST_AREA_PX:
                raise ConfigError("scene.region: its corners enclose nothing; give them in order around the region")
        plane = FieldPlane.of(config.plane, camera) if config.plane.is_given else None
        return cls(region, plane, Floor.of(config.floor) if config.floor.is_given else None)

    def __bool__(self) -> bool:
        """Whether anything is known."""
        return any(known is not None for known in (self.region, self.plane, self.floor))

    def inside(self, pixels: Array) -> np.ndarray:
        """(n,) bool: which pixels (n, 2) lie in the region, by the even-odd rule."""
        if self.region is None:
            return np.ones(len(pixels), bool)
        (ax, ay), (bx, by) = self.region.T[..., None], np.roll(self.region, -1, axis=0).T[..., None]
        x, y = np.asarray(pixels, float).T
        with np.errstate(divide="ignore", invalid="ignore"):
            crossed = ((ay > y) != (by > y)) & (x < ax + (y - ay) * (bx - ax) / (by - ay))
        return np.asarray(crossed.sum(axis=0) % 2 == 1)

    def scale_limits(self, pixels: Array) -> Array:
        """(n, 2) least and greatest pixels per metre of objects at pixels (n, 2); 0 and infinity: any."""
        if self.plane is None:
            return np.tile([0.0, np.inf], (len(pixels), 1))
        tolerance = 1 + self.plane.config.scale_tolerance
        return np.asarray(self.plane.scales(pixels)[:, None] * (1 / tolerance, tolerance), np.float64)

    def stand(self, R: Array, t: Array) -> np.ndarray:
        """(n,) bool: which poses of objects in space stand on the floor: `Floor.standing`; all where none is known."""
        return np.ones(len(t), bool) if self.floor is None else self.floor.standing(R, t)

    def odds_against(self, R: Array, t: Array) -> Array:
        """(n,) of how high poses stand and how they lean: `Floor.odds_against`; 0 where no floor is known."""
        return np.zeros(len(t)) if self.floor is None else self.floor.odds_against(R, t)

    def may_stand(self, R: Array, t: Array, slack: float) -> np.ndarray:
        """(n,) bool: which guesses may come to stand on it: `Floor.may_stand`; all where none is known."""
        return np.ones(len(t), bool) if self.floor is None else self.floor.may_stand(R, t, slack)

    def reasons(self, pixels: Array, scales: Array | None = None) -> list[str | None]:
        """Why there can be no objects at pixels (n, 2); None where there can.

        :param scales: (n,) theirs, pixels per metre, of objects that are found flat; None: not asked for.
        """
        out: list[str | None] = [None if yes else "outside scene.region" for yes in self.inside(pixels)]
        if self.plane is None or scales is None:
            return out
        limits, known = self.scale_limits(pixels), self.plane.scales(pixels)
        for i, (scale, (least, most)) in enumerate(zip(scales, limits, strict=True)):
            if out[i] is None and not least / (1 + ROUNDING) <= scale <= most * (1 + ROUNDING):
                out[i] = _off_scale(float(scale), float(known[i]))
        return out


def _off_scale(scale: float, known: float) -> str:
    if not known > 0:
        return "behind the horizon of scene.plane"
    return f"{scale:.3g} px/m, but scene.plane has {known:.3g} px/m there: more than scale_tolerance off"


def times_the_scale(reason: str) -> float | None:
    """How many times the plane's scale an object had that was turned down for it; None: it was not for that."""
    off = _OFF_SCALE.match(reason)
    return None if off is None else float(off[1]) / float(off[2])


def _area(corners: Sequence[Sequence[float]] | Array) -> float:
    x, y = np.asarray(corners, float).T
    return float(abs(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2)
