"""A pinhole camera with lens distortion."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .pixel_kernels import Lens
from .transforms import Array, readonly

_MAX_RADIUS = 3.0  # normalised: 72 degrees from the axis
_FACING = 4.0  # the image's corners are then 10 degrees off the axis


@dataclass(frozen=True)
class Camera:
    """A pinhole camera with lens distortion, in the units of the image that is given.

    :param matrix: (3, 3) K, pixels; a pixel's centre has integer coordinates.
    :param distortion: coefficients as OpenCV orders them (plumb_bob, rational_polynomial); empty: none.
    :param size: (width, height) pixels.
    :param frame_id: the optical frame, as the image's header names it.
    """

    matrix: Array
    distortion: Array
    size: tuple[int, int]
    frame_id: str = ""

    def __post_init__(self) -> None:
        object.__setattr__(self, "matrix", readonly(self.matrix).reshape(3, 3))
        object.__setattr__(self, "distortion", readonly(self.distortion).reshape(-1))

    @classmethod
    def facing(cls, size: tuple[int, int]) -> Camera:
        """A camera for objects that face it, whatever it is: these are similarities of the image plane.

        Its focal length, `_FACING` times the image's longer side, is a convention: a scale of k pixels per metre is
        told as the depth f / k. It is long, so that all lines of sight are nearly one (scaled orthographic).
        """
        return cls.pinhole(size, _FACING * max(size))

    @classmethod
    def pinhole(cls, size: tuple[int, int], focal_px: float, frame_id: str = "") -> Camera:
        """A camera without distortion, its axis through the image's centre."""
        width, height = size
        K = np.array([[focal_px, 0, (width - 1) / 2], [0, focal_px, (height - 1) / 2], [0, 0, 1]])
        return cls(K, np.zeros(0), size, frame_id)

    def sees_as(self, other: Camera) -> bool:
        """Whether both have the same pixels for the same points."""
        return np.array_equal(self.matrix, other.matrix) and np.array_equal(self.rational, other.rational)

    @cached_property
    def rational(self) -> Array:
        """(8,) coefficients k1 k2 p1 p2 k3 k4 k5 k6 of OpenCV's rational model; those that are not given are 0."""
        known = self.distortion[:8]
        return readonly([*known.tolist(), *[0.0] * (8 - len(known))])

    @cached_property
    def focal_px(self) -> float:
        """The geometric mean of both focal lengths: a length of 1 m across the view, 1 m away, has so many pixels."""
        return float(np.sqrt(self.matrix[0, 0] * self.matrix[1, 1]))

    @cached_property
    def bent(self) -> bool:
        """Whether the lens distorts at all."""
        return bool(self.distortion.any())

    @cached_property
    def lens(self) -> Lens:
        """What compiled code needs of it.

        Arrays are copied: those of one that came from another process may be written to, and compiled code would take
        them for another kind.
        """
        return Lens(np.array(self.matrix), np.array(self.rational), self.bent, self.fold)

    @cached_property
    def straight(self) -> tuple[Array, Array] | None:
        """Focal lengths (2,) and centre (2,) of one that neither bends nor skews, by which alone x / z and y / z become
        pixels; None of others."""
        K = self.matrix
        return None if self.bent or K[0, 1] != 0 else (np.array([K[0, 0], K[1, 1]]), K[:2, 2].copy())

    @cached_property
    def fold(self) -> float:
        """Squared normalised radius up to which the lens' radial factor grows; points behind it would fold back."""
        if not self.bent:
            return _MAX_RADIUS**2
        k1, k2, _, _, k3, k4, k5, k6 = self.rational
        r = np.linspace(0, _MAX_RADIUS, 3001)
        r2 = r * r
        with np.errstate(all="ignore"):  # of coefficients that no lens has
            below = 1 + r2 * (k4 + r2 * (k5 + r2 * k6))
            seen = r * (1 + r2 * (k1 + r2 * (k2 + r2 * k3))) / below
            grows = (np.diff(seen) > 0) & np.isfinite(seen[1:]) & (below[1:] > 0)  # behind a pole nothing is seen
        falls = np.flatnonzero(~grows)
        return float(r2[falls[0]]) if len(falls) else float(r2[-1])
