"""How long after an image the calibration of its stamp comes: by that a node knows whether to wait for it."""

from __future__ import annotations

import math
from dataclasses import dataclass
from statistics import median

from sensor_msgs.msg import CameraInfo

from ..io.bags.infos import Info

_REMEMBERED = 16  # images


@dataclass
class _Image:
    """:param late_s: how long after it that of its stamp came. :param taken: it was looked at with, if another."""

    frame_id: str
    asked_s: float
    late_s: float = math.inf
    taken: CameraInfo | None = None


class Delays:
    """Of the last images that were asked for, by their stamps. Times are a steady clock's seconds."""

    def __init__(self) -> None:
        self._images: dict[tuple[int, int], _Image] = {}
        self._run = 0  # stamps may be the same in several

    @property
    def usual_s(self) -> float:
        """The usual delay; infinite: no image is known, or most have none of their stamp."""
        return median(image.late_s for image in self._images.values()) if self._images else math.inf

    def begin_again(self) -> None:
        """Stamps went back; what was usual still is."""
        self._run += 1

    def asked(self, stamp_ns: int, frame_id: str, now_s: float, is_there: bool) -> None:
        """An image is looked at. :param is_there: the calibration of its stamp has come."""
        if (self._run, stamp_ns) in self._images:
            return
        self._images[self._run, stamp_ns] = _Image(frame_id, now_s, 0.0 if is_there else math.inf)
        if len(self._images) > _REMEMBERED:
            del self._images[next(iter(self._images))]

    def taken(self, stamp_ns: int, info: CameraInfo) -> None:
        """It was looked at with another calibration than that of its stamp."""
        if (image := self._images.get((self._run, stamp_ns))) is not None:
            image.taken = info

    def came(self, info: Info[CameraInfo], now_s: float) -> CameraInfo | None:
        """A calibration has come: the one that the image of its stamp was looked at with before, if there is such."""
        image = self._images.get((self._run, info.stamp_ns))
        if image is None or not info.rank(info.stamp_ns, image.frame_id).fits:
            return None
        image.late_s = min(image.late_s, now_s - image.asked_s)
        taken, image.taken = image.taken, None
        return taken
