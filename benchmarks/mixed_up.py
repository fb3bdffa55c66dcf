"""Is an object in space there as often as its score says, where its components look like one another?

Fits `expert.verdict.mixed_up` on even-numbered worlds of objects of dots (`random_dots.py`) and, a fifth of them, of
patterns (`random_patterns.py`) and any others (`random_solids.py`), with strays in two fifths of the scenes; and tells
of odd ones how often objects are there by the scores as they would be without it, and with it.

python benchmarks/mixed_up.py --save found.npz [--first 0] [--worlds 200] [--scenes 10]
python benchmarks/mixed_up.py --load found.npz [more.npz ...]
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np
from acceptance_claims import Watcher
from acceptance_fit import log_loss, tell
from kept_rows import rows_of
from random_dots import dotted_world
from random_flat import strewn
from random_patterns import pattern_frames, random_pattern
from random_solids import World, random_frames, random_world
from scipy.optimize import minimize
from scipy.special import expit, logit
from tqdm import tqdm

from artrec_ros.core.geometry.transforms import Array
from artrec_ros.core.verdict.alike_kernels import Alike, times_mixed_up
from artrec_ros.core.verdict.verdicts import Verdict
from artrec_ros.simulation.simulator import SimulatedFrame

KINDS = ANY, DOTS, PATTERNS = range(3)
NAMES = ("any objects", "dots", "patterns")
UNDOTTED, PATTERNED = 5, 15  # every such world has none, and of these every such one a pattern
COLUMNS = "world", "kind", "logit", "spare", "distinct", "right"
START = 1.0, 0.3, 0.3
LEAST, MOST = 1e-3, 100.0  # of each parameter


def watch(first: int, worlds: int, scenes: int) -> Array:
    """(n, columns) of all claims of objects of which several components are confirmed."""
    rows = list[tuple[float, ...]]()
    for number in tqdm(range(first, first + worlds), desc="worlds", disable=None):
        kind, world, frames = _world(number, scenes)
        watcher = Watcher(world.targets, "visible" if number // 2 % 2 else "strict")
        rng = np.random.default_rng([28, number])
        for frame in frames:
            watcher.look(strewn(frame, rng, world))
        claims = [(v, right) for final, v, right in watcher.claims if final and sum(v.confirmed) > 1]
        rows += [(number, kind, _undone(v), v.evidence.spare, v.evidence.distinct, right) for v, right in claims]
    return np.array(rows)


def _world(number: int, scenes: int) -> tuple[int, World, Iterator[SimulatedFrame]]:
    """Which kind it is of, its objects, and scenes."""
    if number % UNDOTTED:
        world = dotted_world(number)
        return DOTS, world, random_frames(world, number, scenes)
    if number % PATTERNED == 0:
        pattern = random_pattern(number // PATTERNED)
        return PATTERNS, World((pattern.target,), ()), pattern_frames(pattern, number, scenes)
    world = random_world(number)
    return ANY, world, random_frames(world, number, scenes)


def _undone(verdict: Verdict) -> float:
    """The log odds of a claim as they would be without what is in force."""
    p = np.clip(verdict.probability, 1e-9, 1 - 1e-9)
    return float(logit(p) + np.log(verdict.among.times[verdict.row]))


def scored(rows: Mapping[str, Array], by: Array) -> Array:
    """(n,) as told with these parameters."""
    model = Alike(np.zeros(0), 0.0, np.zeros((0, 0), bool), *by.tolist())
    each = zip(rows["spare"].tolist(), rows["distinct"].tolist(), strict=True)
    return np.asarray(expit(rows["logit"] - np.log([times_mixed_up(model, *one) for one in each])))


def fitted(rows: Mapping[str, Array]) -> Array:
    """(3,) those that make what is right likeliest."""

    def loss(logs: Array) -> float:
        return log_loss(scored(rows, np.clip(np.exp(logs), LEAST, MOST)), rows["right"])

    best = minimize(loss, np.log(START), method="Nelder-Mead", options={"maxiter": 2000})
    return np.asarray(np.exp(best.x))


def main() -> None:
    rows = rows_of(__doc__, COLUMNS, watch, 200, 10)
    even = rows["world"] % 2 == 0
    by = fitted({name: column[even] for name, column in rows.items()})
    print(f"mixed_up ({', '.join(f'{value:.2f}' for value in by)}) of {even.sum()} claims")
    for kind, name in zip(KINDS, NAMES, strict=True):
        odd = {key: column[~even & (rows["kind"] == kind)] for key, column in rows.items()}
        if len(odd["right"]):
            tell(f"{name}, without", expit(odd["logit"]), odd["right"])
            tell(f"{name}, with", scored(odd, by), odd["right"])


if __name__ == "__main__":
    main()
