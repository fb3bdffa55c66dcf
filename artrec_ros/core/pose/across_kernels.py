"""By how much joints are bent across the bends at which their markers face the camera."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from ..base.jit import jit
from ..geometry.pixel_kernels import turned


class Tipped(NamedTuple):
    """The markers that their component's own joint tips."""

    component: Any  # (m,)
    joint: Any  # (m,)
    way: Any  # (m, 3) which way looks the same as mirrored in the line of sight, in its component's frame
    middle: Any  # (m, 3)
    ball: Any  # (m,) bool: whose lever has no front


@jit
def bend_across(tipped: Tipped, R: Any, t: Any, axis: Any, used: Any, least_lever: float, by: Any) -> None:
    """Fill by (H, J) with how far each joint is to go for its marker to lean as far from the camera as it leant towards
    it; of several markers the last one tells. Others stay as they are.

    :param R, t, axis: frames (H, C, 3, 3), (H, C, 3) and joints' axes (H, J, 3) in the camera.
    :param used: (H, m) bool. :param least_lever: of a turn across the line of sight, for a marker to be mirrored by it.
    """
    for h in range(len(R)):
        for m in range(len(tipped.component)):
            if not used[h, m]:
                continue
            c, j = tipped.component[m], tipped.joint[m]
            nx, ny, nz = turned(R[h, c], tipped.way[m])
            mx, my, mz = turned(R[h, c], tipped.middle[m])
            mx, my, mz = mx + t[h, c, 0], my + t[h, c, 1], mz + t[h, c, 2]
            away = -1.0 / max(math.sqrt(mx * mx + my * my + mz * mz), 1e-12)
            sx, sy, sz = mx * away, my * away, mz * away  # towards the camera
            facing = nx * sx + ny * sy + nz * sz
            if tipped.ball[m] and facing < 0.0:
                nx, ny, nz, facing = -nx, -ny, -nz, -facing
            ax, ay, az = axis[h, j, 0], axis[h, j, 1], axis[h, j, 2]
            along = facing - (nx * ax + ny * ay + nz * az) * (sx * ax + sy * ay + sz * az)
            across = (ay * nz - az * ny) * sx + (az * nx - ax * nz) * sy + (ax * ny - ay * nx) * sz
            if facing > 0.0 and math.hypot(along, across) > least_lever:
                by[h, j] = 2.0 * math.atan2(across, along)
