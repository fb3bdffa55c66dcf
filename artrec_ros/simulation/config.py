"""What a simulated scene may hold and what the camera does to it: every tunable value, once."""

from __future__ import annotations

from dataclasses import dataclass, replace

from ..core.base.config import GREATEST_LABEL, param, validate
from ..core.base.errors import ConfigError


@dataclass(frozen=True)
class SceneConfig:
    """Where objects stand and what else is in view."""

    objects: tuple[int, int] = param((1, 1), "least and greatest number of objects in a frame", low=0, high=50)
    size: tuple[float, float] = param(
        (0.2, 0.6),
        "least and greatest apparent diameter of an object, as a share of the image's width",
        low=0.02,
        high=2,
    )
    elevation_deg: tuple[float, ...] = param(
        (),
        "least and greatest angle of the camera's line of sight below the horizontal; without: from above where "
        "most markers face up, else from the side",
        unit="deg",
        low=0,
        high=90,
    )
    tilt_rad: float = param(0.04, "sigma of an object's tilt out of the vertical", unit="rad", low=0, high=1)
    margin: float = param(
        1.0, "share of an object's radius that stays inside the image; 0: only its origin", low=0, high=2
    )
    facing: float = param(
        0.9, "share of objects that turn a marker of the required component to the camera", low=0, high=1
    )
    joint_range: float = param(1.0, "share of each joint's limits that is used", low=0, high=1)
    distractors: int = param(
        3, "greatest number of polygons of the objects' colours that belong to nothing", low=0, high=100
    )
    floor_label: int = param(1, "class label of the floor; 0: no floor", low=0, high=GREATEST_LABEL)

    def __post_init__(self) -> None:
        validate(self, "scene.")
        for name in ("objects", "size", "elevation_deg"):
            pair = getattr(self, name)
            if pair and (len(pair) != 2 or pair[0] > pair[1]):
                shown = " ".join(map(str, pair))
                raise ConfigError(f"scene.{name}: '{shown}': a least and a greatest value are expected, in this order")


@dataclass(frozen=True)
class SensorConfig:
    """Light, optics, sensor and colour segmenter. All zero: every pixel bears the class that fills most of it."""

    light: float = param(0.25, "sigma of the logarithm of the light, which varies slowly over the image", low=0, high=2)
    blur_px: float = param(0.6, "sigma of the lens's blur", unit="px", low=0, high=10)
    pixel_noise: float = param(0.03, "sigma of each channel's noise, as a share of full scale", low=0, high=1)
    speckle: float = param(0.001, "share of pixels that get a class by chance", low=0, high=1)
    motion_blur_px: float = param(
        0.0, "greatest way of the image during an exposure, in a direction of its own in each frame", unit="px", low=0,
        high=100,
    )  # fmt: skip
    spots: int = param(
        0, "greatest number of round spots that the segmenter gives a wrong class (glare, dirt)", low=0, high=1000
    )

    def __post_init__(self) -> None:
        validate(self, "sensor.")

    def scaled(self, factor: float) -> SensorConfig:
        """The same disturbances, `factor` times as strong; 0: none."""
        return replace(
            self,
            light=min(self.light * factor, 2.0),
            blur_px=min(self.blur_px * factor, 10.0),
            pixel_noise=min(self.pixel_noise * factor, 1.0),
            speckle=min(self.speckle * factor, 1.0),
            motion_blur_px=min(self.motion_blur_px * factor, 100.0),
            spots=round(self.spots * factor),
        )

    @property
    def is_ideal(self) -> bool:
        return not any((self.light, self.blur_px, self.pixel_noise, self.speckle, self.motion_blur_px, self.spots))
