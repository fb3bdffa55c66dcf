"""What is handed from frame to frame: a value, which is the same wherever it was made, and small."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..geometry.camera import Camera
from ..geometry.transforms import Array, rotation_from_rotvec, rotvec_from_rotation, short_way
from ..pose.poses import Poses
from .looks import Looks


@dataclass(frozen=True, eq=False)
class Known:
    """An object of an earlier frame.

    :param R, t, q: (3, 3), (3,), (J,) its pose and joints when it was seen last, at `seen_s` of the memory's clock.
    :param turn, shift, bend: (3,), (3,), (J,) how they changed, a second.
    :param votes: for it then. :param challenged_s: when others were looked for in its place, as if it were not known.
    :param instead: by their names what other targets' object it may be instead, as far as they were looked for.
    :param unsure: whether another one of its target may be there instead: they are looked for in each frame.
    """

    R: Array
    t: Array
    q: Array
    turn: Array
    shift: Array
    bend: Array
    seen_s: float
    votes: float
    challenged_s: float
    instead: Mapping[str, Instead] = field(default_factory=dict)
    unsure: bool = False

    def at(self, now_s: float) -> Poses:
        """Where it is expected: where it was, and, where it moved, where that leads."""
        dt = now_s - self.seen_s
        R, q = rotation_from_rotvec(self.turn * dt) @ self.R, self.q + self.bend * dt
        return Poses(np.stack([self.R, R]), self.places(now_s), np.stack([self.q, q]))

    def places(self, now_s: float) -> Array:
        """(2, 3) where these are."""
        return np.stack([self.t, self.t + self.shift * (now_s - self.seen_s)])

    def then(
        self, poses: Poses, now_s: float, votes: float, challenged_s: float, endless: NDArray, steadiness: float
    ) -> Known:
        """The same object, seen again.

        :param endless: (J,) bool: joints that turn without limit. :param steadiness: what its speeds of before count.
        """
        dt = max(now_s - self.seen_s, 1e-6)
        rates = (
            (rotvec_from_rotation(poses.R[0] @ self.R.T), self.turn),
            (poses.t[0] - self.t, self.shift),
            (short_way(poses.q[0] - self.q, endless), self.bend),
        )
        turn, shift, bend = (steadiness * before + (1 - steadiness) * d / dt for d, before in rates)
        return Known(poses.R[0], poses.t[0], poses.q[0], turn, shift, bend, now_s, votes, challenged_s)

    @classmethod
    def first(cls, poses: Poses, now_s: float, votes: float) -> Known:
        """Seen for the first time: not known to move."""
        R, t, q = poses.R[0], poses.t[0], poses.q[0]
        return cls(R, t, q, np.zeros(3), np.zeros(3), np.zeros(len(q)), now_s, votes, now_s)


@dataclass(frozen=True, eq=False)
class Instead:
    """What an object may be instead: another target's, which is followed as any other.

    :param known: that one; None: it was looked for in vain. :param log_odds: that it is there, against the object.
    :param looked_s: when it was looked for in full. :param wait_s: how long after that it is again.
    :param shown: how many components the object showed then.
    """

    known: Known | None
    log_odds: float
    looked_s: float
    wait_s: float
    shown: int


@dataclass(frozen=True, eq=False)
class Memory:
    """What the frames up to one tell the next; by the objects' names.

    :param stamp_ns: of that frame. :param clock_s: the time that went by since the first one; stamps may stand still.
    :param size: (width, height) of its image.
    :param camera: the numbers of the calibration of the camera that took it; None: it is not known.
    """

    stamp_ns: int
    clock_s: float
    size: tuple[int, int]
    camera: tuple[float, ...] | None
    known: Mapping[str, tuple[Known, ...]] = field(default_factory=dict)
    looks: Mapping[str, Looks] = field(default_factory=dict)

    def holds(self, stamp_ns: int, size: tuple[int, int], camera: Camera | None) -> bool:
        """Whether it says something of a frame: a later one of the same view."""
        return stamp_ns >= self.stamp_ns and size == tuple(self.size) and numbers_of(camera) == self.camera


def numbers_of(camera: Camera | None) -> tuple[float, ...] | None:
    """Two cameras with the same ones have the same pixels for the same points."""
    return None if camera is None else (*camera.matrix.ravel().tolist(), *camera.rational.tolist())
