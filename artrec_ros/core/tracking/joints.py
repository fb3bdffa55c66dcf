"""How joints move: a Kalman filter of each, all of a frame at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..base.config import TrackingConfig
from ..geometry.transforms import Array, short_way
from ..model.found import Detection
from ..model.kinematics import Kinematics
from ..model.target import Target
from .motion import MotionModel, MotionState, calmed

Units = Mapping[tuple[str, str], tuple[float, bool]]
"""Of a joint, by its object's and its component's name: what a step of it is measured in, and whether it turns without
limit; a radian, and no, where it is not known."""


def units_of(targets: Sequence[Target]) -> Units:
    units: dict[tuple[str, str], tuple[float, bool]] = {}
    for target in targets:
        kin = Kinematics(target.model)
        each = zip(target.model.joint_names, kin.unit.tolist(), kin.endless.tolist(), strict=True)
        units |= {(target.name, name): (unit, endless) for name, unit, endless in each}
    return units


@dataclass(frozen=True)
class Joints:
    """N joints of T tracks.

    :param keys: row of the track and component of each. :param state: (N) along one axis each. :param unit: (N,).
    :param endless: (N,) whether it turns without limit. :param times: (N,) how often it was seen.
    """

    keys: tuple[tuple[int, str], ...]
    state: MotionState
    unit: Array
    endless: NDArray[np.bool_]
    times: NDArray[np.intp]

    @classmethod
    def none(cls) -> Joints:
        state = MotionState(np.zeros((0, 2, 1)), np.zeros((0, 2, 2, 1, 1)), np.zeros((0, 1)))
        return cls((), state, np.zeros(0), np.zeros(0, bool), np.zeros(0, int))

    def after(self, dt_s: float, model: MotionModel) -> Joints:
        return Joints(self.keys, self.state.after(dt_s, model), self.unit, self.endless, self.times)

    def of_rows(self, rows: Sequence[int]) -> Joints:
        """Those of these tracks, which get new rows in this order."""
        place = {row: n for n, row in enumerate(rows)}
        kept = [n for n, (row, _) in enumerate(self.keys) if row in place]
        if len(kept) == len(self.keys) and all(place[row] == row for row, _ in self.keys):
            return self
        keys = tuple((place[self.keys[n][0]], self.keys[n][1]) for n in kept)
        index = np.array(kept, int)
        return Joints(keys, self.state[index], self.unit[index], self.endless[index], self.times[index])

    def seen(
        self, found: Mapping[int, Detection], dt_s: float, model: MotionModel, units: Units, config: TrackingConfig
    ) -> Joints:
        """:param found: by row of their tracks; what of it has not been seen before is new."""
        known = self._corrected(found, dt_s, model, config)
        have = set(self.keys)
        new = [(row, name) for row, d in found.items() for name in d.joints if (row, name) not in have]
        if not new:
            return known
        about = [units.get((found[row].object, name), (1.0, False)) for row, name in new]
        unit, endless = np.array([u for u, _ in about]), np.array([e for _, e in about], bool)
        values, noise = _measured(new, found, unit, config)
        pace = (config.sightings.joint_rate / max(model.speed, 1e-9)) * unit[:, None]
        state = MotionState.first_seen(values[:, None], noise[:, None, None], pace, model)
        return Joints(
            (*known.keys, *new),
            MotionState.joined([known.state, state]),
            np.append(known.unit, unit),
            np.append(known.endless, endless),
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
        return Joints(self.keys, self.state.replaced(rows, state), self.unit, self.endless, times)

    def told(self) -> dict[int, list[tuple[str, float, float, float]]]:
        """Of each track its joints: component, value, standard deviation, and rate, NaN where it was seen once."""
        out: dict[int, list[tuple[str, float, float, float]]] = {}
        rate = np.where(self.times > 1, self.state.mean[:, 1, 0], np.nan)
        deviation = np.sqrt(self.state.place_covariance[:, 0, 0])
        columns = (self.state.place[:, 0].tolist(), deviation.tolist(), rate.tolist())
        for (row, name), *values in zip(self.keys, *columns, strict=True):
            out.setdefault(row, []).append((name, *values))
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
