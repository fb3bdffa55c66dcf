"""How images are read."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from ..errors import ConfigError
from .params import param, validate

GREATEST_LABEL = 252  # of a class: higher ones have meanings of their own inside (core/image/codes.py)


@dataclass(frozen=True)
class ClassConfig:
    """One class of pixels, by its colours. Several classes may share one label."""

    label: int = param(0, "class number its pixels get", low=1, high=GREATEST_LABEL)
    rgb: tuple[int, ...] = param(
        (),
        "the class' colours r,g,b,r,g,b,...; colour images: reference colours, in the light that is usual",
        low=0,
        high=255,
    )
    light: tuple[float, ...] = param(
        (0.35, 1.8),
        "colour images, with rgb: deepest shade and brightest light, over the usual; for all references, or two "
        "numbers for each",
        low=0.02,
        high=10,
    )
    spread: float = param(
        0.08, "colour images, with rgb: scatter of the class' colour, share of its brightness", low=0, high=1
    )
    hue: tuple[float, ...] = param(
        (), "colour images: hue ranges from,to,from,to,...; a range may pass 360", unit="deg", low=0, high=360
    )
    saturation: tuple[float, ...] = param((0.0, 1.0), "colour images: least and greatest saturation", low=0, high=1)
    value: tuple[float, ...] = param((0.0, 1.0), "colour images: least and greatest value (brightness)", low=0, high=1)

    @property
    def is_bare(self) -> bool:
        """Whether no colour is given."""
        return not (self.rgb or self.hue) and (self.saturation, self.value) == ((0.0, 1.0), (0.0, 1.0))

    def check(self, kind: str, prefix: str) -> None:
        """Raise `ConfigError` where the values make no class for images of `kind`."""
        if len(self.rgb) % 3 or (kind == "palette" and not self.rgb):
            raise ConfigError(f"{prefix}rgb: {list(self.rgb)} must be one or more colours r,g,b,r,g,b,...")
        if kind == "colour" and self.rgb and not replace(self, rgb=()).is_bare:
            raise ConfigError(f"{prefix}rgb: give a class either rgb or ranges of hue, saturation and value")
        if len(self.hue) % 2:
            raise ConfigError(f"{prefix}hue: {list(self.hue)} must be pairs from,to,from,to,... in degrees")
        for name, pairs in (("saturation", 1), ("value", 1), ("light", len(self.rgb) // 3)):
            limits = getattr(self, name)
            if len(limits) not in (2, 2 * pairs) or any(a > b for a, b in zip(limits[::2], limits[1::2], strict=True)):
                each = ", once or for each reference colour" if name == "light" else ""
                raise ConfigError(
                    f"{prefix}{name}: {list(limits)} must be the least and the greatest, in this order{each}"
                )


@dataclass(frozen=True)
class ImageConfig:
    """How an image becomes a label image."""

    kind: str = param(
        "labels",
        "what images hold: class numbers, a colour-coded label image, or a camera's raw colours",
        choices=("labels", "palette", "colour"),
    )
    rectified: bool = param(
        False, "images are rectified: the calibration's P holds for them, without distortion; else its K and D"
    )
    blank: tuple[int, ...] = param(
        (), "rectangles to ignore: x,y,width,height,... in pixels (timestamps, windows)", unit="px", low=0
    )
    smoothing_px: float = param(
        0.0, "colour images: sigma of a Gaussian before classification", unit="px", low=0, high=10
    )
    gamma: float = param(
        1.0,
        "colour images: values grow with light to the power 1/gamma: 2.2 of most cameras, 1 of linear ones",
        low=0.3,
        high=3,
    )
    blur_px: float = param(
        0.0,
        "colour images: standard deviation of the lens' blur, undone before classification; 0: none",
        unit="px",
        low=0,
        high=4,
    )
    blur_noise: float = param(
        0.1,
        "colour images: for blur_px, the noise's power over the scene's; more: less is undone, less noise brought out",
        low=0.001,
        high=1,
    )
    sharpen_px: int = param(
        0,
        "colour images: pixels on a step between two colours take the nearer one within this radius; 0: off",
        unit="px",
        low=0,
        high=5,
    )
    sharpen_step: float = param(
        0.16, "colour images: least step of a channel, share of full scale, for sharpen_px", low=0, high=1
    )
    sharpen_amount: float = param(
        0.5,
        "colour images: share of the difference from their surroundings added to pixels before, for sharpen_px",
        low=0,
        high=3,
    )
    background: tuple[int, ...] = param(
        (),
        "colour images: reference colours r,g,b,... of no class: what is more like them is not for classes with rgb",
        low=0,
        high=255,
    )
    background_light: tuple[float, ...] = param(
        (0.35, 1.8),
        "colour images, with background: deepest shade and brightest light, over the usual; for all of its colours, or "
        "two numbers for each",
        low=0.02,
        high=10,
    )
    noise: float = param(
        0.03, "colour images, classes with rgb: the sensor's noise, share of full scale", low=0.001, high=0.5
    )
    max_deviation: float = param(
        4.0, "colour images, classes with rgb: standard deviations beyond which a colour is unknown", low=0.5, high=20
    )
    light_spread: float = param(
        0.4,
        "colour images, classes with rgb: standard deviation of light's natural logarithm; between classes that differ "
        "in brightness only, it decides",
        low=0.05,
        high=5,
    )
    gain_percentile: float = param(
        0.0,
        "colour images: scale each frame so that this percentile of brightness is gain_level; 0: off",
        low=0,
        high=100,
    )
    gain_level: float = param(0.8, "colour images: brightness that gain_percentile is scaled to", low=0.05, high=1)
    gain_limit: float = param(
        8.0, "colour images: gain_percentile scales by at most this factor, at least by its inverse", low=1, high=50
    )
    tolerance: int = param(
        0, "palette images: greatest difference of a channel from a class' colour (lossy compression)", low=0, high=127
    )
    classes: dict[str, ClassConfig] = field(default_factory=dict)  # by name; the first listed wins a pixel

    def __post_init__(self) -> None:
        validate(self, "image.")
        if len(self.blank) % 4:
            raise ConfigError(f"image.blank: {len(self.blank)} numbers are no whole rectangles x,y,width,height,...")
        if len(self.background) % 3:
            raise ConfigError(f"image.background: {len(self.background)} numbers are no whole colours r,g,b,r,g,b,...")
        if self.background:
            ClassConfig(rgb=self.background, light=self.background_light).check("colour", "image.background_")
        if self.kind != "labels" and not self.classes:
            raise ConfigError(
                f"image.classes: none is given; kind '{self.kind}' needs one or more: artrec learn-colours finds them"
            )
        for name, cls in self.classes.items():
            validate(cls, f"image.{name}.")
            cls.check(self.kind, f"image.{name}.")

    @property
    def is_uncoloured(self) -> bool:
        """Whether nobody has told the colours of any class yet."""
        return self.kind == "colour" and all(cls.is_bare for cls in self.classes.values())

    @property
    def named_labels(self) -> tuple[tuple[str, int], ...]:
        """Each class' name and label."""
        return tuple((name, cls.label) for name, cls in self.classes.items())
