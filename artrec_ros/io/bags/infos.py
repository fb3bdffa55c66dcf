"""Which of the calibrations that have come is an image's: the node and a replay choose alike."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

from ...core.base.stamps import starts_again

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
    """The last calibrations, and of each camera the newest: another one on the topic may send more of them.

    Where stamps go back, as when a bag starts again, those of the same stamps from before are no image's own any more.
    Only the newest stays, until another one comes: it may be the only one that is ever sent.
    """

    def __init__(self) -> None:
        self._last: deque[Info[Content]] = deque(maxlen=_KEPT)
        self._newest: dict[str, Info[Content]] = {}
        self._image: tuple[str, int] = "", 0  # the last one's frame and stamp

    @property
    def are_outdated(self) -> bool:
        """Whether all are from before stamps went back."""
        return not self._last

    def add(self, info: Info[Content]) -> None:
        before = self._newest.get(info.frame_id)
        if before is not None and starts_again(before.stamp_ns, info.stamp_ns):
            self._drop(info.frame_id)
        self._last.append(info)
        self._newest.pop(info.frame_id, None)  # what is renewed goes to the end
        self._newest[info.frame_id] = info
        if len(self._newest) > _FRAMES:
            del self._newest[next(iter(self._newest))]

    def meet(self, stamp_ns: int, frame_id: str) -> bool:
        """An image of this header is next. Whether its stamps went back."""
        (before_frame, before_ns), self._image = self._image, (frame_id, stamp_ns)
        is_again = frame_id == before_frame and starts_again(before_ns, stamp_ns)
        if is_again:
            for info in list(self._newest.values()):
                # calibrations whose own stamps went back have come since, however long the image waited for its turn
                if info.rank(stamp_ns, frame_id).fits and not starts_again(before_ns, info.stamp_ns):
                    self._drop(info.frame_id)
        return is_again

    def choose(self, stamp_ns: int, frame_id: str) -> Info[Content] | None:
        """The image's own: of its camera before others', of its stamp before the newest. None: there is none at all."""
        return max(self._from_new_to_old(), key=lambda info: info.rank(stamp_ns, frame_id), default=None)

    def newest(self, frame_id: str) -> Info[Content] | None:
        """The last one of a camera."""
        return self._newest.get(frame_id)

    def _drop(self, frame_id: str) -> None:
        """All of a camera but the newest one."""
        self._last = deque((info for info in self._last if info.frame_id != frame_id), _KEPT)

    def _from_new_to_old(self) -> Iterator[Info[Content]]:
        yield from reversed(self._last)
        yield from reversed(self._newest.values())


def of_another(info_frame: str, image_frame: str, topic: str) -> str:
    """What users read where there are only calibrations of another camera."""
    return (
        f"{topic} is of frame '{info_frame}', images are of '{image_frame}': it is used, though it may be another "
        "camera's; take the camera_info of these images' camera, one node for each camera"
    )
