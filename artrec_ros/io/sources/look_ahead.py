"""Which calibration of a bag is which image's, also where it was recorded after it."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Generic

from ..bags.heads import head_of
from ..bags.infos import BEST, Content, Info, Infos
from ..bags.recovery import RawMessage
from ..bags.topics import IMAGE_TYPES, INFO_TYPE

AHEAD_NS = 10**9  # of recording: drivers send an image and its calibration together, but a recorder is behind at times
_MOST_HELD = 16  # images: half a second of a camera's; they are in memory


@dataclass
class Held(Generic[Content]):
    """An image, and the best calibration for it so far."""

    message: RawMessage
    stamp_ns: int
    frame_id: str
    info: Info[Content] | None

    @property
    def is_settled(self) -> bool:
        return self.info is not None and self.info.rank(self.stamp_ns, self.frame_id) == BEST


class LookAhead(Generic[Content]):
    """Holds images back until the calibration of their own stamp has come, or too much has come without it."""

    def __init__(self) -> None:
        self._infos: Infos[Content] = Infos()
        self._held: deque[Held[Content]] = deque()

    def add_info(self, info: Info[Content], log_ns: int) -> Iterator[Held[Content]]:
        """Images that need not wait any longer. :param log_ns: when it was recorded."""
        self._infos.add(info)
        for held in self._held:
            mine = held.stamp_ns, held.frame_id
            if held.info is None or info.rank(*mine) > held.info.rank(*mine):
                held.info = info
        yield from self._ready(log_ns)

    def add_image(self, message: RawMessage, stamp_ns: int, frame_id: str) -> Iterator[Held[Content]]:
        """The same."""
        self._infos.meet(stamp_ns, frame_id)
        self._held.append(Held(message, stamp_ns, frame_id, self._infos.choose(stamp_ns, frame_id)))
        yield from self._ready(message.log_ns)

    def rest(self) -> Iterator[Held[Content]]:
        """Those that still wait, at the end."""
        yield from self._held
        self._held.clear()

    def _ready(self, log_ns: int) -> Iterator[Held[Content]]:
        """In their order: one that waits keeps those behind it waiting."""
        while self._held:
            first = self._held[0]
            waits = len(self._held) <= _MOST_HELD and log_ns - first.message.log_ns <= AHEAD_NS
            if waits and not first.is_settled:
                return
            yield self._held.popleft()


def own_first(messages: Iterable[RawMessage], infos: Iterable[RawMessage]) -> Iterator[RawMessage]:
    """Messages of ROS 2 as they were recorded, but each image behind the calibrations of its own stamp.

    :param infos: the calibrations alone, which are read ahead. One that goes before an image has its time of recording.
    """
    coming: dict[RawMessage, Info[RawMessage]] = {}  # read ahead, not sent yet
    sent: set[RawMessage] = set()  # before their time
    rest = iter(infos)
    read = next(rest, None)
    for message in messages:
        while read is not None and read.log_ns <= message.log_ns + AHEAD_NS:
            head = head_of(read.data, read.log_ns)
            coming[read] = Info(head.stamp_ns, head.frame_id, read)
            read = next(rest, None)
        if message.msgtype == INFO_TYPE:
            coming.pop(message, None)
            if message in sent:
                sent.remove(message)
                continue
        elif message.msgtype in IMAGE_TYPES:
            head = head_of(message.data, message.log_ns)
            for info in [i.content for i in coming.values() if i.rank(head.stamp_ns, head.frame_id) == BEST]:
                yield info._replace(log_ns=message.log_ns)
                del coming[info]
                sent.add(info)
        yield message
