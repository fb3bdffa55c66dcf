"""What a label image says for or against a piece of a model.

Every pixel votes with log P(label | piece) / P(label | something else), clipped on both sides so that
no pixel can decide alone. Labels cluster, so a marker's colour just outside a marker speaks against
its outline as strongly as another colour inside: that keeps a small model out of a large blob. Unknown
pixels say little: shade and the seams between two colours make a third to a half of a real surface unknown.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.label_field import OUTSIDE, OWNED, UNKNOWN

# Votes in natural-log units per pixel: (the piece's own label, unknown, anything else).
INSIDE = (4.0, -0.3, -3.5)


RIM = (2.0, -1.2, -1.5)  # just inside of a marker's outline: what keeps a model from outgrowing its blob


RING = (-4.0, 0.0, 0.3)  # just outside of a marker whose surroundings are not declared


RING_ON_BODY = (-4.0, 0.0, -1.5)


RING_BODY_LABEL = 0.6


BODY = (0.7, -0.2, -2.0)  # a third of a marker's: bodies are large, plain, and like other things


BODY_MARKER_LABEL = -1.0


class VoteRoles:
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
