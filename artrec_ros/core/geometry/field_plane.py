"""A plane of the scene in which points of known places lie: where on it each pixel is.

What lies in one plane goes from the image of a camera without distortion to the plane by a homography, whatever the
camera. It is fitted to the points by the direct linear transform with normalised coordinates (R. Hartley, "In defense
of the eight-point algorithm", 1997); distortion is undone before, where the camera is known.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.config import PlaneConfig
from ..base.errors import ConfigError
from .camera import Camera
from .projection import normalise, project
from .transforms import Array

_STEP_PX = 0.25  # of derivatives: a homography's is good to the square of this over its distance from the horizon
_LEAST_SPREAD = 2e-3  # of the equations' rank: points on a line, known to a thousandth of their distance
_MOST_OFF = 0.05  # what points may miss each other by, as a share of their extent


@dataclass(frozen=True, eq=False)
class FieldPlane:
    """A plane with x, y in metres; seen from above, where the camera is, y is to the left of x.

    :param matrix: (3, 3) homography from the undistorted image to the plane; w > 0 on the camera's side of the horizon.
    :param nearby: (2n, 3, 3) the same if the points' coordinates in the image were off by `point_noise_px`, one each.
    :param errors_px: (n,) how far the points lie from where the plane has them.
    """

    matrix: Array
    nearby: Array
    errors_px: Array
    config: PlaneConfig
    camera: Camera | None

    @classmethod
    def of(cls, config: PlaneConfig, camera: Camera | None) -> FieldPlane:
        """:param camera: undoes its lens' distortion; None: there is none.
        :raises ConfigError: the points do not make a plane that is seen from above.
        """
        pixels = np.reshape(config.image_points, (-1, 2)).astype(float)
        places = np.reshape(config.field_points, (-1, 2)).astype(float)
        image = _undistorted(pixels, camera)
        _check_spread(image, places)
        H = _fitted(places, image[None])
        _check_view(H[0], places)
        off = np.linalg.norm(_divided(_mapped(H, places)[0]) - image, axis=1)
        if off.max() > _MOST_OFF * np.ptp(image, axis=0).max():
            worst = int(off.argmax())
            raise ConfigError(
                f"scene.plane: the points do not fit together: point {worst + 1} at {pixels[worst].tolist()} lies "
                f"{off[worst]:.0f} px from where the others have it; both lists must have the same order"
            )
        moved = pixels + np.eye(pixels.size).reshape(-1, *pixels.shape) * config.point_noise_px
        moved = _undistorted(moved.reshape(-1, 2), camera).reshape(moved.shape)
        return cls(_inverse(H, image)[0], _inverse(_fitted(places, moved), image), off, config, camera)

    @property
    def frame_id(self) -> str:
        return self.config.frame_id

    def places(self, pixels: Array) -> Array:
        """(n, 2) metres of pixels (n, 2); NaN behind the horizon, where the plane is not."""
        mapped = _mapped(self.matrix[None], _undistorted(pixels, self.camera))[0]
        return np.where(mapped[:, 2:] > 0, _divided(mapped), np.nan)

    def jacobian(self, pixels: Array) -> Array:
        """(n, 2, 2) metres per pixel: rows x, y of the plane, columns x, y of the image."""
        return self._jacobian(self.matrix[None], pixels)[0]

    def scales(self, pixels: Array) -> Array:
        """(n,) pixels per metre, the geometric mean over all directions; 0 behind the horizon."""
        area = np.abs(np.linalg.det(self.jacobian(pixels)))
        beyond = np.isnan(self.places(pixels)).any(axis=1)
        return np.asarray(np.where(beyond | ~(area > 0), 0.0, np.maximum(area, 1e-30) ** -0.5), np.float64)

    def point_errors(self, pixel: Array) -> Array:
        """(2n, 3) by what x, y, and directions (radians) at a pixel (2,) would differ for `nearby`."""
        at = np.asarray(pixel, float)[None]
        moved = _divided(_mapped(self.nearby, _undistorted(at, self.camera)))[:, 0] - self.places(at)
        turned = self._jacobian(self.nearby, at)[:, 0] @ np.linalg.inv(self.jacobian(at)[0])
        angle = np.arctan2(turned[:, 1, 0] - turned[:, 0, 1], turned[:, 0, 0] + turned[:, 1, 1])
        return np.column_stack([moved, angle])

    def pixels(self, places: Array) -> Array:
        """(n, 2) pixels of places (n, 2), the lens' distortion included; NaN for what is behind the camera."""
        inverse = np.asarray(np.linalg.inv(self.matrix), np.float64)
        mapped = _mapped(inverse[None], places)[0]  # where w is positive its inverse's is, too
        before = mapped[:, 2] > 0
        out = np.full((len(places), 2), np.nan)
        out[before] = _divided(mapped[before])
        if self.camera is not None and self.camera.bent:
            rays = np.column_stack([out[before], np.ones(before.sum())]) @ np.linalg.inv(self.camera.matrix).T
            out[before] = project(self.camera, rays)
        return out

    def _jacobian(self, H: Array, pixels: Array) -> Array:
        """(k, n, 2, 2) of each homography (k, 3, 3) at each pixel (n, 2)."""
        steps = _STEP_PX * np.array([[1.0, 0], [-1, 0], [0, 1], [0, -1]])
        around = _undistorted((np.asarray(pixels, float)[:, None] + steps).reshape(-1, 2), self.camera)
        at = _divided(_mapped(H, around)).reshape(len(H), -1, 4, 2)
        return np.stack([at[:, :, 0] - at[:, :, 1], at[:, :, 2] - at[:, :, 3]], axis=-1) / (2 * _STEP_PX)


def _undistorted(pixels: Array, camera: Camera | None) -> Array:
    """(n, 2) where a camera without distortion would have them."""
    pixels = np.asarray(pixels, float)
    if camera is None or not camera.bent:
        return pixels
    return np.asarray(normalise(camera, pixels) @ camera.matrix[:2, :2].T + camera.matrix[:2, 2], np.float64)


def _mapped(H: Array, points: Array) -> Array:
    """(k, n, 3) points (n, 2) under homographies (k, 3, 3)."""
    return np.column_stack([points, np.ones(len(points))]) @ H.swapaxes(-1, -2)


def _divided(mapped: Array) -> Array:
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.asarray(mapped[..., :2] / mapped[..., 2:], np.float64)


def _normaliser(points: Array) -> Array:
    """(3, 3) the similarity after which points (n, 2) lie about the origin at a mean distance of sqrt 2."""
    centre = points.mean(axis=0)
    s = np.sqrt(2) / max(float(np.linalg.norm(points - centre, axis=1).mean()), 1e-12)
    return np.array([[s, 0, -s * centre[0]], [0, s, -s * centre[1]], [0, 0, 1]])


def _equations(source: Array, target: Array) -> Array:
    """(k, 2n, 9) of the homographies that take points (n, 2) to others (k, n, 2)."""
    k, n, _ = target.shape
    ones = np.broadcast_to(np.column_stack([source, np.ones(n)]), (k, n, 3))
    A = np.zeros((k, 2, n, 9))
    A[:, 0, :, :3], A[:, 1, :, 3:6] = ones, ones
    A[:, 0, :, 6:], A[:, 1, :, 6:] = -target[..., :1] * ones, -target[..., 1:] * ones
    return A.reshape(k, 2 * n, 9)


def _fitted(source: Array, target: Array) -> Array:
    """(k, 3, 3) homographies that take points (n, 2) to others (k, n, 2)."""
    S, T = _normaliser(source), _normaliser(target.reshape(-1, 2))
    A = _equations(_mapped(S[None], source)[0, :, :2], target * T[0, 0] + T[:2, 2])
    R = np.linalg.qr(A, mode="r")  # (k, 8 or 9, 9) has A's right singular vectors, without its 2n left ones
    h = np.linalg.svd(R)[2][:, -1].reshape(-1, 3, 3)
    return np.asarray(np.linalg.inv(T) @ h @ S, np.float64)


def _inverse(H: Array, seen: Array) -> Array:
    """(k, 3, 3) inverses of homographies (k, 3, 3), with w > 0 on the side where points (n, 2) are seen."""
    inverse = np.asarray(np.linalg.inv(H), np.float64)
    return inverse * np.sign(_mapped(inverse, seen)[:, :1, 2:])


def _check_spread(image: Array, places: Array) -> None:
    for name, points in (("image_points", image), ("field_points", places)):
        flat = _mapped(_normaliser(points)[None], points)[0, :, :2]
        # points among themselves: four of which three are on a line leave the identity undetermined
        if np.linalg.svd(_equations(flat, flat[None])[0], compute_uv=False)[7] < _LEAST_SPREAD:
            raise ConfigError(
                f"scene.plane.{name}: all of the points but one lie on a line, or some are one; spread them over the "
                "field, such as to its corners"
            )


def _check_view(H: Array, places: Array) -> None:
    """Of the homography from the plane to the image: the points are before the camera, and above is towards it."""
    w = _mapped(H[None], places)[0, :, 2]
    if not (w * w[0] > 0).all():
        raise ConfigError(
            "scene.plane: no camera sees the points like this: their order along the field's border is another one in "
            "image_points than in field_points; both lists must have the same order"
        )
    if np.linalg.det(H / w[0]) > 0:
        raise ConfigError(
            "scene.plane: the field is mirrored: seen from above y must be to the left of x; change the sign of y in "
            "field_points, or exchange x and y there"
        )
