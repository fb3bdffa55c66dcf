"""The floor on which objects stand, from where the camera is: which poses stand on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.config import FloorConfig
from .transforms import Array, rotation_from_rotvec

_GUESS_DEG = 30.0  # views of a marker are as far apart, whatever an object may lean
_GUESS_SHARE = 0.1  # of the range, and so of what is below the camera: small blobs tell their scale to a tenth
_ANY_DEG = 180.0  # nothing leans more
_HELD = 0.999  # of the limit: what is turned back to it must not be rounded beyond it


@dataclass(frozen=True, eq=False)
class Floor:
    """A horizontal floor.

    :param up: (3,) upwards, in the camera's optical frame.
    """

    up: Array
    config: FloorConfig

    @classmethod
    def of(cls, config: FloorConfig) -> Floor:
        """From the pitch and roll of the camera above it."""
        pitch, roll = np.radians([config.camera_pitch_deg, config.camera_roll_deg])
        c = np.cos(pitch)
        return cls(np.array([-np.sin(roll) * c, -np.cos(roll) * c, -np.sin(pitch)]), config)

    @property
    def standing_at_m(self) -> float:
        """How far above the camera the place of an object that stands on it is."""
        return float(self.config.object_height_m - self.config.camera_height_m)

    @property
    def height_sigma_m(self) -> float:
        """Deviation of the height of what is anywhere between the limits."""
        return float(self.config.height_tolerance_m / np.sqrt(3))

    @property
    def leaning_sigma_rad(self) -> float:
        """Deviation of how far what leans anyhow within the limit does so to one side: half the radius of a disc.
        Infinite where it may lie any way round: nothing is known then."""
        most_deg = self.config.max_tilt_deg
        return float(np.radians(most_deg) / 2) if most_deg < _ANY_DEG else np.inf

    @property
    def log_depths(self) -> float:
        """Logarithm of how many times as far off as the nearest place on a line of sight at which an object may stand
        the farthest is: of all lines the same."""
        off, most = abs(self.standing_at_m), self.config.height_tolerance_m
        return float(np.log((off + most) / (off - most))) if off > most else np.inf

    def heights(self, t: Array) -> Array:
        """(n,) metres above the floor of points (n, 3) in the camera."""
        return np.asarray(t @ self.up + self.config.camera_height_m, np.float64)

    def tilts_deg(self, R: Array) -> Array:
        """(n,) by how much the z axes of rotations (n, 3, 3) lean."""
        return np.asarray(np.degrees(np.arccos(np.clip(R[:, :, 2] @ self.up, -1, 1))), np.float64)

    def odds_against(self, R: Array, t: Array) -> Array:
        """(n,) logarithm of how many times as likely as a pose what stands upright at its height is: by deviations."""
        off = (self.heights(t) - self.config.object_height_m) / self.height_sigma_m
        return np.asarray((off**2 + (np.radians(self.tilts_deg(R)) / self.leaning_sigma_rad) ** 2) / 2, np.float64)

    def standing(self, R: Array, t: Array) -> np.ndarray:
        """(n,) bool: which poses stand on it."""
        return self._within(R, t, self.config.height_tolerance_m, self.config.max_tilt_deg)

    def may_stand(self, R: Array, t: Array, slack: float) -> np.ndarray:
        """(n,) bool: which guesses may come to stand on it, limits being so many times what they are, of leaning
        `_GUESS_DEG` at least, and of height as far as a share of the range leads from it."""
        most_deg = max(slack * self.config.max_tilt_deg, _GUESS_DEG)
        most_m = np.maximum(slack * self.config.height_tolerance_m, _GUESS_SHARE * np.abs(t @ self.up))
        return self._within(R, t, most_m, most_deg)

    def _within(self, R: Array, t: Array, most_m: float | Array, most_deg: float) -> np.ndarray:
        off = np.abs(self.heights(t) - self.config.object_height_m)
        return np.asarray((off <= most_m) & (self.tilts_deg(R) <= most_deg))

    def turns_upright(self, R: Array) -> Array:
        """(n, 3, 3) the least turns, in the camera, after which rotations (n, 3, 3) lean no more than they may."""
        z = R[:, :, 2]
        axis, by = np.cross(z, self.up), np.radians(self.tilts_deg(R) - _HELD * self.config.max_tilt_deg)
        axis /= np.maximum(np.linalg.norm(axis, axis=1, keepdims=True), 1e-9)
        return rotation_from_rotvec(np.maximum(by, 0.0)[:, None] * axis)

    def reasons(self, R: Array, t: Array) -> list[str | None]:
        """Why poses do not stand on it; None of those that do."""
        config = self.config
        out: list[str | None] = []
        for height, tilt in zip(self.heights(t).tolist(), self.tilts_deg(R).tolist(), strict=True):
            reason = None
            if abs(height - config.object_height_m) > config.height_tolerance_m:
                reason = f"{height:.2f} m above the floor, not {config.object_height_m:g} m: scene.floor"
            elif tilt > config.max_tilt_deg:
                reason = f"leans by {tilt:.0f} deg, scene.floor.max_tilt_deg is {config.max_tilt_deg:g}"
            out.append(reason)
        return out
