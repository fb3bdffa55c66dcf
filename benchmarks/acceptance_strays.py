"""Is a flat object there as often as its score says, where strays look like parts of it? As `acceptance_facing.py`.

python benchmarks/acceptance_strays.py --save found.npz [--first 0] [--worlds 220] [--scenes 14]
python benchmarks/acceptance_strays.py --load found.npz [more.npz ...] [--fit]

In two fifths of the scenes lie strays (`random_flat.strewn`), and in a quarter of the worlds objects are equal dots, of
which these make the most. What is told of such scenes by the curves of usual ones is too sure of what lacks most of its
parts in plain view. Save with no curves in force: empty `ADDED` first.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from acceptance import arguments, report, rows_of, summary, write_added
from acceptance_claims import load, save
from acceptance_facing import watch
from acceptance_fit import Curves, best_of_several
from numpy.typing import NDArray
from scipy.special import logit

from artrec_ros.core.geometry.transforms import Array
from artrec_ros.core.verdict import stray_curves

OUT = Path(stray_curves.__file__)
DOTTED = 1 / 4  # share of the worlds
# Cases in which other components should be in view, and what says how much of them is not there: curves of usual scenes
# stay, and what is fitted is taken off. Curves of all evidence fitted anew on such scenes are a little better there
# (log-loss .13 for .14) and lose objects that touch, of which all parts are seen
CASES, COLUMNS = ("borne out", "deserted", "borne out in colour", "deserted in colour"), ("lacking",)


def fitted(rows: Array, right: Array, worlds: NDArray[np.int_], off: Array) -> tuple[Curves, str]:
    """What is taken off logits (n,): nothing where nothing is lacking, for that curves of usual scenes know."""
    curves, note = best_of_several(rows, right, worlds, off)
    (points,) = curves.points
    return Curves(-float(points[1][-1]), (points,)), note


def main() -> None:
    args = arguments(__doc__, 220, 14, OUT)
    claims, parts = load(args.load) if args.load else watch(args.first, args.worlds, args.scenes, DOTTED)
    if args.save:
        save(args.save, claims, parts)
    report("as they scored", claims.score, claims)
    if args.fit:
        added, said = dict[str, tuple[Curves, str]](), list[str]()
        for case in CASES:
            one = claims[claims.case == case]
            off, rows, p = logit(np.clip(one.score, 1e-9, 1 - 1e-9)), rows_of(one, COLUMNS), np.empty(len(one.right))
            for rest in (one.world % 2 == half for half in (0, 1)):
                half = fitted(rows[~rest], one.right[~rest], one.world[~rest], off[~rest])[0]
                p[rest] = half.probability(rows[rest], off[rest])
            added[case] = fitted(rows, one.right, one.world, off)
            said += [f"{case}: {summary(p, one)}"]
            report(f"{case} as they scored", one.score, one)
            report(f"{case} by the other half of the worlds", p, one)
        worlds = f"{claims.world.min()} to {claims.world.max()}"
        said_all = f"Fitted on worlds {worlds}. Of each half of these by the other one: {'; '.join(said)}."
        about = f"What strays take from `facing_curves.py`, written by `{Path(__file__).name} --fit`."
        write_added(added, COLUMNS, said_all, OUT, about, "facing_curves")


if __name__ == "__main__":
    main()
