"""How a component is turned that alone tells it: fits `expert.verdict.alone_odds` and `alone_odds_colour`.

    python benchmarks/turned_alone.py --worlds 140      # half an hour

Turrets on bases, the sides of these of shapes of their own, some with a boom; a third of the worlds flaps on hinges.
In three quarters of the scenes things of no class lie over the bases. From labels, and from colour images of the same
scenes. Of each told pose the likeliest other one counts. Fitted on even-numbered worlds, told of odd ones; seeded.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from hidden_ends import NEARER, record
from random_solids import LABELS, OTHER, RIGHT, SHARES, SIZES, World, _marker, random_outline
from turns import NEAR_RAD, Recorder, fitted, hinges, report

from artrec_ros.core.base.config import VerdictConfig
from artrec_ros.core.geometry.transforms import Array, Pose
from artrec_ros.core.model.objects import Box, Component, Joint, ObjectModel
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose import other_turns
from artrec_ros.core.pose.turn_evidence import evidence
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.render import Renderer
from artrec_ros.simulation.scene import PlacedObject, sample_scene
from artrec_ros.simulation.simulator import SimulatedFrame, pinhole_camera, render_frame
from artrec_ros.simulation.surfaces import Surface

STILLS, HIDDEN = 12, 3 / 4  # of each world; share of scenes in which bases are covered
NEAR_SHARE = 0.05  # of the truth: place as a share of the range


class AloneRecorder(Recorder):
    """What the recogniser finds to speak for such turns."""

    def __init__(self) -> None:
        super().__init__(NEAR_RAD, NEAR_SHARE, mirrored=False)
        self._odds, vars(other_turns)["alone_odds"] = other_turns.alone_odds, self._alone

    def _alone(self, finder: Any, frame: Any, poses: Any, turned: Any) -> Array:
        found, odds = evidence(finder, frame, poses, turned), self._odds(finder, frame, poses, turned)
        for key in dict.fromkeys(poses.t[:, 0].tolist()):
            n = max(np.flatnonzero(poses.t[:, 0] == key).tolist(), key=lambda k: odds[k])
            both = (Pose(p.R[n], p.t[n]) for p in (poses, turned))
            self.rows.append((finder.target.name, *both, float(found.votes[n]), float(found.contours[n])))
        return odds


def turrets(seed: int) -> World:
    """A base with markers on its sides, a turret on it with others, and at times a boom on a hinge before that."""
    rng = np.random.default_rng([83, seed])
    base, top = rng.uniform(0.10, 0.18, 2), rng.uniform(0.06, 0.12, 2)
    low, high = rng.uniform(0.03, 0.06, 2)
    limit = rng.uniform(0.6, np.pi)
    swing = Joint("c0", Pose(np.eye(3), np.array([0, 0, low + 0.004])), np.array([0, 0, 1.0]), -limit, limit)
    components = [
        walls("c0", base, low, rng, (0, 1, 2, 3), True, None, None),
        walls(
            "c1", top, high, rng, sorted(rng.permutation(4)[: int(rng.integers(2, 5))].tolist()), False, OTHER, swing
        ),
    ]
    if rng.random() < 0.6:
        hinge = Joint("c1", Pose(np.eye(3), np.array([top[0] / 2, 0, high / 2])), np.array([0, -1.0, 0]), -0.3, 0.9)
        length, thick = rng.uniform(0.08, 0.16), 0.02
        shape = random_outline(np.array([length, 1.3 * thick]), rng)
        sides = [
            _marker(name, shape, Pose(R, np.array([0.55 * length, y * thick, 0.0])))
            for name, R, y in (("right", RIGHT, -0.51), ("left", np.diag([-1.0, -1.0, 1.0]) @ RIGHT, 0.51))
        ]
        body = Box(Pose(np.eye(3), np.array([0.55 * length, 0, 0])), np.array([1.1 * length, thick, 1.4 * thick]))
        components.append(Component("c2", tuple(sides), False, LABELS[1], hinge, (body,)))
    return World((Target("one", ObjectModel("one", tuple(components)), LABELS[0]),), ())


def walls(
    name: str, size: Array, height: float, rng: np.random.Generator, sides: Any, required: bool, label: Any, joint: Any
) -> Component:
    """A box that stands on its frame's origin, with a marker on some of its sides."""
    markers = []
    for k in sides:
        turn = Pose.from_xyz_rpy((0, 0, 0), (0, 0, k * np.pi / 2)).rotation
        wide, away = (size[0], size[1]) if k % 2 == 0 else (size[1], size[0])
        shape = random_outline(np.array([wide, height]) * rng.uniform(0.7, 0.95, 2), rng)
        markers.append(_marker(f"m{k}", shape, Pose(turn @ RIGHT, turn @ (0, -away / 2 - 0.001, height / 2))))
    body = Box(Pose(np.eye(3), np.array([0, 0, height / 2])), np.array([*size, height]))
    return Component(name, tuple(markers), required, label, joint, (body,))


def frames(world: World, seed: int) -> Iterator[SimulatedFrame]:
    """Scenes of a world."""
    for rng in (np.random.default_rng([84, seed, n]) for n in range(STILLS)):
        size, least = SIZES[rng.choice(len(SIZES), p=SHARES)], float(np.exp(rng.uniform(np.log(0.15), np.log(0.5))))
        scene = SceneConfig(objects=(1, 1), size=(least, 1.3 * least), elevation_deg=(5.0, 45.0), distractors=2)
        sensor, camera = SensorConfig().scaled(float(rng.choice([0.0, 0.5, 1.0, 1.5]))), pinhole_camera(size, 60)
        drawn = sample_scene(world.targets, camera, scene, rng)
        if rng.random() < HIDDEN:
            drawn = replace(drawn, distractors=(*drawn.distractors, *(over_base(one, rng) for one in drawn.objects)))
        yield render_frame(0, Renderer(camera), drawn, sensor, rng)


def over_base(one: PlacedObject, rng: np.random.Generator) -> Surface:
    """Something of no class before a part of an object's required component."""
    markers = [s for s in one.surfaces() if s.owner is not None and s.owner[0] == "c0"]
    corners = np.concatenate([s.corners for s in markers])
    middle, count = corners.mean(axis=0), int(rng.integers(4, 8))
    reach, angles = np.ptp(corners, axis=0)[:2] / 2, np.sort(rng.uniform(-np.pi, np.pi, count))
    radii = rng.uniform(0.5, 1.2) * rng.uniform(0.7, 1.0, count)
    outline = np.column_stack([radii * np.cos(angles) * reach[0], radii * np.sin(angles) * reach[1], np.zeros(count)])
    at = corners[int(rng.integers(len(corners)))]
    place = middle + rng.uniform(0.2, 1.0) * (at - middle)
    return Surface(NEARER * (place + outline), np.array([0.0, 0.0, -1.0]), 0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--worlds", type=int, default=140)
    parser.add_argument("--first", type=int, default=0, help="world that begins")
    parser.add_argument("--save", type=Path, help="keep what was recorded")
    parser.add_argument("--load", type=Path, nargs="+", help="fit what was kept")
    args = parser.parse_args()
    if args.load:
        each = [dict(np.load(file)) for file in args.load]
    else:
        each = [record(args.first, args.worlds, AloneRecorder(), (turrets, turrets, hinges), frames)]
    if args.save:
        np.savez(args.save, **each[0])
    shipped = VerdictConfig()
    for name, odds in (("labels", shipped.alone_odds), ("colours", shipped.alone_odds_colour)):
        rows = np.concatenate([kept[name] for kept in each])
        even, odd = rows[rows[:, 0] % 2 == 0], rows[rows[:, 0] % 2 == 1]
        weights = fitted(even, least=0.0)  # there are few
        print(name, weights.round(2))
        report("fitted on", even, weights)
        report("held out", odd, weights)
        report("held out, by the weights that are shipped", odd, np.array(odds))


if __name__ == "__main__":
    main()
