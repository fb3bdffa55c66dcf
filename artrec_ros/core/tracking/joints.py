"""How joints move: a Kalman filter of each, all of a frame at once."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.config import TrackingConfig
from ..geometry.transforms import Array, short_way
from ..model.found import Detection
from ..model.kinematics import Kinematics, within_limits
from ..model.target import Target
from .motion import MotionModel, MotionState, calmed


class About(NamedTuple):
    """Of a joint.

    :ivar unit: what a step of it is measured in. :ivar lower, upper: its limits. :ivar endless: it turns without limit.
    """

    unit: float = 1.0
    lower: float = -np.inf
    upper: float = np.inf
    endless: bool = False


Units = Mapping[tuple[str, str], About]
"""By an object's and its joint's name."""


def units_of(targets: Sequence[Target]) -> Units:
    """Of all joints of some targets."""
    units: dict[tuple[str, str], About] = {}
    for target in targets:
        kin = Kinematics(target.model)
        columns = (kin.unit.tolist(), kin.lower.tolist(), kin.upper.tolist(), kin.endless.tolist())
        for name, *about in zip(target.model.joint_names, *columns, strict=True):
            units[target.name, name] = About(*about)
    return units


@dataclass(frozen=True)
class Joints:
    """N joints of T tracks.

    :param keys: row of the track and name of each. :param state: (N) along one axis each. :param times: (N,) how often
        it was seen.
    """

    keys: tuple[tuple[int, str], ...]
    state: MotionState
    about: tuple[About, ...]
    times: NDArray[np.intp]

    @property
    def unit(self) -> Array:
        """(N,)"""
        return np.array([a.unit for a in self.about], float)

    @property
    def endless(self) -> NDArray[np.bool_]:
        """(N,)"""
        return np.array([a.endless for a in self.about], bool)

    @property
    def endless_ones(self) -> frozenset[tuple[int, str]]:
        """Those of `keys` that turn without end."""
        return frozenset(key for key, about in zip(self.keys, self.about, strict=True) if about.endless)

    @classmethod
    def none(cls) -> Joints:
        """Of no tracks."""
        state = MotionState(np.zeros((0, 2, 1)), np.zeros((0, 2, 2, 1, 1)), np.zeros((0, 1)))
        return cls((), state, (), np.zeros(0, int))

    def after(self, dt_s: float, model: MotionModel) -> Joints:
        return Joints(self.keys, self.state.after(dt_s, model), self.about, self.times)

    def of_rows(self, rows: Sequence[int]) -> Joints:
        """Those of these tracks, which get new rows in this order."""
        return self._renumbered({row: n for n, row in enumerate(rows)})

    def without(self, rows: Collection[int]) -> Joints:
        """Those of other tracks."""
        return self._renumbered({row: row for row, _ in self.keys if row not in rows})

    def _renumbered(self, place: Mapping[int, int]) -> Joints:
        """Those of some tracks, by their rows the new ones."""
        kept = [n for n, (row, _) in enumerate(self.keys) if row in place]
        if len(kept) == len(self.keys) and all(place[row] == row for row, _ in self.keys):
            return self
        keys = tuple((place[self.keys[n][0]], self.keys[n][1]) for n in kept)
        index = np.array(kept, int)
        return Joints(keys, self.state[index], tuple(self.about[n] for n in kept), self.times[index])

    def seen(
        self, found: Mapping[int, Detection], dt_s: float, model: MotionModel, units: Units, config: TrackingConfig
    ) -> Joints:
        """:param found: by row of their tracks; what of it has not been seen before is new."""
        known = self._corrected(found, dt_s, model, config)
        have = set(self.keys)
        new = [(row, name) for row, d in found.items() for name in d.joints if (row, name) not in have]
        if not new:
            return known
        about = [units.get((found[row].object, name), About()) for row, name in new]
        unit = np.array([a.unit for a in about])
        values, noise = _measured(new, found, unit, config)
        pace = (config.sightings.joint_rate / max(model.speed, 1e-9)) * unit[:, None]
        state = MotionState.first_seen(values[:, None], noise[:, None, None], pace, model)
        return Joints(
            (*known.keys, *new),
            MotionState.joined([known.state, state]),
            (*known.about, *about),
            np.append(known.times, np.ones(len(new), int)),
        )

    def _corrected(self, found: Mapping[int, Detection], dt_s: float, model: MotionModel, c: TrackingConfig) -> Joints:
        if not self.keys:
            return self
        values, noise = _measured(self.keys, found, self.unit, c)
        rows = np.flatnonzero(np.isfinite(values))
        state = self.state[rows]
        error = short_way(values[rows] - state.place[:, 0], self.endless[rows])
        noise = noise[rows] * np.maximum(
            error**2 / (state.place_covariance[:, 0, 0] + noise[rows]) / (c.sightings.usual / 4), 1.0
        )
        state = state.corrected(error[:, None], noise[:, None, None])
        most = (c.sightings.joint_rate / max(model.speed, 1e-9)) * self.unit[rows, None]
        state = calmed(state, dt_s, most, 1, model, c.sightings.calm)
        times = self.times.copy()
        times[rows] += 1
        return Joints(self.keys, self.state.replaced(rows, state), self.about, times)

    def told(self) -> dict[int, list[tuple[str, float, float, float]]]:
        """Of each track its joints: name, value within its limits, standard deviation, and rate, NaN where it was seen
        once."""
        out: dict[int, list[tuple[str, float, float, float]]] = {}
        rate = np.where(self.times > 1, self.state.mean[:, 1, 0], np.nan)
        deviation = np.sqrt(self.state.place_covariance[:, 0, 0])
        lower, upper = (np.array([getattr(a, end) for a in self.about], float) for end in ("lower", "upper"))
        values = within_limits(self.state.place[:, 0], lower, upper, self.endless)
        columns = (values.tolist(), deviation.tolist(), rate.tolist())
        for (row, name), *each in zip(self.keys, *columns, strict=True):
            out.setdefault(row, []).append((name, *each))
        return out


def _measured(
    keys: Sequence[tuple[int, str]], found: Mapping[int, Detection], unit: Array, config: TrackingConfig
) -> tuple[Array, Array]:
    """(N,) values, NaN where there is none, and variances."""
    values = np.array([found[row].joints.get(name, np.nan) if row in found else np.nan for row, name in keys])
    usual = {row: _deviation(d, config) for row, d in found.items()}
    told = [found[row].joint_deviations.get(name) if row in found else 1.0 for row, name in keys]
    own = [
        u * usual.get(row, 1.0) if t is None else t for t, u, (row, _) in zip(told, unit.tolist(), keys, strict=True)
    ]
    return values, np.square(own)


def _deviation(detection: Detection, config: TrackingConfig) -> float:
    """Of a joint of which none is told: as that of the body's turn."""
    turn = 0.0 if detection.pose_covariance is None else float(np.trace(detection.pose_covariance[3:, 3:])) / 3
    return float(np.sqrt(config.sightings.joint_rad**2 + config.sightings.joint_turn**2 * turn))
