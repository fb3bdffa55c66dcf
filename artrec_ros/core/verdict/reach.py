"""Why an object is nearer or farther than is looked for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecognizerConfig
from ..geometry.range_limits import ROUNDING
from ..geometry.transforms import Array

_ROUNDING = 1 + ROUNDING


@dataclass(frozen=True)
class Reach:
    """The limits of `RecognizerConfig`, as `range_limits` has them together; a greatest one of 0 means any.

    :param min_range_m, max_range_m: of the middle of the required component, along the optical axis.
    :param min_scale, max_scale: pixels per metre there.
    """

    min_range_m: float = 0.0
    max_range_m: float = 0.0
    min_scale: float = 0.0
    max_scale: float = 0.0

    @classmethod
    def of(cls, config: RecognizerConfig) -> Reach:
        return cls(config.min_range_m, config.max_range_m, config.min_scale, config.max_scale)

    def holds(self, depth_m: Array, scale: Array) -> NDArray[np.bool_]:
        """(H,) whether objects are in it; what is NaN is."""
        out = (depth_m * _ROUNDING < self.min_range_m) | (scale * _ROUNDING < self.min_scale)
        if self.max_range_m:
            out |= depth_m > self.max_range_m * _ROUNDING
        if self.max_scale:
            out |= scale > self.max_scale * _ROUNDING
        return np.asarray(~out)

    def reason(self, depth_m: float, scale: float) -> str | None:
        """Why an object is out of it; None where it is not, and of a NaN."""
        if depth_m * _ROUNDING < self.min_range_m:
            return f"its required component is {depth_m:.3g} m away, nearer than min_range_m {self.min_range_m:g}"
        if 0 < self.max_range_m * _ROUNDING < depth_m:
            return f"its required component is {depth_m:.3g} m away, beyond max_range_m {self.max_range_m:g}"
        if scale * _ROUNDING < self.min_scale:
            return f"{scale:.3g} px/m, below min_scale {self.min_scale:g}"
        if 0 < self.max_scale * _ROUNDING < scale:
            return f"{scale:.3g} px/m, above max_scale {self.max_scale:g}"
        return None
