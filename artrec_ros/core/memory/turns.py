"""When each blob is searched: a new one at once, one that was searched before when its turn comes."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from ..base.config import RecallConfig
from ..geometry.transforms import Array
from ..image.blobs import Blob
from .looks import Looks

_SOON_S = 1e-6  # less than passes between two frames


class Turns:
    """Of the blobs of one frame in which an object of one name may be.

    :param before: blobs of the frame before. :param now_s, passed_s: the memory's clock, and since that frame.
    :param refresh_s: each is searched again within this time.
    """

    def __init__(
        self,
        blobs: Sequence[Blob],
        before: Looks,
        now_s: float,
        passed_s: float,
        refresh_s: float,
        config: RecallConfig,
    ) -> None:
        self._blobs = blobs
        self._number = {id(blob): n for n, blob in enumerate(blobs)}
        self._now, self._now_s = Looks.of(blobs, now_s), now_s
        self._same = before.same(self._now, config)
        self._before = before
        self._moves = self._same < 0
        self._retry_s, self._refresh_s = min(config.retry_s, refresh_s), refresh_s
        little = np.array([blob.area_px < config.little_px for blob in blobs], bool)
        self._little = little
        self._vain_s = np.where(little, refresh_s, self._retry_s)
        self._wait_s = self._vain_s.copy()  # if it is searched now, and in vain
        self._at_s, wait_s = np.full(len(blobs), -np.inf), np.full(len(blobs), refresh_s)
        old = np.flatnonzero(self._same >= 0)
        were = before[self._same[old]]
        self._at_s[old] = were.at_s
        self._moves[old] = (np.abs(self._now[old].box - were.box)[:, :2] > config.grown_px).any(axis=1)
        grown = were.grown(self._now[old], config) & ~little[old]
        wait_s[old] = np.where(grown, np.minimum(were.wait_s, self._retry_s), were.wait_s)
        again_s = np.minimum(np.maximum(2 * were.wait_s, self._vain_s[old]), refresh_s)
        self._wait_s[old] = np.where(grown, self._retry_s, again_s)
        self._waiting = set(old.tolist()) - due(now_s - self._at_s, wait_s, passed_s)
        self._searched, self._explained = set[int](), set[int]()

    def forget(self) -> None:
        """All blobs are new."""
        self._moves[:] = True
        self._same[:] = -1
        self._wait_s[:] = self._vain_s
        self._waiting = set()

    def number(self, blob: Blob) -> int:
        return self._number[id(blob)]

    def waits(self, blob: Blob) -> bool:
        """Whether it was searched before, and its turn has not come; of a blob in which no such object may be: no."""
        return self._number.get(id(blob)) in self._waiting

    def search(self, blob: Blob) -> None:
        """It is searched now. Where that is in vain it is searched again soon, and then ever later."""
        self._searched.add(self.number(blob))

    def put_off(self, blob: Blob) -> None:
        """Its search did not come to an end: it is its turn again in the next frame, and it counts from when it was."""
        number = self.number(blob)
        self._wait_s[number] = _SOON_S
        self._now.at_s[number] = self._now_s - self.age_s(blob)

    def leave(self, blob: Blob) -> None:
        """It waits for another frame, though its turn has come."""
        self._waiting.add(self.number(blob))

    def age_s(self, blob: Blob) -> float:
        """Since a blob was searched in full; 0 of a new one."""
        at_s = float(self._at_s[self.number(blob)])
        return self._now_s - at_s if np.isfinite(at_s) else 0.0

    def is_new(self, blob: Blob) -> bool:
        """Whether the frame before did not show it."""
        return bool(self._same[self.number(blob)] < 0)

    def is_searched(self, blob: Blob) -> bool:
        return self.number(blob) in self._searched

    def explain(self, blob: Blob) -> None:
        """What was searched now, or before, was not in vain."""
        self._explained.add(self.number(blob))
        self._wait_s[self.number(blob)] = self._refresh_s

    def largest(self, labels: Collection[int], places: Array, radius_px: Array) -> Blob | None:
        """The largest blob of some classes in some discs, of middles (n, 2) and radii (n,) pixels."""
        mine = np.isin(self._now.label, list(labels))
        inside = np.flatnonzero(mine & self._inside(places, radius_px).any(axis=1))
        return self._blobs[int(inside[self._now.least[inside, 2].argmax()])] if len(inside) else None

    def doubt(self, places: Array, radius_px: Array) -> None:
        """What blobs within some discs show is almost an object: those that move from frame to frame do not wait."""
        there = np.flatnonzero(self._inside(places, radius_px).any(axis=1) & self._moves)
        in_vain = [n for n in there.tolist() if n not in self._explained and not self._little[n]]
        self._wait_s[in_vain] = _SOON_S

    def hurry(self, places: Array, radius_px: Array, seen_s: float) -> None:
        """Blobs within some discs do not wait any longer: what they showed is gone. Those that were searched since that
        was seen last, at `seen_s`, were searched for it already."""
        there = np.flatnonzero(self._inside(places, radius_px).any(axis=1) & (self._at_s <= seen_s))
        self._wait_s[there] = self._retry_s
        self._waiting -= set(there.tolist())

    def _inside(self, places: Array, radius_px: Array) -> np.ndarray:
        """(N, n) which blobs have their middles in which discs."""
        return np.asarray(np.linalg.norm(self._now.box[:, None, :2] - places, axis=2) < radius_px)

    def left(self) -> Looks:
        """For the next frame: blobs that were searched now, and those of before that are still there."""
        new = np.array(sorted(self._searched), int)
        old = np.array([n for n in np.flatnonzero(self._same >= 0).tolist() if n not in self._searched], int)
        searched, waiting = self._now[new].waiting(self._wait_s[new]), self._before[self._same[old]]
        return Looks.joined([searched, waiting.moved_to(self._now[old])])


def due(age_s: Array, wait_s: Array, passed_s: float) -> set[int]:
    """Those that are searched again: all that would be too late the next time, and, where there is nothing new to look
    at, of those that waited half their time the oldest, so many that turns spread out.

    :param age_s: since each was searched; inf: it was not. :param wait_s: how long each is to wait.
    """
    known = np.flatnonzero(np.isfinite(age_s))
    order = known[np.argsort(-(age_s / wait_s)[known], kind="stable")]
    late = order[age_s[order] + passed_s > wait_s[order]]
    share = int(np.ceil(np.minimum(passed_s / (wait_s[known] / 2), 1).sum()))
    early = order[age_s[order] > wait_s[order] / 2][: share if len(known) == len(age_s) else 0]
    return set(late.tolist()) | set(early.tolist())
