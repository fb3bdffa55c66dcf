"""How near and how far objects are looked for, and at which scales."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..base.config import RecognizerConfig
from ..geometry.transforms import Array


@dataclass(frozen=True)
class Reach:
    """The limits of `RecognizerConfig`; a greatest one of 0 means any.

    :param min_range_m, max_range_m: distance of an object's place from the camera.
    :param min_scale, max_scale: pixels per metre at the depth of its required component.
    """

    min_range_m: float = 0.0
    max_range_m: float = 0.0
    min_scale: float = 0.0
    max_scale: float = 0.0

    @classmethod
    def of(cls, config: RecognizerConfig) -> Reach:
        return cls(config.min_range_m, config.max_range_m, config.min_scale, config.max_scale)

    @property
    def is_limited(self) -> bool:
        """Whether anything is out of it."""
        return self != Reach()

    def near(self, t: Array, focal_px: float, slack: float) -> np.ndarray:
        """(H,) bool: which places t (H, 3) in the camera are within it, or off by no more than a share `slack`."""
        range_m, scale, off = np.linalg.norm(t, axis=1), focal_px / np.maximum(t[:, 2], 1e-6), 1 + slack
        good = (range_m * off >= self.min_range_m) & (scale * off >= self.min_scale)
        if self.max_range_m > 0:
            good &= range_m <= self.max_range_m * off
        if self.max_scale > 0:
            good &= scale <= self.max_scale * off
        return np.asarray(good)

    def reason(self, range_m: float, scale: float) -> str | None:
        """Why an object is out of it; None where it is not."""
        if range_m < self.min_range_m:
            return f"{range_m:.3g} m away, nearer than min_range_m {self.min_range_m:g}"
        if 0 < self.max_range_m < range_m:
            return f"{range_m:.3g} m away, beyond max_range_m {self.max_range_m:g}"
        if scale < self.min_scale:
            return f"{scale:.3g} px/m, below min_scale {self.min_scale:g}"
        if 0 < self.max_scale < scale:
            return f"{scale:.3g} px/m, above max_scale {self.max_scale:g}"
        return None
