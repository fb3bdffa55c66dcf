"""What is known of the size of each marker that is pictured, and what has to be said of it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ...core.base.errors import ConfigError
from ...io.objects.marker_shapes import LooseMarker
from ...io.objects.measured_sizes import KnownRectangle


@dataclass(frozen=True)
class PictureSize:
    """Measured sides of a marker's bounding box, metres, and a rectangle around it; None where not given."""

    width_m: float | None
    height_m: float | None
    rectangle: KnownRectangle | None

    def told(self, picture: str, made: LooseMarker) -> str:
        """A line on how far the marker's shape is to be trusted, and what to do where it is not."""
        width, height = np.ptp(made.marker.outline, axis=0)
        size = f"{width:.4g} x {height:.4g} m"
        if self.rectangle is not None:
            slant = self.rectangle.slant_deg
            return f"note: {picture}: {size} by its rectangle, which was seen at a slant of some {slant:.0f} degrees"
        if self.height_m is not None:
            return (
                f"note: {picture}: {size} as given, and the picture agrees; a slant about a diagonal does not show in "
                "two sides, but in a rectangle around the marker (--corners, --rectangle)"
            )
        return (
            f"warning: {picture}: with its width of {width:.4g} m as given it is {height:.4g} m high; is it? A slant "
            "does not show in one side (20 degrees make another 6 % too short): measure its height and give --height, "
            "or straighten the picture by a rectangle around the marker (--corners, --rectangle)"
        )


def picture_sizes(
    pictures: int,
    widths: Sequence[float] | None,
    heights: Sequence[float] | None,
    corners: Sequence[Sequence[float]] | None,
    rectangle: Sequence[float] | None,
) -> list[PictureSize]:
    """One for each picture, in their order.

    :raises ConfigError: as many values of an option as pictures, or one for all, are wanted.
    """
    if bool(corners) != bool(rectangle):
        raise ConfigError("--corners and --rectangle go together: where its corners are, and its size in metres")
    if corners and len(corners) != pictures:
        raise ConfigError(f"--corners: given {len(corners)} times for {pictures} picture(s); once for each")
    if not widths and not corners:
        raise ConfigError(
            f"--width: 0 given for {pictures} picture(s); one for all, or one each, metres (or --corners, --rectangle)"
        )
    known: list[KnownRectangle | None] = [None] * pictures
    if corners and rectangle:
        known = [KnownRectangle(np.array(c), (rectangle[0], rectangle[1])) for c in corners]
    sides = _each("--width", widths, pictures), _each("--height", heights, pictures)
    return [PictureSize(*each) for each in zip(*sides, known, strict=True)]


def _each(flag: str, values: Sequence[float] | None, pictures: int) -> list[float | None]:
    given: list[float | None] = [*(values or (None,))]
    if len(given) not in (1, pictures):
        raise ConfigError(f"{flag}: {len(given)} given for {pictures} picture(s); one for all, or one each, metres")
    return given * pictures if len(given) == 1 else given
