"""Objects that are, in one frame of a sequence, where neither the frame before nor the one after has them."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import linear_sum_assignment

from ...core.geometry.transforms import Array, wrap_angle
from ...core.model.found import Detection
from ...core.model.frame_result import FrameResult

_USUAL = 4.0  # times as far off as objects usually are: of pictures that are no sequence, none is
_LEAST_SIZE, _LEAST_TURN_RAD = 0.5, 0.5  # share of an object's size in the image: less is noise, or how it moves
_SIZE_PX = 20.0  # of an object none of whose outlines is told


@dataclass(frozen=True)
class Jump:
    """An object off the way that leads from the frame before to the one after.

    :param off: how far, in units of what is still no jump: 1 and less is none.
    """

    number: int
    off: float
    why: str


@dataclass(frozen=True)
class _Passing:
    """One object in three frames that follow each other. :param px, rad: how far it is off the way between the others.
    :param px_apart, rad_apart: how far these are apart."""

    number: int
    middle: Detection
    px: float
    rad: float
    px_apart: float
    rad_apart: float


def jumps(frames: Sequence[tuple[int, int, FrameResult]]) -> list[Jump]:
    """Jumps of place or direction in the image.

    :param frames: stamp in ns, number and result of each; in any order.
    """
    ordered = sorted(frames, key=lambda f: f[0])
    passing = [p for three in zip(ordered, ordered[1:], ordered[2:], strict=False) for p in _passing(*three)]
    if not passing:
        return []
    usual_px, usual_rad = (float(np.median([getattr(p, name) for p in passing])) for name in ("px", "rad"))
    return [j for p in passing if (j := _jump(p, usual_px, usual_rad)).off > 1]


def _jump(p: _Passing, usual_px: float, usual_rad: float) -> Jump:
    place = p.px / max(_USUAL * usual_px, _LEAST_SIZE * _size_px(p.middle), p.px_apart)
    turn = p.rad / max(_USUAL * usual_rad, _LEAST_TURN_RAD, p.rad_apart)
    what = f"lies {p.px:.0f} px off" if place >= turn else f"is turned by {np.degrees(p.rad):.0f} degrees against"
    return Jump(p.number, max(place, turn), f"{p.middle.name} {what} where the frames before and after have it")


def _passing(
    before: tuple[int, int, FrameResult], at: tuple[int, int, FrameResult], after: tuple[int, int, FrameResult]
) -> Iterator[_Passing]:
    share = (at[0] - before[0]) / max(after[0] - before[0], 1)
    earlier, now, later = (_by_kind(f[2]) for f in (before, at, after))
    for kind in now:
        first, last = earlier.get(kind, []), later.get(kind, [])
        ways = [(first[i], last[j]) for i, j in _assigned(_places(first), _places(last))]
        between = np.array([_place(a) + share * (_place(b) - _place(a)) for a, b in ways]).reshape(-1, 2)
        for i, j in _assigned(between, _places(now[kind])):
            (a, b), middle = ways[i], now[kind][j]
            turned = float(wrap_angle(b.image.theta - a.image.theta))
            yield _Passing(
                at[1],
                middle,
                float(np.linalg.norm(_place(middle) - between[i])),
                abs(float(wrap_angle(middle.image.theta - a.image.theta - share * turned))),
                float(np.linalg.norm(_place(b) - _place(a))),
                abs(turned),
            )


def _by_kind(result: FrameResult) -> dict[str, list[Detection]]:
    """Those that may be taken for each other together: of one identity where that is known, else of one object."""
    kinds = defaultdict(list)
    for d in result.detections:
        kinds[d.name if d.identity is not None and d.identity.name is not None else d.object].append(d)
    return kinds


def _assigned(a: Array, b: Array) -> Iterator[tuple[int, int]]:
    """Pairs of places that lie nearest, all together."""
    rows, columns = linear_sum_assignment(np.linalg.norm(a[:, None] - b[None], axis=2))
    yield from zip(rows.tolist(), columns.tolist(), strict=True)


def _places(detections: Sequence[Detection]) -> Array:
    return np.array([_place(d) for d in detections]).reshape(-1, 2)


def _place(d: Detection) -> Array:
    return np.array([d.image.x, d.image.y])


def _size_px(d: Detection) -> float:
    contours = [c.contour for c in d.components if len(c.contour)]
    return float(np.linalg.norm(np.ptp(np.vstack(contours), axis=0))) if contours else _SIZE_PX
