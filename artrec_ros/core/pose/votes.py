"""What a label image says for or against a piece of a model.

Every pixel votes with log P(label | piece) / P(label | something else), clipped on both sides so that
no pixel can decide alone. Labels cluster, so a marker's colour just outside a marker speaks against
its outline as strongly as another colour inside: that keeps a small model out of a large blob. Unknown
pixels say little: shade and the seams between two colours make a third to a half of a real surface unknown.
The votes are `VotesConfig`'s.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..base.config import VotesConfig
from ..geometry.transforms import Array
from ..image.label_field import OUTSIDE, OWNED, UNKNOWN


class VoteRoles:
    """Tables of votes: (roles, 256) float32."""

    def __init__(self, config: VotesConfig) -> None:
        self._config = config
        self._rows: list[Array] = []
        self._index: dict[tuple[str, int, int], int] = {}

    @property
    def table(self) -> NDArray[np.float32]:
        return np.array(self._rows, np.float32)

    def inside(self, label: int) -> int:
        """Role of a point on a marker of this class."""
        own, unknown, other = self._config.inside
        return self._add(("inside", label, 0), {label: own, UNKNOWN: unknown, OWNED: unknown}, other)

    def rim(self, label: int) -> int:
        """Role of a point just inside a marker's outline."""
        own, unknown, other = self._config.rim
        return self._add(("rim", label, 0), {label: own, UNKNOWN: unknown, OWNED: 0.0}, other)

    def ring(self, label: int, body_label: int) -> int:
        """Role of a point just outside a marker's outline; `body_label` 0 where the body is not declared."""
        own, unknown, other = self._config.ring_on_body if body_label else self._config.ring
        votes = {UNKNOWN: unknown, OWNED: 0.0}
        if body_label:
            votes[body_label] = self._config.ring_body_label
        return self._add(("ring", label, body_label), {**votes, label: own}, other)

    def body(self, body_label: int, marker_label: int) -> int:
        """Role of a point on a body's face. A body of unknown colour (0) only hides: no vote."""
        if not body_label:
            return self._add(("body", 0, 0), {}, 0.0)
        (own, unknown, other), of_markers = self._config.body, self._config.body_marker_label
        votes = {marker_label: of_markers, UNKNOWN: unknown, OWNED: unknown, body_label: own}
        return self._add(("body", body_label, marker_label), votes, other)

    def _add(self, key: tuple[str, int, int], votes: dict[int, float], other: float) -> int:
        if key not in self._index:
            row = np.full(256, other)
            for label, vote in votes.items():
                row[label] = vote
            row[OUTSIDE] = 0.0
            self._index[key] = len(self._rows)
            self._rows.append(row)
        return self._index[key]
