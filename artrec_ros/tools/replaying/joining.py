"""Where frames that were recognised in any order are put in order again. What needs an order has its place here."""

from __future__ import annotations

import dataclasses
from collections import deque
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

from ...core.memory.memory import Memory
from ...core.tracking.tracker import Tracker
from ...io.results.journal import Recognised
from ...io.sources.frames import Part


@dataclass(eq=False)
class Piece:
    """A part of a source on its way through the replay.

    :param source: number of its source. :param first: number of its first frame in the replay.
    :param after: the piece before it, of the same source; None: there is none, or nothing is handed on from it.
    :param frames: what was recognised, by place in the part. :param joined: the same in order, as it is written.
    :param memory: what the last of the frames that are recognised tells the next one.
    """

    source: int
    first: int
    part: Part
    after: Piece | None = None
    frames: dict[int, Recognised] = field(default_factory=dict)
    joined: list[Recognised] = field(default_factory=list)
    memory: Memory | None = None

    @property
    def missing(self) -> list[int]:
        return [place for place in range(len(self.joined), self.part.count) if place not in self.frames]

    @property
    def is_ready(self) -> bool:
        """Whether all is there that the first missing frame needs."""
        return self.after is None or 0 not in self.missing or not self.after.missing

    def begin(self) -> None:
        """From now on it goes on by itself."""
        if self.after is not None and 0 in self.missing:
            self.memory = self.after.memory
        self.after = None

    def add(self, place: int, frame: Recognised) -> None:
        """A frame was recognised."""
        self.frames[place], self.memory = frame, frame.memory

    @property
    def is_joined(self) -> bool:
        return len(self.joined) == self.part.count


class Join:
    """Gives frames in order, with lasting ids. Pieces are expected in the order in which they are announced."""

    def __init__(self, tracker: Tracker) -> None:
        self._tracker = tracker
        self._expected: deque[Piece] = deque()

    def expect(self, piece: Piece) -> None:
        self._expected.append(piece)

    def ready(self) -> Iterator[tuple[Piece, int, Recognised]]:
        """All frames that can go on: their piece, their number in the replay, and the frame."""
        while self._expected:
            piece = self._expected[0]
            while not piece.is_joined:
                place = len(piece.joined)
                if place not in piece.frames:
                    return
                piece.joined.append(self._in_order(piece.frames.pop(place)))
                yield piece, piece.first + place, piece.joined[-1]
            self._expected.popleft()

    def _in_order(self, frame: Recognised) -> Recognised:
        """Stages that remember: each frame passes here once, in the order of the sources."""
        if frame.result is None:
            return frame
        tracked = self._tracker.update(frame.stamp_ns, frame.result, frame.frame_id)
        return dataclasses.replace(frame, result=tracked, memory=None)


def with_known(piece: Piece, known: Mapping[int, Recognised]) -> Piece:
    """The piece with what an earlier run recognised, by number in the replay."""
    for place in range(piece.part.count):
        if piece.first + place in known:
            piece.add(place, known[piece.first + place])
    return piece
