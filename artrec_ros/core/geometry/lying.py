"""How far off what faces a camera lies, by the scale that the scene's plane has where it is."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from .camera import Camera
from .field_plane import FieldPlane
from .transforms import Array

_LOOKS = 3  # along each side of the image: what such a camera looks straight at is all but a plane to it


@dataclass(frozen=True)
class Lying:
    """What a plane is to a camera that is a convention, of what lies on it: the depth is told by the scale alone.

    :param up: (3,) towards the camera, in its optical frame. :param standing_at_m: how far above the camera it is.
    :param height_sigma_m: deviation of what is of any scale within the tolerance.
    """

    up: Array
    standing_at_m: float
    height_sigma_m: float
    leaning_sigma_rad = np.inf  # it faces the camera

    @classmethod
    def of(cls, plane: FieldPlane, camera: Camera) -> Lying | None:
        """None where there is none in the image. :param camera: see `Camera.facing`."""
        sides = (np.linspace(0.0, n - 1.0, _LOOKS) for n in camera.size)
        pixels = np.stack(np.meshgrid(*sides), axis=-1).reshape(-1, 2)
        scales = plane.scales(pixels)
        pixels, scales = pixels[scales > 0], scales[scales > 0]
        rays = np.column_stack([pixels - camera.matrix[:2, 2], np.full(len(pixels), camera.focal_px)])
        if len(rays) < _LOOKS:
            return None
        normal = np.linalg.lstsq(rays / scales[:, None], np.ones(len(rays)), rcond=None)[0]
        far = 1 / float(np.linalg.norm(normal))
        sigma = far * np.log1p(plane.config.scale_tolerance) / np.sqrt(3)
        return cls(np.asarray(-far * normal, np.float64), -far, float(sigma))

    def nearer(self, by_m: float) -> Lying:
        """Of places so far behind those that are of that scale."""
        return replace(self, standing_at_m=self.standing_at_m + by_m * float(self.up[2]))

    def odds_against(self, t: Array) -> Array:
        """(n,) logarithm of how many times as likely as at places (n, 3) what is there is at the plane's scale: by
        deviations."""
        return np.asarray(((t @ self.up - self.standing_at_m) / self.height_sigma_m) ** 2 / 2, np.float64)
