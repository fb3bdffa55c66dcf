"""What a label image says for or against a piece of a model.

Every pixel votes with log P(label | piece) / P(label | something else), clipped on both sides so that
no pixel can decide alone. Labels cluster, so a marker's colour just outside a marker speaks against
its outline as strongly as its absence inside: that keeps a small model out of a large blob.
"""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from .transforms import Array

OUTSIDE = 255  # the label of what lies beyond the image: says nothing
OWNED = 254  # the label of pixels that an accepted object explains: says next to nothing
UNKNOWN = 0


class Roles:
    """Tables of votes: (roles, 256) float32, natural-log units per pixel."""

    def __init__(self) -> None:
        self._rows: list[Array] = []
        self._index: dict[tuple[str, int, int], int] = {}

    @property
    def table(self) -> NDArray[np.float32]:
        return np.array(self._rows, np.float32)

    def inside(self, label: int) -> int:
        """Role of a point on a marker of this class."""
        return self._add(("inside", label, 0), {label: 4.0, UNKNOWN: -0.5, OWNED: -0.5}, -3.5)

    def ring(self, label: int, body_label: int) -> int:
        """Role of a point just outside a marker's outline; `body_label` 0 where the body is not declared."""
        votes = {label: -2.5, UNKNOWN: 0.3, OWNED: 0.0}
        if body_label:
            votes[body_label] = 0.7
        return self._add(("ring", label, body_label), votes, -1.0 if body_label else 0.3)

    def body(self, label: int, marker_label: int) -> int:
        """Role of a point on a body's face."""
        return self._add(("body", label, marker_label), {label: 1.2, UNKNOWN: -0.25, OWNED: -0.2, marker_label: -1.0}, -1.3)

    def _add(self, key: tuple[str, int, int], votes: dict[int, float], other: float) -> int:
        if key not in self._index:
            row = np.full(256, other)
            for label, vote in votes.items():
                row[label] = vote
            row[OUTSIDE] = 0.0
            self._index[key] = len(self._rows)
            self._rows.append(row)
        return self._index[key]


class LabelField:
    """A frame's labels and, per class, the signed distance to its boundary."""

    def __init__(self, labels: NDArray[np.uint8]) -> None:
        self.labels = labels
        self._padded = cv2.copyMakeBorder(labels, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=OUTSIDE)
        self._distance: dict[int, Array] = {}

    @property
    def shape(self) -> tuple[int, int]:
        return self.labels.shape  # type: ignore[return-value]

    def at(self, pixels: Array) -> NDArray[np.uint8]:
        """Labels (...,) at the nearest pixels to (..., 2); OUTSIDE beyond the image."""
        height, width = self.shape
        x = np.clip(np.rint(pixels[..., 0]), -1, width).astype(np.int32) + 1
        y = np.clip(np.rint(pixels[..., 1]), -1, height).astype(np.int32) + 1
        return self._padded.ravel()[y * (width + 2) + x]

    def distance(self, label: int, pixels: Array) -> Array:
        """(..., 3): signed distance to the class' boundary (negative inside), and its gradient (x, y)."""
        if label not in self._distance:
            self._distance[label] = _signed_distance(self.labels == label)
        shape = pixels.shape[:-1]
        flat = pixels.reshape(-1, 2)
        columns = 1 << 14  # cv2.remap takes images up to 32767 wide
        rows = -(-len(flat) // columns)
        grid = np.full((rows * columns, 2), -1e3, np.float32)
        grid[: len(flat)] = np.clip(flat, -1e3, 1e5)
        maps = grid.reshape(rows, columns, 2)
        out = cv2.remap(self._distance[label], maps, None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_CONSTANT, borderValue=(99, 0, 0))
        return out.reshape(-1, 3)[: len(flat)].reshape(*shape, 3).astype(float)


def _signed_distance(mask: NDArray[np.bool_]) -> NDArray[np.float32]:
    """(H, W, 3) float32: signed distance in pixels and its gradient. Specks vanish by a 3x3 median first."""
    m = cv2.medianBlur(mask.astype(np.uint8), 3)
    if not m.any():
        return np.dstack([np.full(m.shape, 99, np.float32), np.zeros((*m.shape, 2), np.float32)])
    outside = cv2.distanceTransform(1 - m, cv2.DIST_L2, 5)
    inside = cv2.distanceTransform(m, cv2.DIST_L2, 5)
    # a pixel next to the boundary lies half a pixel from it
    d = np.where(m > 0, 0.5 - inside, outside - 0.5).astype(np.float32)
    smooth = cv2.GaussianBlur(d, (3, 3), 0.8)
    return np.dstack([d, cv2.Sobel(smooth, cv2.CV_32F, 1, 0, scale=1 / 8), cv2.Sobel(smooth, cv2.CV_32F, 0, 1, scale=1 / 8)])
