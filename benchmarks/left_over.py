"""Is a pose right as often as it is told to be, where blobs are left over that may be components of the object?

Fits `expert.verdict.left_over_odds` on even-numbered worlds of random limbs (`random_limbs.py`), which few numbers bear
out, and of random solids (`random_solids.py`), which many do, and tells of odd ones how often directions and all joints
told are right: by the scores as they would be without it, and with it.

python benchmarks/left_over.py --save found.npz [--first 0] [--worlds 200] [--scenes 12]
python benchmarks/left_over.py --load found.npz [more.npz ...]
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace

import numpy as np
from acceptance_fit import log_loss, tell
from kept_rows import rows_of
from random_limbs import Limb, LimbWorld, limb_scene, limb_world
from random_solids import random_frames, random_world
from scipy.optimize import minimize
from scipy.special import expit
from tqdm import tqdm

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig
from artrec_ros.core.geometry.camera import Camera
from artrec_ros.core.geometry.transforms import Array, rotvec_from_rotation, wrap_angle
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.found import Detection
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.core.verdict.left_over import LeftOver, LeftOvers
from artrec_ros.io.images.decoding import Image
from artrec_ros.simulation.scene import PlacedObject

RIGHT_RAD, NEAR_PX = np.radians(15), 8.0  # a direction or a joint is right, and an object is the same one
NEAR_RANGE = 0.1  # in space: share of the range
EACH = 2  # scenes of limbs for one of solids, which take longer
MOST_SPARE = 12
WIDER = 0.15  # logarithm, by which limits of the scale are wider than the world's scales
AS_SURE = (-20.0, 0.0, 0.0)  # odds by which all poses are right
FLAT, IN_SPACE, SOLID = 0, 1, 2
COLUMNS = "world", "kind", "p", "left", "spare", "right", "worst"


class _Noting(LeftOvers):
    """Notes what each object leaves, in the order in which objects are described."""

    def of(self, *args, **told) -> list[LeftOver]:  # type: ignore[no-untyped-def]
        self.noted = super().of(*args, **told)
        return self.noted


def watch(first: int, worlds: int, scenes: int) -> Array:
    """(n, columns) of all limbs and solids that are told."""
    rows = list[list[float]]()
    for number in tqdm(range(first, first + worlds), desc="worlds", disable=None):
        rows += [*_of_limbs(number, scenes), *_of_solids(number, max(scenes // EACH, 1))]
    return np.array(rows)


def _of_limbs(number: int, scenes: int) -> Iterator[list[float]]:
    world = limb_world(number)
    engine = recognizer(world, AS_SURE)
    for scene in range(scenes):
        labels, limbs = limb_scene(world, number, scene)
        for d, left in _noted(engine, labels, world.camera if world.known else None):
            kind, worst = IN_SPACE if world.known else FLAT, _off(d, limbs)
            yield [number, kind, d.score, len(left.blobs), left.spare, worst < RIGHT_RAD, worst]


def _of_solids(number: int, scenes: int) -> Iterator[list[float]]:
    world = random_world(number)
    engine = Recognizer(world.targets, _config(RecognizerConfig(), AS_SURE), Segmenter(ImageConfig()))
    for frame in random_frames(world, number, scenes):
        for d, left in _noted(engine, frame.labels, frame.camera):
            worst = _off_in_space(d, [t.placed for t in frame.truths if t.placed.target.name == d.object])
            yield [number, SOLID, d.score, len(left.blobs), left.spare, worst < RIGHT_RAD, worst]


def _noted(engine: Recognizer, labels: Image, camera: Camera | None) -> list[tuple[Detection, LeftOver]]:
    """What is told in an image with what each leaves; nothing where some of it was told in another way."""
    describers = _describers(engine)
    for d in describers:
        d._left_over = _Noting(d.finder)
    found = engine.recognize(labels, camera).detections
    noted = [left for d in describers for left in getattr(d._left_over, "noted", [])]
    return list(zip(found, noted, strict=True)) if len(noted) == len(found) else []


def recognizer(world: LimbWorld, odds: Sequence[float]) -> Recognizer:
    config = RecognizerConfig(min_scale=world.px_per_m * np.exp(-WIDER), max_scale=world.px_per_m * np.exp(WIDER))
    return Recognizer((world.target,), _config(config, odds), Segmenter(ImageConfig()), calibrated=world.known)


def _config(config: RecognizerConfig, odds: Sequence[float]) -> RecognizerConfig:
    verdict = replace(config.verdict, left_over_odds=tuple(odds))
    return replace(config, time_budget_ms=60000.0, verdict=verdict)


def _describers(engine: Recognizer) -> list:
    return [*engine._facing.describers, *engine._spatial._describers]


def _off(d: Detection, limbs: Sequence[Limb]) -> float:
    """The error of direction and joints."""
    same = [limb for limb in limbs if np.hypot(*(limb.at - (d.image.x, d.image.y))) < NEAR_PX]
    if not same:
        return np.inf
    off = [d.image.theta - same[0].direction, *(q - same[0].joints[name] for name, q in d.joints.items())]
    return float(np.abs(wrap_angle(off)).max())


def _off_in_space(d: Detection, objects: Sequence[PlacedObject]) -> float:
    """The same of the nearest of some objects."""
    if d.pose is None or not objects:
        return np.inf
    off_m = [float(np.linalg.norm(o.T_camera_object.position - d.pose.position)) for o in objects]
    there = objects[int(np.argmin(off_m))]
    if min(off_m) > NEAR_RANGE * np.linalg.norm(d.pose.position):
        return np.inf
    turn = np.linalg.norm(rotvec_from_rotation(there.T_camera_object.rotation @ d.pose.rotation.T))
    return float(np.abs([turn, *wrap_angle([q - there.joints[name] for name, q in d.joints.items()])]).max())


def fitted(rows: Mapping[str, Array]) -> Array:
    """(3,) odds that make the scores of those that leave something likeliest, right or not, given what they were."""
    left = rows["left"] > 0
    p, right = np.clip(rows["p"][left], 1e-3, 1 - 1e-3), rows["right"][left]
    tried = list[tuple[float, Array]]()
    for most in np.arange(1, MOST_SPARE, 0.5):
        X = np.column_stack([np.ones(left.sum()), np.minimum(rows["spare"][left], most)])

        def loss(w: Array, X: Array = X) -> float:
            return log_loss(p * expit(-X @ w), right) + 1e-3 * float(w @ w)

        best = minimize(loss, np.zeros(2))
        tried.append((float(best.fun), np.append(best.x, most)))
    return min(tried, key=lambda one: one[0])[1]


def scored(rows: Mapping[str, Array], odds: Array) -> Array:
    """(n,) as told with these odds."""
    against = odds[0] + odds[1] * np.minimum(rows["spare"], odds[2])
    return np.asarray(np.where(rows["left"] > 0, rows["p"] * expit(-against), rows["p"]))


def main() -> None:
    rows = rows_of(__doc__, COLUMNS, watch, 300, 12)
    even = rows["world"] % 2 == 0
    odds = fitted({name: column[even] for name, column in rows.items()})
    print("left_over_odds:", np.round(odds, 2).tolist())
    rest = {name: column[~even] for name, column in rows.items()}
    left = rest["left"] > 0
    solid = rest["kind"] == SOLID
    for where, some in (
        ("all", np.ones_like(left)),
        ("limbs that leave something", left & ~solid),
        ("solids", left & solid),
    ):
        tell(f"{where}, as they were", rest["p"][some], rest["right"][some])
        tell(f"{where}, as told", scored(rest, odds)[some], rest["right"][some])


if __name__ == "__main__":
    main()
