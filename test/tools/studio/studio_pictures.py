"""A small set of colour pictures of robots from above, with their truth, by the package's simulator."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np

from artrec_ros.core.model.target import Target
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.simulation.config import SceneConfig, SensorConfig
from artrec_ros.simulation.simulator import SimulatedFrame, pinhole_camera, simulate

SIZE = (320, 240)
OBJECT = """\
format: artrec_object/1
name: robot
markers:
  team: {rectangle: {width: 0.06, height: 0.03}}
  accent: {rectangle: {width: 0.03, height: 0.03}}
components:
  team: {required: true, markers: {team: {pose: {xyz: [0, 0, 0.05], x_axis: [1, 0, 0], y_axis: [0, 1, 0]}}}}
  accent:
    label: accent
    markers: {accent: {pose: {xyz: [0.045, 0.045, 0.05], x_axis: [1, 0, 0], y_axis: [0, 1, 0]}}}
"""
PARAMETERS = """\
/**:
  ros__parameters:
    objects: [robot]            # what is looked for
    robot: {object_file: robot.yaml, label: 2}
    image:
      kind: colour
      classes: [team, accent]
      team: {label: 2}
      accent: {label: 3}
"""


@dataclass(frozen=True)
class Pictures:
    """A folder `pictures` with frames, robots.yaml and robot.yaml beside it."""

    folder: Path
    frames: tuple[SimulatedFrame, ...]

    @property
    def source(self) -> Path:
        return self.folder / "pictures"

    @property
    def parameters(self) -> Path:
        return self.folder / "robots.yaml"

    def axes(self, number: int) -> list[dict[str, tuple[np.ndarray, np.ndarray]]]:
        """Per robot of a frame: component -> tail and head of its marker's axis, pixels."""
        truths = self.frames[number].truths
        return [{m.component: (m.tail, m.head) for m in t.markers if m.visible_px > 0} for t in truths]

    def middles(self, number: int, component: str) -> list[np.ndarray]:
        return [m.centre for t in self.frames[number].truths for m in t.markers if m.component == component]


def write_pictures(folder: Path, count: int, robots: int = 3) -> Pictures:
    (folder / "robot.yaml").write_text(OBJECT)
    (folder / "robots.yaml").write_text(PARAMETERS)
    target = Target("robot", load_object(folder / "robot.yaml", {"accent": 3}), 2)
    scene = SceneConfig(
        objects=(robots, robots), size=(0.15, 0.18), elevation_deg=(89.0, 90.0), tilt_rad=0.0, distractors=0
    )
    frames = simulate([target], pinhole_camera(SIZE, 40.0), scene, SensorConfig().scaled(0.3), 4, count)
    (folder / "pictures").mkdir()
    kept = []
    for frame in frames:
        cv2.imwrite(str(folder / "pictures" / f"{frame.index:02d}.png"), frame.colour)
        kept.append(frame)
    return Pictures(folder, tuple(kept))
