"""How the axes that a user annotates differ from those of the outlines that are fitted.

An annotated joint may lie in another depth than the marker, or the marker may be mounted askew. The difference of the
two ends' offsets is what turns the axis: a shift that is constant in the image (parallax), a turn that goes with
the marker, or both. Each is learned by robust least squares, and only where it is beyond doubt.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..base.errors import ConfigError
from ..geometry.transforms import Array, wrap_angle
from ..model.found import Instance
from ..model.marker import Marker
from .pairs import Key, key_from_text

_LEAST_EXAMPLES = 8
_CLEARLY_BETTER = 20.0  # in Schwarz's criterion; of noise alone less than one marker in a hundred passes
_MOST_SHIFT = 0.5  # of an axis' length: of what is more the first order says nothing, and no one annotates so
_HUBER = 1.5
_STEPS = 30
_MAD = 1.4826  # of a normal distribution's median absolute deviation, its standard deviation


@dataclass(frozen=True)
class AxisOffset:
    """What corrects the direction of one marker's axis.

    :param shift_m: (x, y) along the image's axes, over the marker's scale: the axis' head lies so far from the fitted
        one while the tail stays. It scales with the image.
    :param turn_rad: the axis as annotated is turned by so much against the fitted one.
    :param examples: how many taught it.
    :param before_deg, after_deg: median error of the direction in the examples, without it and with it.
    """

    key: Key
    shift_m: tuple[float, float]
    turn_rad: float
    examples: int
    before_deg: float
    after_deg: float

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a file."""
        return {
            "marker": "/".join(self.key),
            "shift_m": [round(v, 6) for v in self.shift_m],
            "turn_rad": round(self.turn_rad, 6),
            "examples": self.examples,
            "before_deg": round(self.before_deg, 3),
            "after_deg": round(self.after_deg, 3),
        }

    @classmethod
    def from_dict(cls, row: Any, where: str) -> AxisOffset:
        """Inverse of `to_dict`. Raises `ConfigError` naming `where`."""
        try:
            key, (dx, dy) = key_from_text(str(row["marker"])), (float(v) for v in row["shift_m"])
            values = [dx, dy, *(float(row[k]) for k in ("turn_rad", "before_deg", "after_deg"))]
            if not np.isfinite(values).all():
                raise ValueError("a value is not finite")
            return cls(key, (dx, dy), values[2], int(row["examples"]), values[3], values[4])
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise ConfigError(
                f"{where}: needs marker (component/marker), shift_m [x, y], turn_rad, examples, before_deg and "
                f"after_deg: {error!r}"
            ) from error

    def corrected(self, instance: Instance, marker: Marker) -> Instance:
        """The instance with its axis' direction as users would annotate it."""
        along = marker.axis_length * np.array([np.cos(instance.theta), np.sin(instance.theta)]) + self.shift_m
        return replace(instance, theta=float(wrap_angle(np.arctan2(along[1], along[0]) + self.turn_rad)))


def learn_axis_offset(key: Key, marker: Marker, fitted_rad: ArrayLike, annotated_rad: ArrayLike) -> AxisOffset | None:
    """The offset of one marker's axis; None where examples are few, or an offset would not explain them clearly better.

    To first order an annotated direction differs from the fitted theta by
    (shift_y cos theta - shift_x sin theta) / length + turn.
    """
    theta = np.asarray(fitted_rad, float)
    error: Array = wrap_angle(np.asarray(annotated_rad, float) - theta)
    if len(theta) < _LEAST_EXAMPLES:
        return None
    shift: Array = np.column_stack([-np.sin(theta), np.cos(theta)]) / marker.axis_length
    turn: Array = np.ones((len(theta), 1))
    best, criterion = None, _criterion(error, 0)
    for terms in ((turn,), (shift,), (shift, turn)):
        matrix = np.hstack(terms)
        found = _robust_least_squares(matrix, error)
        if terms[0] is shift and np.hypot(*found[:2]) > _MOST_SHIFT * marker.axis_length:
            continue  # directions that lie near each other do not tell a shift from a turn
        value = _criterion(error - matrix @ found, matrix.shape[1])
        if value < criterion - _CLEARLY_BETTER:
            best, criterion = (matrix, found, terms), value
    if best is None:
        return None
    matrix, found, terms = best
    shift_m = (float(found[0]), float(found[1])) if terms[0] is shift else (0.0, 0.0)
    turn_rad = float(found[-1]) if terms[-1] is turn else 0.0
    before, after = (float(np.degrees(np.median(np.abs(e)))) for e in (error, error - matrix @ found))
    return AxisOffset(key, shift_m, turn_rad, len(theta), before, after)


def _robust_least_squares(matrix: Array, values: Array) -> Array:
    """Huber's estimate: residuals beyond 1.5 standard deviations count by their size alone.

    :param matrix: (n, k); values: (n,). :return: (k,).
    """
    weight: Array = np.ones(len(values))
    found: Array = np.zeros(matrix.shape[1])
    for _ in range(_STEPS):
        root: Array = np.sqrt(weight)
        found = np.asarray(np.linalg.lstsq(matrix * root[:, None], values * root, rcond=None)[0], float)
        weight = _huber_weights(values - matrix @ found)
    return found


def _huber_weights(residual: Array) -> Array:
    size = np.abs(residual)
    sigma = _MAD * float(np.median(size))
    return 1 / np.maximum(1.0, size / max(_HUBER * sigma, 1e-12))


def _criterion(residual: Array, parameters: int) -> float:
    """Schwarz's criterion of a fit, of residuals that are weighted as in the fit."""
    n = len(residual)
    spread = float(np.sum(_huber_weights(residual) * residual**2)) / n
    return float(n * np.log(max(spread, 1e-12)) + parameters * np.log(n))
