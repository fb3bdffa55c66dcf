"""Is an object in space that learned colours show there as often as its score says? As `acceptance.py`, of pictures.

python benchmarks/acceptance_colour.py --save found.npz [--first 0] [--worlds 210] [--scenes 8]
python benchmarks/acceptance_colour.py --load found.npz [more.npz ...] [--fit]

The scenes of `random_solids.py`, seen exactly, are painted, blurred and compressed (`random_flat.painted`), and read by
reference colours. In half of the worlds what lies around has colours near to the first target's, too, which the
background names in three of four.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
from acceptance import arguments, report, rows_of, summary, write_added
from acceptance_claims import Claims, Parts, Watcher, joined, load, save
from acceptance_fit import Curves, best_of_several
from random_flat import painted, world_colours
from random_solids import LABELS, random_frames, random_world
from scipy.special import expit
from tqdm import tqdm

from artrec_ros.core.base.config import ImageConfig
from artrec_ros.core.geometry.transforms import Array
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.verdict import acceptance_curves, colour_curves

OUT = Path(colour_curves.__file__)
IN_COLOUR = " in colour"
# Cases of which curves of labels say too little, and the evidence that says how much is lacking: these curves stay, and
# what is fitted is added to them. Curves of all evidence fitted anew do worse on worlds left out. With "deserted" and
# "borne out" held-out log-loss falls as well, but walkers are lost in real sequences of images
CASES, COLUMNS = ("alone",), ("faint",)
# Share of the worlds with things whose colours are near the object's, and of these with a background that names them
NEAR, NAMED = 1 / 2, 3 / 4
OFF, LIGHT = (15.0, 60.0), (0.7, 1.3)  # how far off such a colour is, of 255, and how bright, of the object's


def colours_of(seed: int) -> tuple[ImageConfig, ImageConfig]:
    """How a world is painted, and how its pictures are read."""
    rng, shown = np.random.default_rng([31, seed]), world_colours(seed)
    shown = replace(shown, sharpen_px=int(rng.integers(2)))
    if rng.random() >= NEAR:
        return shown, shown
    own, more = np.array(shown.classes[f"c{LABELS[0]}"].rgb, float), list[int]()
    for _ in range(int(rng.integers(1, 4))):
        way = rng.normal(size=3)
        near = own * rng.uniform(*LIGHT) + rng.uniform(*OFF) * way / np.linalg.norm(way)
        more += np.clip(near, 0, 255).astype(int).tolist()
    every = replace(shown, background=(*shown.background, *more))
    return every, every if rng.random() < NAMED else shown


def watch(first: int, worlds: int, scenes: int) -> tuple[Claims, Parts]:
    """Claims, and components of claims, in pictures of so many worlds."""
    claims, parts = [], []
    for number in tqdm(range(first, first + worlds), desc="worlds", disable=None):
        world, (shown, read) = random_world(number), colours_of(number)
        segmenter = Segmenter(read)
        watcher = Watcher(world.targets, "visible" if number // 2 % 2 else "strict", segmenter.meaning)
        rng = np.random.default_rng([32, number])
        for frame in random_frames(world, number, scenes, exact=True):
            picture = painted(frame, shown, rng).picture
            assert picture is not None
            field = LabelField(segmenter.codes(picture), meaning=segmenter.meaning)
            watcher.search(frame, ImageFrame(field, frame.camera, image=picture))
        claims.append(Claims.of(number, watcher.claims))
        parts.append(Parts.of(number, watcher.parts))
    return joined(claims), joined(parts)


def of_labels(claims: Claims, case: str) -> Array:
    """(n,) logits of claims by the curves of labels."""
    bias, curves = acceptance_curves.CURVES[case]
    rows = rows_of(claims, tuple(curves))
    return np.asarray(bias + sum(np.interp(x, *points) for x, points in zip(rows.T, curves.values(), strict=True)))


def main() -> None:
    args = arguments(__doc__, 210, 8, OUT)
    claims, parts = load(args.load) if args.load else watch(args.first, args.worlds, args.scenes)
    if args.save:
        save(args.save, claims, parts)
    named = np.array([case.removesuffix(IN_COLOUR) for case in claims.case])
    claims = replace(claims, case=named)[claims.final]
    odd = claims[claims.world % 2 == 1]
    report("as they scored", odd.score, odd)
    if args.fit:
        added, said = dict[str, tuple[Curves, str]](), list[str]()
        for case in CASES:
            one = claims[claims.case == case]
            even, logit, rows = one.world % 2 == 0, of_labels(one, case), rows_of(one, COLUMNS)
            added[case] = best_of_several(rows[even], one.right[even], one.world[even], logit[even])
            p = added[case][0].probability(rows[~even], logit[~even])
            said += [f"{case}: {even.sum()} claims; of odd-numbered ones {summary(p, one[~even])}"]
            report(f"{case} by curves of labels alone", expit(logit[~even]), one[~even])
            report(f"{case} with what is added", p, one[~even])
        numbers = np.unique(claims.world)
        runs = np.split(numbers, np.flatnonzero(np.diff(numbers) > 1) + 1)
        worlds = " and ".join(f"{run[0]} to {run[-1]}" for run in runs)
        said_all = f"Fitted on the even-numbered of worlds {worlds}. {'; '.join(said)}."
        about = f"What images with colours add to `acceptance_curves.py`, written by `{Path(__file__).name} --fit`."
        write_added(added, COLUMNS, said_all, OUT, about, "acceptance_curves")


if __name__ == "__main__":
    main()
