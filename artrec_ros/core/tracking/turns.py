"""Which of two turns an object has, by all frames that have shown it: mirrored ones in space, half a turn of what is
found flat.

A frame tells of a distant or single flat marker hardly more than that it is turned one way or the other, and of a lone
one that looks the same after half a turn not even that. An object does not leap from one to the other, so what frames
say adds up; but they err alike where little has changed between them: light, blur and its own shape are the same. The
sum counts as so many independent frames as errors that correlate leave of them, and what was long ago fades.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from ..base.config import SightingsConfig, TrackingConfig
from ..geometry.transforms import Array, Pose, rotvec_from_rotation, wrap_angle
from ..model.found import Detection, OtherPlace, OtherTurn

_LEAST_RAD2 = 1e-6  # nothing is known better than to a milliradian
_FADED = 0.5  # of what a lone part tells: what was seen before stands against it while it is more
_DEVIATIONS = 3.0  # an object that has turned further than by so many is another, or has been put down anew


@dataclass(frozen=True)
class Turns:
    """What frames say of T tracks' last turns, against the other ones.

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
        total, frames = np.array([_with(0.0, 0.0, d, config) for d in found], float).reshape(-1, 2).T
        return cls(total, frames)

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
        correlation = config.sightings.turn_correlation
        for n, row in row_of.items():
            same = _same_turn(found[n], last[row], float(age_s[row]), config)
            if same is None:  # what was before says nothing of it
                total[row] = frames[row] = 0.0
            else:
                before = combined(total[row], frames[row], correlation)
                total[row] *= handed_on(before, same) / before if before else 1.0
            total[row], frames[row] = _with(total[row], frames[row], found[n], config.sightings)
            if same is not None and _others_share(found[n]) is not None:
                by_all = combined(total[row], frames[row], correlation)
                told[n] = _turned(found[n], by_all) if found[n].other_turn else _laid(found[n], by_all)
                total[row] = abs(total[row])  # of what is told now
        return Turns(total, frames), told


def handed_on(odds: float, same: float) -> float:
    """Log odds that a turn is the true one, by those of the turn told before, and those that it is the same one."""
    return float(np.logaddexp(odds + same, 0.0) - np.logaddexp(odds, same))


def _with(total: float, frames: float, d: Detection, config: SightingsConfig) -> tuple[float, float]:
    """Sum and number with another frame. What hides the other part of a lone one hides it from one frame like from the
    next: they tell no more than one, and less than what was seen before, until that has faded; and nothing, where it
    may lie in more than two ways."""
    odds = _odds(d, config)
    if d.other_place is None or d.other_turn is not None:
        return total + odds, frames + 1
    if d.other_place.told is None:
        return total, frames
    before = combined(total, frames, config.turn_correlation)
    return (total, frames) if before > odds or before < -_FADED * odds else (odds, 1.0)


def combined(total: float, frames: float, correlation: float) -> float:
    """Log odds by several frames whose errors correlate. :param total: the sum of theirs."""
    return total / (1 + max(frames - 1, 0.0) * correlation)


def _odds(d: Detection, config: SightingsConfig) -> float:
    """Log odds of the turn that is told, by this frame alone; below 0 where the other one is likelier, but no object by
    itself."""
    share = _others_share(d)
    if share is None:
        return config.turn_odds
    least = 1 / (1 + np.exp(config.turn_odds))
    share = float(np.clip(share, least, 1 - least))
    return float(np.log(1 / share - 1))


def _others_share(d: Detection) -> float | None:
    """Probability of the other one of two turns; None where one alone is possible, or more than two are."""
    if d.other_turn is not None:
        return d.other_turn.probability
    return d.other_place.probability if d.other_place is not None and d.other_place.told is not None else None


def _same_turn(d: Detection, last: Detection, age_s: float, config: TrackingConfig) -> float | None:
    """Log odds that the turn that is told goes on from the one that was told last, and not from that one's other turn;
    None: neither does."""
    if _is_flat(d) and _is_flat(last):
        return _same_direction(d, last, age_s, config)
    if d.pose is None or last.pose is None or {d.pose_from, last.pose_from} != {"fit"}:
        return None
    other, other_last = (x.other_turn.pose if x.other_turn else None for x in (d, last))
    same = _apart([(d.pose, last.pose), (other, other_last)])
    crossed = _apart([(d.pose, other_last), (other, last.pose)])
    variance = (config.turn_rate * age_s) ** 2 + _variance(d, config) + _variance(last, config)
    if min(same, crossed) > _DEVIATIONS**2 * ((config.turn_rate * age_s) ** 2 + config.sightings.turn_rad**2):
        return None
    return (crossed - same) / (2 * max(variance, _LEAST_RAD2))


def _is_flat(d: Detection) -> bool:
    """Whether it was found facing the camera, as a whole."""
    return d.margin is None and (d.pose is None or d.pose_from != "fit")


def _same_direction(d: Detection, last: Detection, age_s: float, config: TrackingConfig) -> float | None:
    """As `_same_turn`, by directions in the image, of which the other one is half a turn away."""
    off = abs(float(wrap_angle(d.image.theta - last.image.theta)))
    variance = (config.turn_rate * age_s) ** 2 + config.sightings.turn_rad**2
    if min(off, np.pi - off) > _DEVIATIONS * variance**0.5:
        return None
    return ((np.pi - off) ** 2 - off**2) / (2 * variance)


def _laid(d: Detection, odds: float) -> Detection:
    """In the likelier one of two places. :param odds: logarithm of those of the one that is told."""
    other = d.other_place
    assert other is not None and other.told is not None
    probability = float(1 / (1 + np.exp(abs(odds))))
    as_told = min(d.as_told / (1 - other.probability) * (1 - probability), 1.0)
    told, place = d, replace(other, probability=probability)
    if odds < 0:
        told, place = other.told, OtherPlace(d.image, probability, replace(d, other_place=None))
    return replace(told, id=d.id, as_told=as_told, score=d.there * as_told, other_place=place)


def _apart(pairs: Sequence[tuple[Pose | None, Pose | None]]) -> float:
    """Mean square of the angles between those pairs of poses of which both are there; of none too far, rad²."""
    angles = [_angle(a, b) for a, b in pairs if a is not None and b is not None]
    return float(np.mean(np.square(angles))) if angles else np.pi**2


def _variance(d: Detection, config: TrackingConfig) -> float:
    """Of a pose's turn, were it surely the one that is told; rad²."""
    if d.pose_covariance is None or d.pose is None:
        return config.sightings.turn_rad**2
    other = d.other_turn
    P = d.pose_covariance - (other.probability * other.spread(d.pose) if other else 0.0)
    return float(np.trace(P[3:, 3:])) / 3


def _turned(d: Detection, odds: float) -> Detection:
    """With the likelier one of two turns. :param odds: logarithm of those of the one that is told."""
    pose, other = d.pose, d.other_turn
    assert other is not None and pose is not None
    probability = float(1 / (1 + np.exp(abs(odds))))
    # what is counted of it is the same, whichever of both is told
    d = d.beside(replace(other, probability=probability), probability - other.probability)
    if odds >= 0:
        return d
    told = OtherTurn(pose, probability, d.joints)
    return replace(d, pose=other.pose, joints={**d.joints, **other.joints}, other_turn=told)


def _angle(a: Pose, b: Pose) -> float:
    return float(np.linalg.norm(rotvec_from_rotation(a.rotation @ b.rotation.T)))
