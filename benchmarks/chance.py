"""Is a flat object there as often as its score says, where many patches are like its components?

Fits `expert.verdict.chance_share` on worlds of flat objects made up at random (`random_flat.py`), some of
whose components are hidden, amid patches with their outlines and classes; and tells how often objects are there by the
scores as they would be without it, and with it.

python benchmarks/chance.py --save found.npz [--first 0] [--worlds 180] [--scenes 6]
python benchmarks/chance.py --load found.npz [more.npz ...]
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import partial

import numpy as np
from acceptance_facing import WIDER, is_there
from acceptance_fit import log_loss, tell
from kept_rows import rows_of
from random_flat import FlatScene, flat_frames, flat_world, strays, true_scales, world_colours
from random_patterns import shaded
from random_solids import World
from scipy.special import expit, logit
from tqdm import tqdm

from artrec_ros.core.base.config import RecognizerConfig
from artrec_ros.core.facing_stage import FacingStage
from artrec_ros.core.geometry.range_limits import scale_limits
from artrec_ros.core.geometry.transforms import Array
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.verdict.chance import Chances
from artrec_ros.simulation.simulator import SimulatedFrame

PATCHES, HIDDEN = (0, 3, 10, 30, 100, 200), (0.0, 0.1, 0.4)  # of a scene, at most; share of components
WIDER_VIEW = 2  # times as wide and as high as without the patches, that there may be many
COLUMNS = "world", "p", "expected", "wide", "right"
MOST_LOST = 0.003  # log loss in usual images: a fifth of what it differs by between halves of the worlds


def crowd(frame: SimulatedFrame, rng: np.random.Generator, world: World) -> SimulatedFrame:
    """A frame with some components of its objects hidden and patches like them where nothing is, in half of the scenes
    in a wider view."""
    frame = shaded(frame, rng, float(rng.choice(HIDDEN)))
    frame = widened(frame, rng) if rng.random() < 0.5 else frame
    return strays(frame, rng, world, int(rng.choice(PATCHES)))


def widened(frame: SimulatedFrame, rng: np.random.Generator) -> SimulatedFrame:
    """The same somewhere in a wider view."""
    inner = np.array(frame.labels.shape[::-1])
    left, top = rng.integers(0, (WIDER_VIEW - 1) * inner, endpoint=True).tolist()
    labels, matrix = np.zeros(WIDER_VIEW * inner[::-1], np.uint8), frame.camera.matrix.copy()
    labels[top : top + inner[1], left : left + inner[0]] = frame.labels
    matrix[:2, 2] += left, top
    size = WIDER_VIEW * int(inner[0]), WIDER_VIEW * int(inner[1])
    return replace(frame, labels=labels, camera=replace(frame.camera, matrix=matrix, size=size))


def watch(first: int, worlds: int, scenes: int) -> Array:
    """(n, columns) of all objects that are found."""
    rows = list[list[float]]()
    for number in tqdm(range(first, first + worlds), desc="worlds", disable=None):
        world, rng = flat_world(number), np.random.default_rng([25, number])
        segmenter = Segmenter(world_colours(number))
        for scene in flat_frames(world, number, scenes, partial(crowd, world=world)):
            rows += _rows(number, world, scene, segmenter, rng)
    return np.array(rows)


def _rows(
    number: int, world: World, scene: FlatScene, segmenter: Segmenter, rng: np.random.Generator
) -> list[list[float]]:
    """Of one scene, searched at all scales or, in half of them, at about those that there are."""
    config = RecognizerConfig(time_budget_ms=60000.0)
    scales = true_scales([t for t in scene.frame.truths if t.placed.target in world.targets], scene.frame)
    if scales and rng.random() < 0.5:
        wider = float(np.exp(rng.uniform(*WIDER)))
        config = replace(config, min_scale=min(scales) / wider, max_scale=max(scales) * wider)
    if scene.picture is None:
        field = LabelField(scene.frame.labels)
    else:
        field = LabelField(segmenter.codes(scene.picture), meaning=segmenter.meaning)
    image, stage = ImageFrame(field, image=scene.picture).faced(), FacingStage(world.targets, config, field.meaning)
    wanted = {label for d in stage.describers for labels in d.finder.surface.labels for label in labels}
    blobs = find_blobs(image.field.labels, wanted, config)
    accepted = stage.verdicts(image, blobs, scale_limits(config, None)).accepted
    wide = scene.frame.labels.shape != scene.frame.colour.shape[:2]
    left, out = list(scene.frame.truths), list[list[float]]()
    for verdict in accepted:
        there = next((t for t in left if is_there(verdict, t, image, scene)), None)
        left = [t for t in left if t is not there]
        if len(verdict.confirmed) > 1:
            (expected,) = Chances(verdict.claim.finder).expected([verdict], image, blobs, accepted)
            out.append([number, verdict.probability, expected, wide, there is not None])
    return out


def scored(rows: Mapping[str, Array], share: float) -> Array:
    """(n,) as told with this share."""
    times = 1 + share * rows["expected"]
    return np.asarray(expit(logit(np.clip(rows["p"], 1e-6, 1 - 1e-6)) - np.log(times)))


def fitted(rows: Mapping[str, Array]) -> float:
    """The most with which scores of usual images are as likely as without it: what is rare is not to be had at the cost
    of what is not."""
    usual = {name: column[rows["wide"] == 0] for name, column in rows.items()}
    most = log_loss(usual["p"], usual["right"]) + MOST_LOST
    shares = np.exp(np.linspace(np.log(0.01), np.log(100), 200))
    return float(max(s for s in shares if log_loss(scored(usual, s), usual["right"]) <= most))


def main() -> None:
    rows = rows_of(__doc__, COLUMNS, watch, 180, 6)
    share = fitted(rows)
    print(f"chance_share {share:.2f} of {len(rows['p'])} objects")
    for name, which in (("usual", rows["wide"] == 0), ("crowded", rows["wide"] > 0)):
        tell(f"{name}, without", rows["p"][which], rows["right"][which])
        tell(f"{name}, with", scored(rows, share)[which], rows["right"][which])


if __name__ == "__main__":
    main()
