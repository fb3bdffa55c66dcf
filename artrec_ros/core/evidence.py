"""What a label image says for or against a piece of a model.

Every pixel votes with log P(label | piece) / P(label | something else), clipped on both sides so that
no pixel can decide alone. Labels cluster, so a marker's colour just outside a marker speaks against
its outline as strongly as another colour inside: that keeps a small model out of a large blob. Unknown
pixels say little: shade and the seams between two colours make a third to a half of a real surface unknown.
"""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy

import cv2
import numpy as np
from numpy.typing import NDArray

from .compiled.seams import gaps_px
from .transforms import Array

OUTSIDE = 255  # the label of what lies beyond the image: says nothing
OWNED = 254  # the label of pixels that an accepted object explains: says next to nothing
UNKNOWN = 0
_SUBPIXEL_BITS = 4

# Votes in natural-log units per pixel: (the piece's own label, unknown, anything else).
INSIDE = (4.0, -0.3, -3.5)
RIM = (2.0, -1.2, -1.5)  # just inside of a marker's outline: what keeps a model from outgrowing its blob
RING = (-4.0, 0.0, 0.3)  # just outside of a marker whose surroundings are not declared
RING_ON_BODY = (-4.0, 0.0, -1.5)
RING_BODY_LABEL = 0.6
BODY = (0.7, -0.2, -2.0)  # a third of a marker's: bodies are large, plain, and like other things
BODY_MARKER_LABEL = -1.0
SEAM_REACH_PX = 4.0
SEAM_PIXELS = 6000  # of a class that are looked at
SEAM_SHARE = 0.2  # of a class' border must have another known class in reach

_GOLDEN = (np.sqrt(5) - 1) / 2
_REACH = int(np.ceil(SEAM_REACH_PX))
_AROUND = np.mgrid[-_REACH : _REACH + 1, -_REACH : _REACH + 1].reshape(2, -1)
_ROWS, _COLUMNS = _AROUND[:, np.argsort(np.hypot(*_AROUND), kind="stable")]  # around a pixel, nearest first
_GAPS_PX = np.hypot(_ROWS, _COLUMNS) - 1.0  # between the pixel and one so far off


class Roles:
    """Tables of votes: (roles, 256) float32."""

    def __init__(self) -> None:
        self._rows: list[Array] = []
        self._index: dict[tuple[str, int, int], int] = {}

    @property
    def table(self) -> NDArray[np.float32]:
        return np.array(self._rows, np.float32)

    def inside(self, label: int) -> int:
        """Role of a point on a marker of this class."""
        return self._add(("inside", label, 0), {label: INSIDE[0], UNKNOWN: INSIDE[1], OWNED: INSIDE[1]}, INSIDE[2])

    def rim(self, label: int) -> int:
        """Role of a point just inside a marker's outline."""
        return self._add(("rim", label, 0), {label: RIM[0], UNKNOWN: RIM[1], OWNED: 0.0}, RIM[2])

    def ring(self, label: int, body_label: int) -> int:
        """Role of a point just outside a marker's outline; `body_label` 0 where the body is not declared."""
        own, unknown, other = RING_ON_BODY if body_label else RING
        votes = {UNKNOWN: unknown, OWNED: 0.0}
        if body_label:
            votes[body_label] = RING_BODY_LABEL
        return self._add(("ring", label, body_label), {**votes, label: own}, other)

    def body(self, body_label: int, marker_label: int) -> int:
        """Role of a point on a body's face. A body of unknown colour (0) only hides: no vote."""
        if not body_label:
            return self._add(("body", 0, 0), {}, 0.0)
        votes = {marker_label: BODY_MARKER_LABEL, UNKNOWN: BODY[1], OWNED: BODY[1], body_label: BODY[0]}
        return self._add(("body", body_label, marker_label), votes, BODY[2])

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
    """A label image that answers for any pixel, the ones beyond its border included.

    :param labels: (H, W) class numbers.
    """

    def __init__(self, labels: NDArray[np.uint8]) -> None:
        self.labels = labels
        self._seams: dict[int, float] = {}
        self.padded = cv2.copyMakeBorder(labels, 1, 1, 1, 1, cv2.BORDER_CONSTANT, value=OUTSIDE).ravel()

    def at(self, pixels: Array) -> NDArray[np.uint8]:
        """Labels (...,) at the nearest pixels to (..., 2); OUTSIDE beyond the image."""
        height, width = self.labels.shape
        place = np.clip(np.floor(pixels + 0.5), -1, (width, height)).astype(np.int32)
        return self.padded[(place[..., 1] + 1) * (width + 2) + place[..., 0] + 1]

    def owned_share(self, contour: Array) -> float:
        """Share of a blob's contour (n, 2) that lies on pixels which somebody owns."""
        return float(np.mean(self.at(contour) == OWNED))

    def seam_px(self, label: int) -> float:
        """Half the width of the seam of unknown pixels that the segmenter leaves around a class; 0 without one.

        Measured where another known class follows within SEAM_REACH_PX of the class' border.
        """
        if label not in self._seams:
            gap = self._gaps_px(label)
            near = gap[gap < SEAM_REACH_PX]
            enough = len(near) > SEAM_SHARE * len(gap)
            self._seams[label] = float(np.median(near)) / 2 if enough else 0.0
        return self._seams[label]

    def _gaps_px(self, label: int) -> Array:
        """From border pixels of a class, but for those within SEAM_REACH_PX of the image's border, to the next pixel
        of another known class, itself not counted; inf: far."""
        silent = np.zeros(256, bool)
        silent[[UNKNOWN, OWNED, OUTSIDE, label]] = True
        (height, width), mine = self.labels.shape, np.flatnonzero(self.labels == label)
        if len(mine) > SEAM_PIXELS:  # a regular step could keep pace with the rows and miss a side
            mine = mine[(np.arange(SEAM_PIXELS) * _GOLDEN % 1 * len(mine)).astype(int)]
        gaps, looks = np.empty(len(mine)), (_ROWS, _COLUMNS, _GAPS_PX)
        return gaps[: gaps_px(self.padded, width, height, _REACH, mine, label, silent, *looks, gaps)]

    def without(self, solids: Sequence[NDArray[np.float32]]) -> LabelField:
        """The same image with the pixels in convex hulls of points (n, 2) owned by somebody."""
        height, width = self.labels.shape
        bordered, far = self.padded.reshape(height + 2, width + 2).copy(), 4 * max(height, width)
        labels = bordered[1:-1, 1:-1]
        for corners in solids:
            fine = np.rint(np.clip(corners, -far, far) * (1 << _SUBPIXEL_BITS)).astype(np.int32)
            cv2.fillConvexPoly(labels, cv2.convexHull(fine), OWNED, shift=_SUBPIXEL_BITS)
        rest = copy(self)  # with its seams, which are the segmenter's, not the objects'
        rest.labels, rest.padded = labels, bordered.ravel()
        return rest
