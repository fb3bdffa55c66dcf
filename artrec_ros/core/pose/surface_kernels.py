"""A spatial model's surface as arrays, and scratch arrays that fit it."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import LANES, inlined, jit, melted
from ..geometry.pixel_kernels import LabelView, outline_level, outline_pixels, padded_pixel, turned

NEAR = 0.2  # a patch's radius, as a share of its depth, from which on its far points stand for less than its near ones
MOST_LENGTH, MOST_WEIGHT = 2.0, 8.0  # at half the depth of a patch's middle: what is nearer lies outside the image
LEAST_STRIP_PX = 1.0  # of what shows less, where it ends and where it begins are one edge
LEAST_DEPTH_M = 0.02  # what is nearer, or behind the camera, has no place in the image to speak of


class Surface(NamedTuple):
    """P patches and B boxes of a spatial model as arrays.

    Patch p owns the points from starts[p] to starts[p + 1], of which the first count[p] count, of a patch of many
    pixels as many as most[p]; the others fill up a vector instruction.
    """

    component: Any  # (P,)
    stack: Any  # (P,) number of the stack that a marker is in, see `stacks_of`, -1: in none
    stacked: Any  # (n,) patches in stacks, one stack after the other
    normal: Any  # (P, 3)
    centre: Any  # (P, 3)
    area: Any  # (P,)
    radius: Any  # (P,) of a ball about the centre that holds the patch
    extent: Any  # (P, 2, 3) along its axes as far as it reaches from the centre, in its component's frame
    marker_of: Any  # (P,) index into the markers' contours, -1: a face
    ignored: Any  # (P, B) bool: boxes that the patch lies on
    starts: Any  # (P + 1,) multiples of LANES
    count: Any  # (P,)
    most: Any  # (P,)
    points: Any  # (3, n)
    role: Any  # (P,)
    bulge: Any  # (P,) by how much what it stands for lies before it, metres: a ball's radius; else 0
    contour: Any  # (M, 3, m)
    contour_along: Any  # (M, 3, m) unit directions of the contour, counter-clockwise as seen from the front
    perimeter: Any  # (M,)
    half_width: Any  # (M,) metres, of the side of a solid that of all of it
    ring_role: Any  # (M,)
    rim_role: Any  # (M,)
    open_ring: Any  # (M, m) 1, or 0 where another marker of the object begins at the contour
    meets: Any  # (M, m) marker of the same class that each point of a contour meets at an angle, -1: none
    has_meets: Any  # (M,) bool: whether a marker meets others so
    patch_of: Any  # (M,) each marker's patch
    like: Any  # (M, M) bool: markers that joints move against each other, and that may be of one class
    pairs: Any  # (n, 2) of these each pair once
    spread: Any  # (M, 2, 3) along its axes as far as its points deviate, metres, in its component's frame
    like_box: Any  # (M, B) bool: boxes that joints move against a marker, and that may be of its class
    table: Any  # (roles, 256) votes
    own: Any  # (roles, 256) how far each code is of the piece's own class
    best: Any  # (roles,) the greatest vote of each
    box_component: Any  # (B,)
    box_rotation: Any  # (B, 3, 3)
    box_t: Any  # (B, 3)
    half: Any  # (B, 3)
    box_radius: Any  # (B,) of a ball that holds the box


class SurfaceLimits(NamedTuple):
    """What votes need to know besides the surface: values of `VotesConfig`, and what labels mean."""

    least_cosine: float
    ring_px: float
    ring_share: float  # of half the width of a wide marker, see `widened`
    ring_width_px: float
    ring_visible: float  # share of a marker, of what its object leaves of it, below which its ring does not vote
    point_px: float  # as far apart are the points of a patch of many pixels
    behind: float  # share of the way to a point beyond which nothing hides it
    outside: int  # the label beyond the image
    owned: int  # the label of what hides all behind it: an object that was accepted
    shared: float  # of a marker that lies on a likelier one of its class by more than this share
    rest_agree: float  # the rest must bear the class by this one
    swollen_px: float = 0.0  # by so much markers look larger than they are, all around
    level: bool = False  # whether all of a patch is at one depth before a camera made for what faces it


@melted
def is_turned_here(s: Surface, p: int, cosine: float, depth: float, f2: float, least_cosine: float) -> bool:
    """Whether a patch looks towards the camera, so that it has a say: by the cosine at which it is seen, and sides that
    meet as long as one ends a pixel or more from where it begins; else what shows of it would be nobody's.

    :param depth: of its middle, metres. :param f2: square of the focal length, pixels.
    """
    if cosine > least_cosine:
        return True
    k = s.marker_of[p]
    if k < 0 or not s.has_meets[k] or not (cosine > 0.0 and depth > LEAST_DEPTH_M):
        return False
    return math.sqrt(s.area[p] * f2) * cosine / depth > LEAST_STRIP_PX


@melted
def widened(s: Surface, k: int, depth: float, f2: float, limits: SurfaceLimits) -> float:
    """How many times as far from the outline of marker `k` as `ring_px` rim and ring are looked at: of a wide one
    farther, for its file, its camera's calibration and the fit are off by shares of its size; of the side of a solid by
    shares of the solid's.

    :param depth: of its middle, metres. :param f2: square of the focal length, pixels.
    """
    half_px = s.half_width[k] * math.sqrt(f2) / max(depth, LEAST_DEPTH_M)
    return max(1.0, limits.ring_share * half_px / limits.ring_px)


@melted
def beside(s: Surface, k: int, depth: float, view: LabelView, limits: SurfaceLimits) -> tuple[float, float]:
    """How far outside and inside of a marker's outline it is looked at, pixels: of the one that it seems to have."""
    far = limits.ring_px * widened(s, k, depth, view.K[0, 0] * view.K[1, 1], limits)
    return far + limits.swollen_px, far - limits.swollen_px


@melted
def count_for(s: Surface, p: int, size_px: float, limits: SurfaceLimits) -> int:
    """How many points of a patch of so many pixels are looked at: rim and ring do not see how far beyond a blob a model
    reaches that is larger, and amid few points, far apart, a climb would find room for it."""
    return max(s.count[p], min(s.most[p], int(size_px / limits.point_px**2)))


@inlined
def points_of(s: Surface, p: int, count: int) -> tuple[Any, Any, Any]:
    """x, y and z of the first points of a patch, so many or up to the next multiple of LANES: slices of their own, over
    which loops become vector instructions."""
    first = s.starts[p]
    last = first + (count + LANES - 1) // LANES * LANES
    return s.points[0, first:last], s.points[1, first:last], s.points[2, first:last]


class Room(NamedTuple):
    """Scratch arrays of one hypothesis."""

    at: Any  # (2, n) pixels of a patch
    weight: Any  # (n,) what its points stand for
    outline: Any  # (4, m), see `outline_pixels`
    hidden: Any  # (n,)
    near: Any  # (B,)
    box_rotation: Any  # (B, 3, 3)
    eye: Any  # (B, 3)
    middle: Any  # (B, 3)
    inner: Any  # (m,) see `find_inner`
    open: Any  # (M, m) `Surface.open_ring`, -1 where another part of the hypothesis lies beyond: `cover`
    outlines: Any  # (M, 4, m), see `outline_pixels`
    shown: Any  # (M,) bool: markers that face the camera
    depth: Any  # (M,) of their middles
    beyond: Any  # (3, m) points beyond a contour
    taken: Any  # (M,) share of a marker that likelier ones of its class explain
    wide: Any  # (3, 3) a larger marker's place
    moved: Any  # (3,)


@jit
def room_of(s: Surface) -> Room:
    """Scratch arrays that fit a surface."""
    n, n_m, m = len(s.half), s.contour.shape[0], s.contour.shape[2]
    most, is_open = m, np.empty((n_m, m))
    for k in range(n_m):
        for i in range(m):
            is_open[k, i] = s.open_ring[k, i]
    for p in range(len(s.starts) - 1):  # numpy's own functions take longer to compile
        most = max(most, s.starts[p + 1] - s.starts[p])
    return Room(
        np.empty((2, most), np.int32), np.empty(most), np.empty((4, m)), np.empty(most, np.bool_),
        np.empty(n, np.int64), np.empty((n, 3, 3)), np.empty((n, 3)), np.empty((n, 3)),
        np.empty(m, np.int32), is_open, np.empty((n_m, 4, m)), np.empty(n_m, np.bool_),
        np.empty(n_m), np.empty((3, m)), np.zeros(n_m),
        np.empty((3, 3)), np.empty(3),
    )  # fmt: skip


@melted
def surface_share(s: Surface, p: int, depth: float, end: float) -> float:
    """Share of the way to a point of a patch beyond which nothing hides it: of a ball's disc where the ball begins.

    :param depth: of its middle, metres. :param end: of others.
    """
    bulge = s.bulge[p]
    if bulge == 0.0:
        return end
    return end * max(math.sqrt(depth * depth + bulge * bulge) - bulge, 0.0) / max(depth, LEAST_DEPTH_M)


@melted
def is_near(s: Surface, p: int, depth: float) -> bool:
    """Whether the points of a patch stand for unlike areas of the image. :param depth: of its middle."""
    return s.radius[p] > NEAR * depth


@melted
def weigh_points(A: Any, b: Any, on: Any, depth: float, weight: Any) -> None:
    """How many times the pixels that a patch's mean point stands for its points x, y, z stand for: areas in a plane
    shrink with the cube of their depth. :param depth: of its middle."""
    xs, ys, zs = on
    z0, z1, z2, z3 = A[2, 0], A[2, 1], A[2, 2], b[2]
    for i in range(len(xs)):
        nearer = depth / max(z0 * xs[i] + z1 * ys[i] + z2 * zs[i] + z3, LEAST_DEPTH_M)
        weight[i] = min(nearer * nearer * nearer, MOST_WEIGHT)


@melted
def aspect(s: Surface, p: int, A: Any, b: Any) -> tuple[float, float, float, float]:
    """Cosine of the viewing angle of a patch, and its centre in the camera."""
    nx, ny, nz = turned(A, s.normal[p])
    mx, my, mz = turned(A, s.centre[p])
    mx, my, mz = mx + b[0], my + b[1], mz + b[2]
    cosine = -(nx * mx + ny * my + nz * mz) / max(math.sqrt(mx * mx + my * my + mz * mz), 1e-9)
    return cosine, mx, my, mz


@melted
def find_inner(s: Surface, k: int, A: Any, b: Any, view: LabelView, inner: Any) -> None:
    """Fill inner (m,) with 1 where the contour of marker `k` meets one of its component that the camera sees, too:
    there the class does not end. Else 0.

    :param A, b: the frame of both.
    """
    last, seen = -1, False
    for i in range(len(inner)):
        j = s.meets[k, i]
        if j >= 0 and j != last:
            cosine, _, _, depth = aspect(s, s.patch_of[j], A, b)
            deep_px = math.sqrt(s.area[s.patch_of[j]]) * cosine * view.K[0, 0] / max(depth, LEAST_DEPTH_M)
            last, seen = j, deep_px > LEAST_STRIP_PX
        inner[i] = 1 if j >= 0 and seen else 0


@melted
def look_beside(
    s: Surface, k: int, A: Any, b: Any, depth: float, view: LabelView, limits: SurfaceLimits, room: Room
) -> None:  # fmt: skip
    """Fill the first (m,) of room.at with the pixels just outside and just inside of the outline of marker `k`, of the
    one that it seems to have; where it meets others room.inner, too, as of `find_inner`.

    :param A, b: its frame. :param depth: of its middle, metres.
    """
    if limits.level:
        outline_level(A, b, s.contour[k], s.contour_along[k], view, room.outline)
    else:
        outline_pixels(A, b, s.contour[k], s.contour_along[k], view, room.outline)
    u, v, nu, nv = room.outline[0], room.outline[1], room.outline[2], room.outline[3]
    outer, inner = room.at[0], room.at[1]
    out_px, in_px = beside(s, k, depth, view, limits)
    for i in range(len(u)):
        outer[i] = padded_pixel(u[i] + out_px * nu[i], v[i] + out_px * nv[i], view)
        inner[i] = padded_pixel(u[i] - in_px * nu[i], v[i] - in_px * nv[i], view)
    if s.has_meets[k]:
        find_inner(s, k, A, b, view, room.inner)
