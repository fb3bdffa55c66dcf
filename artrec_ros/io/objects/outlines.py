"""Outlines of markers: checks of polygons, discs, and silhouettes taken from images."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import cv2
import numpy as np

from ...core.base.errors import ConfigError, ImageError
from ...core.geometry.transforms import Array
from ..base.yaml_files import read_bytes
from ..images.decoding import decode_file

_DISC_POINTS = 64  # the inscribed polygon then misses 0.16 % of the disc's area
_EDGE_SIGMA_PX = 1.0  # blur under which the staircase of a binary image becomes a straight edge
_SIMPLIFY_PX = 0.2  # the silhouette's polygon may leave the edge by this much
_GREATEST_SIDE_PX = 1500  # a larger image is shrunk: its outline has more detail than a camera will see
_LEAST_AREA_PX = 30  # a smaller silhouette has no shape


def crossing_edges(outline: Array) -> tuple[int, int] | None:
    """The first two edges of a closed polygon that meet without being neighbours; edge i starts at point i.

    :param outline: (n, 2).
    """
    n = len(outline)
    start, end = outline, np.roll(outline, -1, axis=0)
    low, high = np.minimum(start, end), np.maximum(start, end)

    def side(i: Any, p: Array) -> Array:  # > 0: p lies to the left of edge i; zero: on its line
        d, v = end[i] - start[i], p - start[i]
        cross = d[..., 0] * v[..., 1] - d[..., 1] * v[..., 0]
        size = np.linalg.norm(d, axis=-1) * np.linalg.norm(v, axis=-1)
        return np.where(np.abs(cross) <= 1e-12 * size, 0.0, np.sign(cross))

    for i in range(n - 2):
        others = slice(i + 2, n - 1 if i == 0 else n)  # neighbours share a point by right
        near = (high[i, 0] >= low[others, 0]) & (low[i, 0] <= high[others, 0])
        near &= (high[i, 1] >= low[others, 1]) & (low[i, 1] <= high[others, 1])
        j = i + 2 + np.flatnonzero(near)
        if not j.size:
            continue
        apart = (side(i, start[j]) * side(i, end[j]) > 0) | (side(j, start[i]) * side(j, end[i]) > 0)
        if not apart.all():
            return i, int(j[~apart][0])
    return None


def folded_corner(outline: Array) -> int | None:
    """The first corner where a closed polygon repeats a point or turns straight back on itself."""
    d = np.roll(outline, -1, axis=0) - outline  # (n, 2) edges
    before = np.roll(d, 1, axis=0)
    length = np.linalg.norm(d, axis=1)
    cross = before[:, 0] * d[:, 1] - before[:, 1] * d[:, 0]
    back = (np.abs(cross) <= 1e-12 * length * np.roll(length, 1)) & (np.sum(before * d, axis=1) < 0)
    bad = np.flatnonzero((length < 1e-9) | back)
    return int(bad[0]) if bad.size else None


def disc_outline(radius_m: float) -> Array:
    """(64, 2) regular polygon about the origin."""
    angle = np.arange(_DISC_POINTS) * (2 * np.pi / _DISC_POINTS)
    return radius_m * np.stack([np.cos(angle), np.sin(angle)], axis=1)


def default_axis(outline: Array) -> tuple[Array, Array]:
    """The middle line of the bounding box along its longer side, left to right or bottom to top."""
    low, high = outline.min(axis=0), outline.max(axis=0)
    middle, half = (low + high) / 2, (high - low) / 2
    along = half * ((1, 0) if half[0] >= half[1] else (0, 1))
    return middle - along, middle + along


def silhouette_outline(path: Path, width_m: float) -> Array:
    """(n, 2) outline of the largest shape in an image: x right, y up, origin at the centre of its bounding box.

    The shape may be dark on bright or bright on dark (the image's border is background), or opaque on transparent.

    :param width_m: width of the shape's bounding box, metres.
    """
    contour = subpixel_contour(_shape_level(path), path)
    low, high = contour.min(axis=0), contour.max(axis=0)
    return (contour - (low + high) / 2) * (1, -1) * (width_m / (high[0] - low[0]))


def _shape_level(path: Path) -> Array:
    """(H, W) 0 on the background, 1 on the shape, between them on a soft edge."""
    try:
        image = decode_file(read_bytes(path))
    except ImageError as error:
        raise ConfigError(f"{path}: cannot be read as an image: {error}") from None
    shrink = _GREATEST_SIDE_PX / max(image.shape[:2])
    if shrink < 1:
        image = cv2.resize(image, None, fx=shrink, fy=shrink, interpolation=cv2.INTER_AREA)
    grey = image.astype(np.float32)
    if grey.ndim == 3:
        transparent = grey.shape[2] == 4 and bool(np.ptp(grey[:, :, 3]))
        grey = grey[:, :, 3] if transparent else grey[:, :, :3].mean(axis=2)
    border = np.concatenate([grey[0], grey[-1], grey[:, 0], grey[:, -1]])
    background = float(np.median(border))
    distance = np.abs(grey - background)
    if distance.max() == 0:
        raise ConfigError(f"{path}: the image has one colour only; a shape on a plain background is wanted")
    foreground = float(np.median(distance[distance > distance.max() / 2]))
    return np.clip(distance / foreground, 0, 1)


def subpixel_contour(level: Array, path: Path) -> Array:
    """(n, 2) line where the blurred `level` is one half, around the largest region; pixels, centres at integers."""
    pad = 4  # a shape may touch the image's border
    level = np.pad(level, pad).astype(np.float32)
    mask = (level > 0.5).astype(np.uint8)
    contours = cv2.findContours(mask, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)[0]
    largest = max(contours, key=cv2.contourArea)
    if cv2.contourArea(largest) < _LEAST_AREA_PX:
        raise ConfigError(f"{path}: the largest shape has fewer than {_LEAST_AREA_PX} pixels; give a larger image")
    alone = cv2.drawContours(np.zeros_like(mask), [largest], -1, 1, cv2.FILLED)
    alone = cv2.dilate(alone, np.ones((3, 3), np.uint8))  # keep the soft edge, drop other shapes
    smooth = cv2.GaussianBlur(level * alone, (0, 0), _EDGE_SIGMA_PX)
    slope = [cv2.Sobel(smooth, cv2.CV_32F, dx, 1 - dx, scale=1 / 8) for dx in (1, 0)]  # per pixel
    points = largest.reshape(-1, 2).astype(np.float32)
    for _ in range(3):  # Newton steps along the slope
        x, y = points[:, :1], points[:, 1:]
        value, sx, sy = (cv2.remap(a, x, y, cv2.INTER_LINEAR)[:, 0] for a in (smooth, *slope))
        step = (0.5 - value) / np.maximum(sx**2 + sy**2, 1e-4)
        step = np.clip(step * np.hypot(sx, sy), -0.5, 0.5) / np.maximum(np.hypot(sx, sy), 1e-2)
        points = points + (step * np.stack([sx, sy])).T.astype(np.float32)
    outline = cv2.approxPolyDP(points[:, None], _SIMPLIFY_PX, True)[:, 0]
    return outline.astype(float) - pad
