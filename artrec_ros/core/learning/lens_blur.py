"""How blurred a camera shows edges: measured where somebody has marked what is there."""

from __future__ import annotations

from collections.abc import Iterable

import cv2
import numpy as np
from numpy.typing import NDArray

from ..base.config import LearningConfig
from ..geometry.transforms import Array

_LEARNING = LearningConfig()
_SEEN_PX = 0.7  # standard deviation of the Gaussian with which gradients are taken
# Variance of gradients of their own, pixels squared: a difference of pixels that are two apart (1/3), a pixel's extent,
# which the sharpest picture has (1/12), and a peak that lies between pixels (as much)
_OWN_PX2 = 1 / 3 + 1 / 12 + 1 / 12
_LEAST_EDGES = 30  # edge pixels: fewer have no median worth the name

Pair = tuple[NDArray[np.uint8], NDArray[np.uint8]]


def lens_blur(pairs: Iterable[Pair], ignored: int) -> float:
    """Standard deviation of the Gaussian by which a lens blurs edges near marked regions, pixels; 0 where images are as
    sharp as a good camera's, or show no edges there.

    A step that is blurred by s has its greatest gradient proportional to 1/s. Blurred once more, by a known amount, its
    ratio to the first tells s (Zhuo and Sim, Defocus map estimation from a single image, 2011). The median of the
    strongest edges: weaker ones are texture. Where patches are small their edges run into each other and look sharper;
    beyond some 2.5 pixels noise makes all edges look sharper than they are.

    :param pairs: colour images (H, W, 3) BGR and the numbers of what is marked (H, W), 0: nothing.
    :param ignored: number of what is not marked, either.
    """
    found = [edges for image, numbers in pairs if len(edges := _blurs(image, (numbers != 0) & (numbers != ignored)))]
    edges = np.concatenate(found) if found else np.zeros(0)
    blur = float(np.median(edges)) if len(edges) >= _LEAST_EDGES else 0.0
    return min(round(blur, 2), _LEARNING.most_blur_px) if blur >= _LEARNING.sharp_px else 0.0


def _blurs(image: NDArray[np.uint8], marked: NDArray[np.bool_]) -> Array:
    """(n,) the blur of each strong edge pixel in and beside marked regions."""
    width = np.sqrt(np.count_nonzero(marked) / max(cv2.connectedComponents(marked.astype(np.uint8))[0] - 1, 1))
    reach = 1 + int(_LEARNING.beside_share * width)
    near = cv2.dilate(marked.astype(np.uint8), np.ones((2 * reach + 1, 2 * reach + 1), np.uint8)) > 0
    first, along = _gradients(image, _SEEN_PX)
    second, _ = _gradients(image, np.sqrt(2) * _SEEN_PX)
    peaks = np.argwhere(near & _is_peak(first, along) & (first >= 255 * _LEARNING.least_edge))
    if not len(peaks):
        return np.zeros(0)
    once, twice = first[tuple(peaks.T)], second[tuple(peaks.T)]
    strong = once >= np.quantile(once, 1 - _LEARNING.strong_edges)
    ratio = np.square(once[strong] / np.maximum(twice[strong], 1e-6))
    seen = _SEEN_PX**2 / np.maximum(ratio - 1, 1e-3)  # of all that blurs the first gradients
    return np.asarray(np.sqrt(np.maximum(seen - _SEEN_PX**2 - _OWN_PX2, 0)))


def _gradients(image: NDArray[np.uint8], sigma_px: float) -> tuple[Array, Array]:
    """(H, W) size of the steepest channel's gradient, a pixel, and (H, W, 2) its direction x, y in whole pixels."""
    smooth = cv2.GaussianBlur(image.astype(np.float32), (0, 0), sigma_px)
    x, y = (cv2.Scharr(smooth, cv2.CV_32F, *way) / 32 for way in ((1, 0), (0, 1)))
    size = np.hypot(x, y)
    channel = size.argmax(axis=2)[..., None]
    x, y, size = (np.take_along_axis(v, channel, 2)[..., 0] for v in (x, y, size))
    return size, np.rint(np.stack((x, y), -1) / np.maximum(size, 1e-6)[..., None])


def _is_peak(size: Array, along: Array) -> NDArray[np.bool_]:
    """(H, W) whether a gradient is the greatest along its direction."""
    rows, columns = np.indices(size.shape, np.float32)
    ahead, behind = (
        cv2.remap(size, columns + way * along[..., 0], rows + way * along[..., 1], cv2.INTER_NEAREST, borderValue=0)
        for way in (np.float32(1), np.float32(-1))
    )
    return np.asarray((size >= ahead) & (size > behind))
