"""Whether something unknown hides an end of a marker: do `expert.verdict.turn_odds` hold of that, too?

    python benchmarks/hidden_ends.py --worlds 100      # 10 minutes

Objects of one to four markers: trees, plates, flaps on hinges. In half of the scenes things of no class lie over ends
of markers. From labels, and from colour images of the same scenes. Of each told pose the likeliest other one counts;
seeded.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from random_solids import LABELS, SHARES, SIZES, World, random_tree
from tqdm import tqdm
from turns import COLOURED, Recorder, hinges, plates, report

from artrec_ros.core.base.config import ImageConfig, RecognizerConfig, VerdictConfig
from artrec_ros.core.geometry.transforms import Array, Pose
from artrec_ros.core.image.segmentation import Segmenter
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose import other_rests
from artrec_ros.core.pose.turn_evidence import evidence, turn_odds
from artrec_ros.core.recognizer import Recognizer
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.render import Renderer
from artrec_ros.simulation.scene import PlacedObject, sample_scene
from artrec_ros.simulation.simulator import SimulatedFrame, pinhole_camera, render_frame
from artrec_ros.simulation.surfaces import Surface

STILLS, FEW = 12, 4  # scenes of each world; components of an object at most
HIDDEN = 0.5  # see `frames`
NEAR_RAD, NEAR_SHARE = np.radians(12), 0.04  # of the truth: turn, and place as a share of the range
NEARER = 0.9  # of what hides an end: its depth, as a share of the end's


class HiddenRecorder(Recorder):
    """What the recogniser finds to speak for hidden ends."""

    def __init__(self) -> None:
        super().__init__(NEAR_RAD, NEAR_SHARE, mirrored=False)
        vars(other_rests)["turn_odds"] = self._odds

    def _odds(self, finder: Any, frame: Any, poses: Any, others: Any) -> Array:
        found, odds = evidence(finder, frame, poses, others), turn_odds(finder, frame, poses, others)
        for key in dict.fromkeys(poses.t[:, 0].tolist()):
            n = max(np.flatnonzero(poses.t[:, 0] == key).tolist(), key=lambda k: odds[k])
            both = (Pose(p.R[n], p.t[n]) for p in (poses, others))
            self.rows.append((finder.target.name, *both, float(found.votes[n]), float(found.contours[n])))
        return odds


def trees(seed: int) -> World:
    """An object of few parts."""
    rng = np.random.default_rng([80, seed])
    while len((model := random_tree("one", rng)).components) > FEW:
        pass
    return World((Target("one", model, LABELS[0]),), ())


def frames(world: World, seed: int, hidden: float = HIDDEN) -> Iterator[SimulatedFrame]:
    """Scenes of a world. :param hidden: share of scenes in which ends are hidden, and of objects in these."""
    for rng in (np.random.default_rng([81, seed, n]) for n in range(STILLS)):
        size, least = SIZES[rng.choice(len(SIZES), p=SHARES)], float(np.exp(rng.uniform(np.log(0.1), np.log(0.4))))
        scene = SceneConfig(objects=(1, 2), size=(least, 1.5 * least), distractors=int(rng.choice([0, 3])))
        sensor, camera = SensorConfig().scaled(float(rng.choice([0.0, 0.5, 1.0, 1.5]))), pinhole_camera(size, 60)
        drawn = sample_scene(world.targets, camera, scene, rng)
        if rng.random() < hidden:
            over = (over_an_end(one, rng) for one in drawn.objects if rng.random() < hidden)
            drawn = replace(drawn, distractors=(*drawn.distractors, *over))
        yield render_frame(0, Renderer(camera), drawn, sensor, rng)


def over_an_end(one: PlacedObject, rng: np.random.Generator) -> Surface:
    """Something of no class before an end of one of an object's markers."""
    markers = [s for s in one.surfaces() if s.owner is not None]
    corners = markers[int(rng.integers(len(markers)))].corners
    middle, count = corners.mean(axis=0), int(rng.integers(4, 8))
    end = corners[int(rng.integers(len(corners)))]
    reach, angles = float(np.linalg.norm(end - middle)), np.sort(rng.uniform(-np.pi, np.pi, count))
    radii = reach * rng.uniform(0.3, 1.0) * rng.uniform(0.7, 1.0, count)
    outline = np.column_stack([radii * np.cos(angles), radii * np.sin(angles), np.zeros(count)])
    return Surface(NEARER * (middle + rng.uniform(0.8, 1.2) * (end - middle) + outline), np.array([0.0, 0.0, -1.0]), 0)


def record(
    first: int,
    worlds: int,
    recorder: Recorder,
    kinds: Sequence[Callable[[int], World]],
    scenes: Callable[[World, int], Iterator[SimulatedFrame]],
) -> dict[str, Array]:
    """(n, 4) from labels and from colours: world, whether the other pose is right, evidence of votes and contours.

    :param kinds: of worlds, one after the other, two of each. :param scenes: of a world and its seed.
    """
    kept = {"labels": list[tuple[float, ...]](), "colours": list[tuple[float, ...]]()}
    for number in tqdm(range(first, first + worlds), desc="worlds", disable=None):
        world = kinds[number // 2 % len(kinds)](number)
        plain, coloured = (
            Recognizer(list(world.targets), RecognizerConfig(), Segmenter(image)) for image in (ImageConfig(), COLOURED)
        )
        for frame in scenes(world, number):
            kept["labels"] += [(number, *row) for row in recorder.of(plain, frame)]
            kept["colours"] += [(number, *row) for row in recorder.of(coloured, frame, colour=True)]
    return {name: np.array(rows, float).reshape(-1, 4) for name, rows in kept.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--worlds", type=int, default=100)
    parser.add_argument("--first", type=int, default=0, help="world that begins")
    args = parser.parse_args()
    kept = record(args.first, args.worlds, HiddenRecorder(), (trees, plates, hinges), frames)
    config = VerdictConfig()
    for name, odds in (("labels", config.turn_odds), ("colours", config.turn_odds_colour)):
        report(name, kept[name], np.array(odds))


if __name__ == "__main__":
    main()
