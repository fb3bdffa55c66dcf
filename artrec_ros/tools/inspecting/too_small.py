"""What `artrec inspect` and `artrec learn-colours` say of markers that are specks, or larger than needed."""

from __future__ import annotations

import math
from collections.abc import Iterator

from ...core.model.objects import ObjectModel
from ...core.model.solids import closed_components
from .structure import shortened

_ENOUGH_PX = 40.0  # root of a marker's area: larger ones tell little more, and take longer (docs/overhead.md)
_ROUNDING = 1.001  # of limits that are written with four digits, and leave a marker just enough


def too_small(model: ObjectModel, least_scale: float, least_px: int) -> Iterator[str]:
    """A line where markers that are seen straight on show fewer pixels than blobs have.

    :param least_scale: at which the object may be seen, px/m; 0: no limit is known. :param least_px: of blobs.
    """
    if least_scale <= 0:
        return
    areas_px = {key: m2 * least_scale**2 for key, m2 in _areas_m2(model).items()}
    small = {key: px for key, px in areas_px.items() if px * _ROUNDING < least_px}
    if not small:
        return
    own = [key for key in areas_px if key[0] == model.required.name]
    is_lost = set(own) <= small.keys()
    lost = "the object is not found there (with recognizer.required strict)" if is_lost else "they are not seen there"
    needed = max(areas_px[key] for key in own) if is_lost else min(small.values())
    least, most = (f"{px:.3g}" for px in (min(small.values()), max(small.values())))
    yield (
        f"{shortened(['/'.join(key) for key in small])}: {least if least == most else f'{least} to {most}'} px at "
        f"recognizer.min_scale {least_scale:.4g} px/m, fewer than recognizer.min_blob_px {least_px}: {lost}, but from "
        f"{least_scale * math.sqrt(least_px / needed):.4g} px/m on; make them larger or lower min_blob_px"
    )


def too_large(model: ObjectModel, least_scale: float) -> Iterator[str]:
    """A line where all markers are so large that images half as large, or less, would show as much.

    :param least_scale: at which the object was seen, px/m.
    """
    side_px = least_scale * math.sqrt(min(_areas_m2(model).values()))
    if side_px >= 2 * _ENOUGH_PX:
        yield (
            f"its smallest marker is {side_px:.0f} px across (the root of its area) where it is farthest: images that "
            f"are {side_px / _ENOUGH_PX:.2g} times smaller tell as much and are recognised several times as fast; "
            "shrink them first, and learn colours from these (docs/overhead.md)"
        )


def _areas_m2(model: ObjectModel) -> dict[tuple[str, str], float]:
    """Of each marker; of what markers close in, whose sides are seen as one blob, of the largest alone."""
    areas, solids = {key: m.area for key, m in model.markers.items()}, closed_components(model)
    for name in solids:
        mine = {key: m2 for key, m2 in areas.items() if key[0] == name}
        for key in mine.keys() - {max(mine, key=mine.__getitem__)}:
            del areas[key]
    return areas
