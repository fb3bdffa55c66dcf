"""Which of two mirrored turns an object has, by all frames that have shown it.

A frame tells of a distant or single flat marker hardly more than that it is turned one way or the other. An object
does not leap from one to the other, so what frames say adds up; but they err alike where little has changed between
them: light, blur and its own shape are the same. The sum counts as so many independent frames as errors that
correlate leave of them, and what was long ago fades.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base.config import SightingsConfig, TrackingConfig
from ..geometry.transforms import Array, Pose, rotvec_from_rotation
from ..model.found import Detection, OtherTurn

_DEVIATIONS = 3.0  # an object that has turned further than by so many is another, or has been put down anew


@dataclass(frozen=True)
class Turns:
    """What frames say of T tracks' last turns, against the mirrored ones.

    :param total: (T,) sum of the log odds of frames. :param frames: (T,) how many these were, less what has faded.
    """

    total: Array
    frames: Array

    def __getitem__(self, rows: Any) -> Turns:
        return Turns(self.total[rows], self.frames[rows])

    @classmethod
    def joined(cls, parts: Sequence[Turns]) -> Turns:
        return cls(np.concatenate([p.total for p in parts]), np.concatenate([p.frames for p in parts]))

    @classmethod
    def of(cls, found: Sequence[Detection], config: SightingsConfig) -> Turns:
        """By one frame."""
        return cls(np.array([_odds(d, config) for d in found], float), np.ones(len(found)))

    def after(self, dt_s: float, config: SightingsConfig) -> Turns:
        left = float(np.exp(-dt_s / config.turn_memory_s))
        return Turns(self.total * left, self.frames * left)

    def seen(
        self,
        found: Sequence[Detection],
        row_of: Mapping[int, int],
        last: Sequence[Detection],
        age_s: Array,
        config: TrackingConfig,
    ) -> tuple[Turns, dict[int, Detection]]:
        """By another frame; and those detections that have the other one of their two turns by all frames together, or
        another probability of it.

        :param last: (T,) as each was told last. :param age_s: (T,) since then.
        """
        total, frames, told = self.total.copy(), self.frames.copy(), dict[int, Detection]()
        for n, row in row_of.items():
            sign = _same_turn(found[n], last[row], float(age_s[row]), config)
            if sign == 0:  # what was before says nothing of it
                total[row] = frames[row] = 0.0
            odds = _odds(found[n], config.sightings)
            total[row], frames[row] = total[row] + (sign or 1) * odds, frames[row] + 1
            by_all = combined(total[row], frames[row], config.sightings.turn_correlation)
            total[row] = abs(total[row])
            if found[n].other_turn is not None and sign:
                told[n] = _turned(found[n], sign * by_all)
        return Turns(total, frames), told


def combined(total: float, frames: float, correlation: float) -> float:
    """Log odds by several frames whose errors correlate. :param total: the sum of theirs."""
    return total / (1 + max(frames - 1, 0.0) * correlation)


def _odds(d: Detection, config: SightingsConfig) -> float:
    """Log odds of the turn that is told, by this frame alone."""
    if d.other_turn is None:
        return config.turn_odds
    return min(float(np.log(1 / d.other_turn.probability - 1)), config.turn_odds)


def _same_turn(d: Detection, last: Detection, age_s: float, config: TrackingConfig) -> int:
    """1: it goes on from the turn that was told last; -1: its other turn does; 0: none does."""
    if d.pose is None or last.pose is None or {d.pose_from, last.pose_from} != {"fit"}:
        return 0
    candidates = [d.pose, *([d.other_turn.pose] if d.other_turn else [])]
    angles = [_angle(pose, last.pose) for pose in candidates]
    most = _DEVIATIONS * np.hypot(config.turn_rate * age_s, config.sightings.turn_rad)
    nearest = int(np.argmin(angles))
    return 0 if angles[nearest] > most else 1 - 2 * nearest


def _turned(d: Detection, odds: float) -> Detection:
    """With the likelier one of two turns. :param odds: logarithm of those of the one that is told."""
    pose, other = d.pose, d.other_turn
    assert other is not None and pose is not None and d.pose_covariance is not None
    probability = float(1 / (1 + np.exp(abs(odds))))
    more = (probability - other.probability) * other.spread(pose)  # the same, whichever of both is told
    d = replace(d, pose_covariance=d.pose_covariance + more, other_turn=replace(other, probability=probability))
    if odds >= 0:
        return d
    told = OtherTurn(pose, probability, d.joints)
    return replace(d, pose=other.pose, joints={**d.joints, **other.joints}, other_turn=told)


def _angle(a: Pose, b: Pose) -> float:
    return float(np.linalg.norm(rotvec_from_rotation(a.rotation @ b.rotation.T)))
