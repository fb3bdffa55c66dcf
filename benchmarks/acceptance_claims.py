"""What claims the search makes in random scenes, and which of them are right in place."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray
from random_patterns import PATTERN, pattern_frames, random_pattern, same_places
from random_solids import random_frames, random_world
from tqdm import tqdm

from artrec_ros.core.base.config import RecognizerConfig
from artrec_ros.core.geometry.projection import project
from artrec_ros.core.geometry.transforms import Array, Pose
from artrec_ros.core.image.blobs import find_blobs
from artrec_ros.core.image.codes import LABELS, Codes
from artrec_ros.core.image.image_frame import ImageFrame
from artrec_ros.core.image.label_field import LabelField
from artrec_ros.core.model.target import Target
from artrec_ros.core.pose.finder import WholeObjectFinder
from artrec_ros.core.spatial_search import SpatialSearch
from artrec_ros.core.verdict.descriptions import Describer
from artrec_ros.core.verdict.evidence import Evidence
from artrec_ros.core.verdict.judge import Judge
from artrec_ros.core.verdict.ownership import share_out
from artrec_ros.core.verdict.parts import PartEvidence, part_evidence
from artrec_ros.core.verdict.verdicts import Verdict
from artrec_ros.simulation.simulator import SimulatedFrame
from artrec_ros.simulation.surfaces import component_poses
from artrec_ros.simulation.truth import MarkerTruth, ObjectTruth

# How far a claim may be off: of its marker's size in the image and of its range, and pixels of that size
SIZE_SHARE, RANGE_SHARE, SIZE_PX, RANGE_PX = 0.35, 0.1, 1.0, 2.0
LIKELY_ENOUGH = 0.25  # of claims whose components are looked at


@dataclass(frozen=True)
class Recorder(Judge):
    """Judges, and keeps what the search asked about."""

    noted: list[Verdict] = field(default_factory=list)

    def trust(self, verdict: Verdict) -> float:
        if verdict.claim.votes > self.min_votes:
            self.noted.append(verdict)
        return super().trust(verdict)


def is_there(verdict: Verdict, truth: ObjectTruth, frame: SimulatedFrame) -> bool:
    """`is_at` of a claim whose required component is out of sight: that component's frame is where the claim has it."""
    finder, model, poses = verdict.claim.finder, truth.placed.target.model, verdict.claim.poses
    claimed = finder.surface.kinematics.forward(poses.R, poses.t, poses.q).t[0, finder.root]
    root = component_poses(model, truth.placed.joints)[model.required.name]
    true = (truth.placed.T_camera_object @ root).position
    size_m = max(float(np.ptp(marker.outline, axis=0).max()) for marker in model.required.markers)
    size_px = size_m * frame.camera.focal_px / max(true[2], 1e-6)
    return is_near(claimed, true, size_px, frame)


def is_near(claimed: Array, true: Array, size_px: float, frame: SimulatedFrame) -> bool:
    """Whether a claimed place (3,) is as far off the true one (3,) as what is so large may be."""
    off_px = np.linalg.norm(np.diff(project(frame.camera, np.stack([claimed, true])), axis=0))
    off_range = abs(np.linalg.norm(claimed) / np.linalg.norm(true) - 1)
    return bool(off_px <= SIZE_SHARE * size_px + SIZE_PX and off_range <= max(RANGE_SHARE, RANGE_PX / size_px))


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
    if verdict.case.startswith("unseen"):
        return is_there(verdict, truth, frame)
    if placed.target.name == PATTERN:  # any of its markers may be where another one is
        poses = verdict.claim.poses
        return same_places(model, Pose(poses.R[0], poses.t[0]), placed.T_camera_object)
    claimed = shown_centre(verdict)
    T = placed.T_camera_object @ component_poses(model, placed.joints)[model.required.name]
    for seen in truth.markers:
        if seen.component != model.required.name:
            continue
        true, size_px = T.apply(model.required.marker(seen.marker).centre[None])[0], max(seen.full_px, 1.0) ** 0.5
        if is_near(claimed, true, size_px, frame):
            return True
    return False


@dataclass(frozen=True)
class Claims:
    """n claims.

    :param world: (n,) their worlds' numbers. :param final: (n,) bool: of those that pixels were shared out among; else
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
    def of(cls, world: int, rows: list[tuple[bool, Verdict, bool]]) -> Claims:
        final, verdicts, right = zip(*rows, strict=True) if rows else ((), (), ())
        return cls(
            np.full(len(rows), world),
            np.array(final, bool),
            np.array([v.case.split(", ")[-1] for v in verdicts], "<U24"),
            np.array(right, float),
            np.array([v.probability for v in verdicts]),
            np.array([v.evidence for v in verdicts], float).reshape(len(rows), len(Evidence._fields)),
        )

    def __getitem__(self, rows: NDArray) -> Claims:
        return Claims(**{name: values[rows] for name, values in vars(self).items()})


@dataclass(frozen=True)
class Parts:
    """n components, but the required ones, of likely claims.

    :param world, right, score: as of `Claims`. :param evidence: (n, columns) `PartEvidence`.
    """

    world: NDArray[np.int_]
    right: Array
    score: Array
    evidence: Array

    @classmethod
    def of(cls, world: int, rows: list[tuple[float, PartEvidence, bool]]) -> Parts:
        score, evidence, right = zip(*rows, strict=True) if rows else ((), (), ())
        table = np.array(evidence, float).reshape(len(rows), len(PartEvidence._fields))
        return cls(np.full(len(rows), world), np.array(right, float), np.array(score, float), table)

    def __getitem__(self, rows: NDArray) -> Parts:
        return Parts(**{name: values[rows] for name, values in vars(self).items()})


T = TypeVar("T", Claims, Parts)


def joined(parts: Sequence[T]) -> T:
    return type(parts[0])(*(np.concatenate([getattr(p, name) for p in parts]) for name in vars(parts[0])))


def save(file: Path, claims: Claims, parts: Parts) -> None:
    np.savez(file, **vars(claims), **{f"part_{name}": values for name, values in vars(parts).items()})


def load(files: Sequence[Path]) -> tuple[Claims, Parts]:
    found = [np.load(f) for f in files]
    claims = [Claims(**{name: f[name] for name in Claims.__annotations__}) for f in found]
    return joined(claims), joined([Parts(**{name: f[f"part_{name}"] for name in Parts.__annotations__}) for f in found])


class Watcher:
    """Searches scenes for some targets, and notes which claims and which of their components are right."""

    def __init__(self, targets: Sequence[Target], required: str = "strict", codes: Codes = LABELS) -> None:
        """:param codes: what pixels' codes say of their labels."""
        self._config = RecognizerConfig(min_component_probability=0.0, required=required)
        self._finders = [WholeObjectFinder(t, self._config, codes) for t in targets]
        self._describers = {f.target.name: Describer(f) for f in self._finders}
        self.claims: list[tuple[bool, Verdict, bool]] = []
        self.parts: list[tuple[float, PartEvidence, bool]] = []

    def look(self, frame: SimulatedFrame) -> None:
        """Search a scene by its labels."""
        self.search(frame, ImageFrame(LabelField(frame.labels), frame.camera))

    def search(self, frame: SimulatedFrame, image: ImageFrame) -> None:
        """Search an image of a scene. Of several claims at an object's place only the first accepted one, the one with
        the most votes, is right."""
        judge = Recorder.of(self._config)
        assert isinstance(judge, Recorder)
        blobs = find_blobs(
            image.field.labels,
            {label for f in self._finders for labels in f.surface.labels for label in labels},
            self._config,
        )
        search = SpatialSearch(image, judge, self._config.search)
        shared = share_out(search.run(self._finders, blobs), image, judge)
        self._note(judge, *shared[:2], frame.truths, image, lambda verdict, truth: is_at(verdict, truth, frame))
        for verdict in judge.noted:
            if judge.shows_required(verdict):
                self.claims.append((False, verdict, any(is_at(verdict, truth, frame) for truth in frame.truths)))

    def _note(
        self,
        judge: Judge,
        accepted: Sequence[Verdict],
        others: Sequence[Verdict],
        truths: Sequence[ObjectTruth],
        image: ImageFrame,
        is_right: Callable[[Verdict, ObjectTruth], bool],
    ) -> None:
        left = list(truths)
        for verdict in (*accepted, *(v for v in others if judge.shows_required(v))):
            there = next((truth for truth in left if is_right(verdict, truth)), None)
            self.claims.append((True, verdict, there is not None))
            if verdict.probability > LIKELY_ENOUGH:
                self._note_parts(verdict, there, image)
            if there is not None:
                left = [truth for truth in left if truth is not there]

    def _note_parts(self, verdict: Verdict, truth: ObjectTruth | None, image: ImageFrame) -> None:
        """A component is right where it is told within a third of its size of where the image shows it. Of a pattern of
        equal markers each is as good as another."""
        surface, pattern = verdict.claim.finder.surface, verdict.claim.finder.target.name == PATTERN
        rows = part_evidence(verdict)
        numbers = {component.name: c for c, component in enumerate(surface.model.components)}
        for part in self._describers[verdict.claim.finder.target.name].describe([verdict], image)[0].components:
            c = numbers[part.component]
            if c != verdict.claim.finder.root and c in rows:  # else only a pose at rest shows it
                seen = [m for m in truth.markers if pattern or m.component == part.component] if truth else []
                right = any(_is_on(np.array([part.x, part.y]), m) for m in seen)
                self.parts.append((part.score, rows[c], right))


def _is_on(place: Array, marker: MarkerTruth) -> bool:
    least = SIZE_SHARE * max(marker.full_px, 9.0) ** 0.5 + SIZE_PX
    return marker.centre is not None and float(np.linalg.norm(place - marker.centre)) <= least


def watch(first: int, worlds: int, scenes: int) -> tuple[Claims, Parts]:
    """Claims, and components of claims, in the scenes of so many worlds. In half of them an object may be one whose
    required component is out of sight."""
    claims, parts = [], []
    for number in tqdm(range(first, first + worlds), desc="worlds", disable=None):
        targets, frames = _world(number, scenes)
        watcher = Watcher(targets, "visible" if number // 2 % 2 else "strict")
        for frame in frames:
            watcher.look(frame)
        claims.append(Claims.of(number, watcher.claims))
        parts.append(Parts.of(number, watcher.parts))
    return joined(claims), joined(parts)


def _world(number: int, scenes: int) -> tuple[Sequence[Target], Iterator[SimulatedFrame]]:
    """Targets and scenes: every sixth world has a pattern of equal markers, as even-numbered as odd-numbered ones."""
    if number % 12 in (4, 9):
        pattern = random_pattern(number)
        return [pattern.target], pattern_frames(pattern, number, scenes)
    world = random_world(number)
    return world.targets, random_frames(world, number, scenes)
