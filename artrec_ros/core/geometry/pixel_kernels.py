"""Points, pixels and rays in compiled code; `pinhole` is the one camera, of arrays as well."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import lean, melted

MIN_DEPTH_M = 1e-3  # nearer points are pushed to this depth: their pixels land far outside the image


def pinhole(x: Any, y: Any, z: Any, K: Any, d: Any, bent: bool, fold: float) -> tuple[Any, Any]:
    """Pixels u, v of points x, y, z in the camera's frame, single numbers in compiled code or arrays of one shape.

    The lens is OpenCV's rational model on normalised coordinates (plumb_bob is its first five coefficients).

    :param K: (3, 3). :param d: (8,) k1 k2 p1 p2 k3 k4 k5 k6. :param bent, fold: as in `LabelView`.
    """
    z = np.maximum(z, MIN_DEPTH_M)
    u, v = x / z, y / z
    if bent:
        r2 = np.minimum(u * u + v * v, fold)
        radial = (1 + r2 * (d[0] + r2 * (d[1] + r2 * d[4]))) / (1 + r2 * (d[5] + r2 * (d[6] + r2 * d[7])))
        u, v = (
            u * radial + 2 * d[2] * u * v + d[3] * (r2 + 2 * u * u),
            v * radial + d[2] * (r2 + 2 * v * v) + 2 * d[3] * u * v,
        )
    return K[0, 0] * u + K[0, 1] * v + K[0, 2], K[1, 1] * v + K[1, 2]


_pinhole = melted(pinhole)


class Lens(NamedTuple):
    """A camera without an image."""

    K: Any  # (3, 3) a copy
    d: Any  # (8,) distortion
    bent: bool  # there is distortion
    fold: float  # squared radius at which the distortion folds back


class LabelView(NamedTuple):
    """A label image and the camera that took it."""

    padded: Any  # labels with a border of one pixel, flat
    width: int
    height: int
    K: Any  # (3, 3) a copy
    d: Any  # (8,) distortion
    bent: bool  # there is distortion
    fold: float  # squared radius at which the distortion folds back


@melted
def turned(A: Any, q: Any) -> tuple[float, float, float]:
    """A (3, 3) times q (3,)."""
    return (
        A[0, 0] * q[0] + A[0, 1] * q[1] + A[0, 2] * q[2],
        A[1, 0] * q[0] + A[1, 1] * q[1] + A[1, 2] * q[2],
        A[2, 0] * q[0] + A[2, 1] * q[1] + A[2, 2] * q[2],
    )


@lean
def pixel(px: float, py: float, width: int, height: int) -> int:
    """Index into the padded labels of the nearest pixel; NaN lies outside."""
    column = 0 if not px > -1.0 else (width + 1 if px >= width else int(math.floor(px + 0.5)) + 1)
    row = 0 if not py > -1.0 else (height + 1 if py >= height else int(math.floor(py + 0.5)) + 1)
    return row * (width + 2) + column


@lean
def codes_at(padded: Any, width: int, height: int, pixels: Any, out: Any) -> None:
    """Fill out (n,) with a padded image's values at the nearest pixels to (n, 2)."""
    for i in range(len(pixels)):
        out[i] = padded[pixel(pixels[i, 0], pixels[i, 1], width, height)]


@melted
def padded_pixel(x: float, y: float, view: LabelView) -> Any:
    """The same without branches, so that loops become vector instructions. x and y must be numbers: NaN would give any
    index at all."""
    row = np.int32(min(max(y, -1.0), float(view.height)) + 1.5)  # rounded, and one for the border
    return row * (view.width + 2) + np.int32(min(max(x, -1.0), float(view.width)) + 1.5)


@lean
def project(x: float, y: float, z: float, view: LabelView | Lens) -> tuple[float, float]:
    """Pixel of one point in the camera's frame."""
    u, v = _pinhole(x, y, z, view.K, view.d, view.bent, view.fold)
    return u, v


@melted
def locate(A: Any, b: Any, on: Any, view: LabelView, out: Any) -> None:
    """Fill out[:n] with the padded labels' indices of n points under A X + b.

    :param on: their x, y and z.
    """
    xs, ys, zs = on
    K = view.K
    if view.bent:
        for i in range(len(xs)):
            x, y, z = xs[i], ys[i], zs[i]
            u, v = project(
                A[0, 0] * x + A[0, 1] * y + A[0, 2] * z + b[0],
                A[1, 0] * x + A[1, 1] * y + A[1, 2] * z + b[1],
                A[2, 0] * x + A[2, 1] * y + A[2, 2] * z + b[2],
                view,
            )
            out[i] = pixel(u, v, view.width, view.height)
        return
    # K (A X + b) with K multiplied in once: a loop that the compiler turns into vector instructions
    u0, u1, u2 = (
        K[0, 0] * A[0, 0] + K[0, 1] * A[1, 0],
        K[0, 0] * A[0, 1] + K[0, 1] * A[1, 1],
        K[0, 0] * A[0, 2] + K[0, 1] * A[1, 2],
    )
    v0, v1, v2 = K[1, 1] * A[1, 0], K[1, 1] * A[1, 1], K[1, 1] * A[1, 2]
    u3, v3 = K[0, 0] * b[0] + K[0, 1] * b[1], K[1, 1] * b[1]
    z0, z1, z2, z3 = A[2, 0], A[2, 1], A[2, 2], b[2]
    cx, cy = K[0, 2], K[1, 2]
    for i in range(len(xs)):
        x, y, z = xs[i], ys[i], zs[i]
        k = 1.0 / max(z0 * x + z1 * y + z2 * z + z3, MIN_DEPTH_M)
        u, v = (u0 * x + u1 * y + u2 * z + u3) * k + cx, (v0 * x + v1 * y + v2 * z + v3) * k + cy
        out[i] = padded_pixel(u, v, view)


@melted
def locate_level(A: Any, b: Any, on: Any, view: LabelView, out: Any) -> None:
    """As `locate`, of points that are all at one depth before a camera that neither bends nor skews: as far off as the
    first, they need no division each."""
    xs, ys, zs = on
    K, z = view.K, zs[0]
    k = 1.0 / max(A[2, 2] * z + b[2], MIN_DEPTH_M)
    u0, u1, u2 = K[0, 0] * k * A[0, 0], K[0, 0] * k * A[0, 1], K[0, 0] * k * (A[0, 2] * z + b[0]) + K[0, 2]
    v0, v1, v2 = K[1, 1] * k * A[1, 0], K[1, 1] * k * A[1, 1], K[1, 1] * k * (A[1, 2] * z + b[1]) + K[1, 2]
    for i in range(len(xs)):
        out[i] = padded_pixel(u0 * xs[i] + u1 * ys[i] + u2, v0 * xs[i] + v1 * ys[i] + v2, view)


@melted
def outline_level(A: Any, b: Any, points: Any, along: Any, view: LabelView, out: Any) -> None:
    """As `outline_pixels`, of a contour that is all at one depth before a camera whose pixels are square, and neither
    bends nor skews: the contour's directions in the image are as long as they are."""
    K, xs, ys, gxs, gys, z = view.K, points[0], points[1], along[0], along[1], points[2, 0]
    us, vs, nus, nvs = out[0], out[1], out[2], out[3]
    k = K[0, 0] / max(A[2, 2] * z + b[2], MIN_DEPTH_M)
    u2, v2 = k * (A[0, 2] * z + b[0]) + K[0, 2], k * (A[1, 2] * z + b[1]) + K[1, 2]
    for i in range(len(xs)):
        us[i] = k * (A[0, 0] * xs[i] + A[0, 1] * ys[i]) + u2
        vs[i] = k * (A[1, 0] * xs[i] + A[1, 1] * ys[i]) + v2
        nus[i] = -(A[1, 0] * gxs[i] + A[1, 1] * gys[i])
        nvs[i] = A[0, 0] * gxs[i] + A[0, 1] * gys[i]


@melted
def outline_pixels(A: Any, b: Any, points: Any, along: Any, view: LabelView, out: Any) -> None:
    """Fill out (4, m) with the pixels u, v of a contour (3, m) under A X + b, and its outward unit normals there.

    A normal is perpendicular to the contour in the image: that in space, seen under slant, is not. A lens' bend is left
    out of it.

    :param along: (3, m) the contour's directions, counter-clockwise as seen from the front.
    """
    K, xs, ys, zs, gxs, gys, gzs = view.K, points[0], points[1], points[2], along[0], along[1], along[2]
    us, vs, nus, nvs = out[0], out[1], out[2], out[3]
    for i in range(len(xs)):
        x, y, z, gx, gy, gz = xs[i], ys[i], zs[i], gxs[i], gys[i], gzs[i]
        k = 1.0 / max(A[2, 0] * x + A[2, 1] * y + A[2, 2] * z + b[2], MIN_DEPTH_M)
        u = (A[0, 0] * x + A[0, 1] * y + A[0, 2] * z + b[0]) * k
        v = (A[1, 0] * x + A[1, 1] * y + A[1, 2] * z + b[1]) * k
        g = A[2, 0] * gx + A[2, 1] * gy + A[2, 2] * gz
        # the projection's derivative along the contour, times the depth, turned by a right angle
        nv = K[0, 0] * (A[0, 0] * gx + A[0, 1] * gy + A[0, 2] * gz - u * g)
        nu = -K[1, 1] * (A[1, 0] * gx + A[1, 1] * gy + A[1, 2] * gz - v * g)
        k = 1.0 / math.sqrt(nu * nu + nv * nv + 1e-24)
        us[i], vs[i], nus[i], nvs[i] = u, v, nu * k, nv * k
    if view.bent:
        for i in range(len(xs)):
            us[i], vs[i] = project(us[i], vs[i], 1.0, view)
        return
    for i in range(len(xs)):
        us[i], vs[i] = K[0, 0] * us[i] + K[0, 1] * vs[i] + K[0, 2], K[1, 1] * vs[i] + K[1, 2]
