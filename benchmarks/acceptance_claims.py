"""What claims the search makes in random scenes, and which of them are right in place."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from random_solids import World, random_frames, random_world
from tqdm import tqdm

from artrec_ros.core.base.config import RecognizerConfig
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Array
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.pose.surface_model import Poses
from artrec_ros.core.spatial_search import SpatialSearch
from artrec_ros.core.verdict.acceptance import Verdict
from artrec_ros.core.verdict.judge import Judge
from artrec_ros.core.verdict.ownership import share_out
from artrec_ros.simulation.simulator import SimulatedFrame
from artrec_ros.simulation.surfaces import component_poses
from artrec_ros.simulation.truth import ObjectTruth

# How far a claim may be off: of its marker's size in the image and of its range, and pixels of that size
SIZE_SHARE, RANGE_SHARE, SIZE_PX, RANGE_PX = 0.35, 0.1, 1.0, 2.0


@dataclass(frozen=True)
class Recorder(Judge):
    """Judges, and keeps what the search asked about."""

    asked: list[Verdict] = field(default_factory=list)

    def trust_in(self, finder: WholeObjectFinder, poses: Poses, frame: ImageFrame) -> float:
        verdict = self.verdicts(finder, poses[:1], frame)[0] if len(poses) else None
        if verdict is None:
            return 0.0
        self.asked.append(verdict)
        return self.trust(verdict)


def shown_centre(verdict: Verdict) -> Array:
    """(3,) the centre of the marker that shows a claim's required component, in the camera."""
    finder, poses = verdict.claim.finder, verdict.claim.poses
    marker = finder.surface.patches[verdict.shown[finder.root]].marker
    assert marker is not None
    frames = finder.surface.kinematics.forward(poses.R, poses.t, poses.q)
    return np.asarray(frames.R[0, finder.root] @ marker.centre + frames.t[0, finder.root])


def is_at(verdict: Verdict, truth: ObjectTruth, frame: SimulatedFrame) -> bool:
    """Whether a claim is right in place: its required component is where the claim has it.

    Of that component's markers that face the camera, one must be where the claim has its own: within a third of its
    size in the image (its neighbours of the same shape are farther off), and within a tenth of its range (something
    small and near is nothing large and far). A segmenter's seam may take a pixel on either side of a marker, and so
    a small one may be off by more of its range. How exact a pose is, and which way it is turned, is not asked:
    of that `Detection.pose_covariance` speaks.
    """
    placed, model = truth.placed, truth.placed.target.model
    if placed.target.name != verdict.claim.finder.target.name:
        return False
    claimed = shown_centre(verdict)
    T = placed.T_camera_object @ component_poses(model, placed.joints)[model.required.name]
    for seen in truth.markers:
        if seen.component != model.required.name:
            continue
        true, size_px = T.apply(model.required.marker(seen.marker).centre[None])[0], max(seen.full_px, 1.0) ** 0.5
        off_px = np.linalg.norm(np.diff(project(frame.camera, np.stack([claimed, true])), axis=0))
        off_range = abs(np.linalg.norm(claimed) / np.linalg.norm(true) - 1)
        if off_px <= SIZE_SHARE * size_px + SIZE_PX and off_range <= max(RANGE_SHARE, RANGE_PX / size_px):
            return True
    return False


@dataclass(frozen=True)
class Claims:
    """n claims.

    :param world: (n,) their worlds' numbers. :param final: (n,) bool: of those that pixels were shared out to; else
        the search asked about it. :param case: (n,) `Verdict.case`. :param right: (n,) 1 or 0.
    :param score: (n,) what they got. :param evidence: (n, columns) `Evidence`.
    """

    world: NDArray[np.int_]
    final: NDArray[np.bool_]
    case: NDArray[np.str_]
    right: Array
    score: Array
    evidence: Array

    @classmethod
    def of(cls, rows: list[tuple[int, bool, Verdict, bool]]) -> Claims:
        world, final, verdicts, right = zip(*rows, strict=True)
        return cls(
            np.array(world),
            np.array(final),
            np.array([v.case for v in verdicts]),
            np.array(right, float),
            np.array([v.probability for v in verdicts]),
            np.array([v.evidence for v in verdicts], float),
        )

    @classmethod
    def load(cls, files: list[Path]) -> Claims:
        parts = [np.load(f) for f in files]
        return cls(**{name: np.concatenate([p[name] for p in parts]) for name in cls.__annotations__})

    def __getitem__(self, rows: NDArray) -> Claims:
        return Claims(**{name: values[rows] for name, values in vars(self).items()})


def claims_in(frame: SimulatedFrame, finders: list[WholeObjectFinder]) -> Iterator[tuple[bool, Verdict, bool]]:
    """Claims in a scene: whether pixels were shared out to it, and whether it is right. Of several at an object's
    place only the first, the one with the most votes, is."""
    config = RecognizerConfig(min_probability=0.0)
    judge = Recorder(config.verdict.min_votes, config.min_probability)
    image = ImageFrame(LabelField(frame.labels), frame.camera)
    blobs = find_blobs(frame.labels, {label for f in finders for label in f.surface.labels}, config)
    accepted, _ = share_out(SpatialSearch(image, judge, config.search).run(finders, blobs), image, judge)
    left = list(frame.truths)
    for verdict in accepted:
        there = next((n for n, truth in enumerate(left) if is_at(verdict, truth, frame)), None)
        if there is not None:
            del left[there]
        yield True, verdict, there is not None
    for verdict in judge.asked:
        if verdict.confirmed[verdict.claim.finder.root]:
            yield False, verdict, any(is_at(verdict, truth, frame) for truth in frame.truths)


def search(first: int, worlds: int, scenes: int) -> Claims:
    """Claims in the scenes of so many worlds."""
    rows = []
    for number in tqdm(range(first, first + worlds), desc="worlds", disable=None):
        world: World = random_world(number)
        finders = [WholeObjectFinder(t, RecognizerConfig()) for t in world.targets]
        for frame in random_frames(world, number, scenes):
            rows += [(number, *claim) for claim in claims_in(frame, finders)]
    return Claims.of(rows)
