"""Is a pose right as often as it is told to be, where blobs are left over that may be components of the object?

Fits `expert.verdict.left_over_odds` on even-numbered worlds of random limbs (`random_limbs.py`), and tells of odd ones
how often directions and all joints told are right: by the scores as they would be without it, and with it.

python benchmarks/left_over.py --save found.npz [--first 0] [--worlds 200] [--scenes 12]
python benchmarks/left_over.py --load found.npz [more.npz ...]
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from acceptance_fit import log_loss, tell
from kept_rows import rows_of
from random_limbs import Limb, LimbWorld, limb_scene, limb_world
from scipy.optimize import minimize
from scipy.special import expit
from tqdm import tqdm

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.geometry.transforms import Array, wrap_angle
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.found import Detection
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict.left_over import LeftOver, LeftOvers

RIGHT_RAD, NEAR_PX = np.radians(15), 8.0  # a direction or a joint is right, and an object is the same one
WIDER = 0.15  # logarithm, by which limits of the scale are wider than the world's scales
AS_SURE = (-20.0, 0.0)  # odds by which all poses are right
COLUMNS = "world", "space", "p", "left", "spare", "right", "worst"


class _Noting(LeftOvers):
    """Notes what each object leaves, in the order in which objects are described."""

    def of(self, *args, **told) -> list[LeftOver]:  # type: ignore[no-untyped-def]
        self.noted = super().of(*args, **told)
        return self.noted


def watch(first: int, worlds: int, scenes: int) -> Array:
    """(n, columns) of all limbs that are told."""
    rows = list[list[float]]()
    for number in tqdm(range(first, first + worlds), desc="worlds", disable=None):
        world = limb_world(number)
        engine = recognizer(world, AS_SURE)
        describers = _describers(engine)
        for scene in range(scenes):
            labels, limbs = limb_scene(world, number, scene)
            for d in describers:
                d._left_over = _Noting(d.finder)
            found = engine.recognize(labels, world.camera if world.known else None).detections
            noted = [left for d in describers for left in getattr(d._left_over, "noted", [])]
            if len(noted) == len(found):
                rows += [_row(number, world, d, left, limbs) for d, left in zip(found, noted, strict=True)]
    return np.array(rows)


def recognizer(world: LimbWorld, odds: Sequence[float]) -> Recognizer:
    config = RecognizerConfig(
        min_scale=world.px_per_m * np.exp(-WIDER), max_scale=world.px_per_m * np.exp(WIDER), time_budget_ms=60000.0
    )
    config = replace(config, verdict=replace(config.verdict, left_over_odds=tuple(odds)))
    return Recognizer((world.target,), config, Segmenter(ImageConfig()), calibrated=world.known)


def _describers(engine: Recognizer) -> list:
    return [*engine._facing.describers, *engine._spatial._describers]


def _row(number: int, world: LimbWorld, d: Detection, left: LeftOver, limbs: Sequence[Limb]) -> list[float]:
    """One detection's columns. `p` is the probability that it is there; `worst` the error of direction and joints."""
    same = [limb for limb in limbs if np.hypot(*(limb.at - (d.image.x, d.image.y))) < NEAR_PX]
    worst = np.inf
    if same:
        off = [d.image.theta - same[0].direction, *(q - same[0].joints[name] for name, q in d.joints.items())]
        worst = float(np.abs(wrap_angle(off)).max())
    right = worst < RIGHT_RAD
    return [number, world.known, d.there, len(left.blobs), left.spare, right, worst]


def fitted(rows: Mapping[str, Array]) -> Array:
    """(2,) odds that make the scores of those that leave something likeliest, right or not, given what they were."""
    left = rows["left"] > 0
    X = np.column_stack([np.ones(left.sum()), rows["spare"][left]])
    p, right = np.clip(rows["p"][left], 1e-3, 1 - 1e-3), rows["right"][left]

    def loss(w: Array) -> float:
        return log_loss(p * expit(-X @ w), right) + 1e-3 * float(w @ w)

    return np.asarray(minimize(loss, np.zeros(2)).x)


def scored(rows: Mapping[str, Array], odds: Array) -> Array:
    """(n,) as told with these odds."""
    against = odds[0] + odds[1] * rows["spare"]
    return np.asarray(np.where(rows["left"] > 0, rows["p"] * expit(-against), rows["p"]))


def main() -> None:
    rows = rows_of(__doc__, COLUMNS, watch, 300, 12)
    even = rows["world"] % 2 == 0
    odds = fitted({name: column[even] for name, column in rows.items()})
    print("left_over_odds:", np.round(odds, 2).tolist())
    rest = {name: column[~even] for name, column in rows.items()}
    left = rest["left"] > 0
    for where, some in (("all", np.ones_like(left)), ("with something left over", left)):
        tell(f"{where}, as they were", rest["p"][some], rest["right"][some])
        tell(f"{where}, as told", scored(rest, odds)[some], rest["right"][some])


if __name__ == "__main__":
    main()
