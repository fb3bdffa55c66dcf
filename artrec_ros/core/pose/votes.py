"""What a label image says for or against a piece of a model.

Every pixel votes with log P(label | piece) / P(label | something else), clipped on both sides so that
no pixel can decide alone. Labels cluster, so a marker's colour just outside a marker speaks against
its outline as strongly as another colour inside: that keeps a small model out of a large blob. Unknown
pixels say little: shade and the seams between two colours make a third to a half of a real surface unknown. But
those are speckled and narrow: amid nothing but unknown pixels there is hardly ever a marker.
The votes are `VotesConfig`'s.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..base.config import VotesConfig
from ..geometry.transforms import Array
from ..image.codes import EMPTY, OUTSIDE, OWNED, UNKNOWN, Codes

Labels = tuple[int, ...]


class VoteRoles:
    """Tables of votes of pixels' codes: (roles, 256) float32. A piece has one or more labels, of which it shows one."""

    def __init__(self, config: VotesConfig, codes: Codes) -> None:
        self._config, self._codes = config, codes
        self._rows: list[Array] = []
        self._own: list[Array] = []
        self._index: dict[tuple[str, Labels, Labels], int] = {}

    @property
    def table(self) -> NDArray[np.float32]:
        return np.asarray(self._codes.votes(np.array(self._rows)), np.float32)

    @property
    def own(self) -> NDArray[np.float32]:
        """How far each code is of a piece's own class."""
        return np.asarray(self._codes.votes(np.array(self._own)), np.float32)

    def inside(self, labels: Labels) -> int:
        """Role of a point on a marker of these classes."""
        own, unknown, other = self._config.inside
        empty = self._config.inside_empty
        votes = {UNKNOWN: unknown, OWNED: unknown, EMPTY: empty, **dict.fromkeys(labels, own)}
        return self._add(("inside", labels, ()), votes, other)

    def rim(self, labels: Labels) -> int:
        """Role of a point just inside a marker's outline."""
        own, unknown, other = self._config.rim
        return self._add(("rim", labels, ()), {UNKNOWN: unknown, OWNED: 0.0, **dict.fromkeys(labels, own)}, other)

    def ring(self, labels: Labels, body: Labels) -> int:
        """Role of a point just outside a marker's outline; `body` none where the body is not declared. One of the
        marker's own class, a box of one colour, does not surround it."""
        body = tuple(label for label in body if label not in labels)
        own, unknown, other = self._config.ring_on_body if body else self._config.ring
        votes = {UNKNOWN: unknown, OWNED: 0.0, **dict.fromkeys(body, self._config.ring_body_label)}
        return self._add(("ring", labels, body), {**votes, **dict.fromkeys(labels, own)}, other)

    def body(self, body: Labels, markers: Labels) -> int:
        """Role of a point on a body's face. A body of unknown colour (none) only hides: no vote."""
        if not body:
            return self._add(("body", (), ()), {}, 0.0)
        (own, unknown, other), of_markers = self._config.body, self._config.body_marker_label
        votes = {**dict.fromkeys(markers, of_markers), UNKNOWN: unknown, OWNED: unknown, **dict.fromkeys(body, own)}
        return self._add(("body", body, markers), votes, other)

    def _add(self, key: tuple[str, Labels, Labels], votes: dict[int, float], other: float) -> int:
        if key not in self._index:
            row, own = np.full(256, other), np.zeros(256)
            row[EMPTY] = votes.get(UNKNOWN, other)
            for label, vote in votes.items():
                row[label] = vote
            row[OUTSIDE] = 0.0
            own[list(key[1])] = 1.0
            self._index[key] = len(self._rows)
            self._rows.append(row)
            self._own.append(own)
        return self._index[key]
