"""Which of the calibrations that have come is an image's: the node and a replay choose alike."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

Content = TypeVar("Content")

_KEPT = 32  # a calibration may come before its image while others still wait for theirs
_FRAMES = 16  # of which the newest one is kept


class Rank(NamedTuple):
    """How well a calibration goes with an image; the more, the better.

    :param fits: it is of the image's camera, as far as both say whose they are. :param own: it has the image's stamp.
    """

    fits: bool
    own: bool


BEST = Rank(True, True)


@dataclass(frozen=True)
class Info(Generic[Content]):
    """A calibration, and whose it is by its header."""

    stamp_ns: int
    frame_id: str
    content: Content

    def rank(self, stamp_ns: int, frame_id: str) -> Rank:
        """:param stamp_ns, frame_id: of the image's header."""
        return Rank(not (self.frame_id and frame_id) or self.frame_id == frame_id, self.stamp_ns == stamp_ns)


class Infos(Generic[Content]):
    """The last calibrations, and of each camera the newest: another one on the topic may send more of them."""

    def __init__(self) -> None:
        self._last: deque[Info[Content]] = deque(maxlen=_KEPT)
        self._newest: dict[str, Info[Content]] = {}

    def add(self, info: Info[Content]) -> None:
        self._last.append(info)
        self._newest.pop(info.frame_id, None)  # what is renewed goes to the end
        self._newest[info.frame_id] = info
        if len(self._newest) > _FRAMES:
            del self._newest[next(iter(self._newest))]

    def choose(self, stamp_ns: int, frame_id: str) -> Info[Content] | None:
        """The image's own: of its camera before others', of its stamp before the newest. None: there is none at all."""
        return max(self._from_new_to_old(), key=lambda info: info.rank(stamp_ns, frame_id), default=None)

    def newest(self, frame_id: str) -> Info[Content] | None:
        """The last one of a camera."""
        return self._newest.get(frame_id)

    def _from_new_to_old(self) -> Iterator[Info[Content]]:
        yield from reversed(self._last)
        yield from reversed(self._newest.values())


def of_another(info_frame: str, image_frame: str, topic: str) -> str:
    """What users read where there are only calibrations of another camera."""
    return (
        f"{topic} is of frame '{info_frame}', images are of '{image_frame}': it is used, though it may be another "
        "camera's; take the camera_info of these images' camera, one node for each camera"
    )
