"""Recognition of spatial objects in one frame: candidates of all targets, their pixels shared out, verdicts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from .acceptance import Verdict, verdict_of
from .blobs import Blob
from .config import RecognizerConfig
from .covariance import pose_covariance
from .datatypes import Camera, Detection, ImagePose, Instance, Rejection, Target
from .deadline import Deadline
from .evidence import LabelField
from .ownership import Claim, share_out
from .projection import project
from .spatial_search import SpatialSearch
from .surface import Patch
from .transforms import Array, Pose
from .whole_object import WholeObjectFinder


class SpatialStage:
    """Finds the targets whose markers have places in space, in images of a calibrated camera."""

    def __init__(self, targets: Sequence[Target], config: RecognizerConfig) -> None:
        self._finders = [WholeObjectFinder(t) for t in targets]
        self._config = config
        for finder in self._finders:
            finder.warm_up()

    def recognize(
        self, labels: np.ndarray, blobs: Sequence[Blob], camera: Camera, deadline: Deadline
    ) -> tuple[tuple[Detection, ...], tuple[Rejection, ...]]:
        """Detections by target and score, and what was turned down, with reasons."""
        field = LabelField(labels)
        least = self._config.min_votes
        found = SpatialSearch(field, camera, deadline, self._trust, least).run(self._finders, blobs)
        accepted, others = share_out(found, field, camera, least, self._trust)
        detections: list[Detection] = []
        for finder in self._finders:
            mine_c = [self._settled(c, field, camera) for c in accepted if c.finder is finder]
            mine_v = sorted((verdict_of(c) for c in mine_c), key=lambda v: -v.probability)
            detections += [_detection(v, n, camera, field) for n, v in enumerate(mine_v)]
        return tuple(detections), tuple(self._rejection(verdict_of(c), camera) for c in others)

    def _settled(self, claim: Claim, field: LabelField, camera: Camera) -> Claim:
        return replace(claim, poses=claim.finder.settled(field, camera, claim.poses, claim.scores))

    def _trust(self, claim: Claim) -> float:
        verdict = verdict_of(claim)
        return verdict.probability if verdict.is_object(self._config) else 0.0

    def _rejection(self, verdict: Verdict, camera: Camera) -> Rejection:
        x, y = project(camera, verdict.claim.poses.t)[0]
        name, reason = verdict.claim.finder.target.name, verdict.reason(self._config) or "its pixels belong to another"
        return Rejection(name, reason, verdict.probability, float(x), float(y))


def _detection(verdict: Verdict, number: int, camera: Camera, field: LabelField) -> Detection:
    claim = verdict.claim
    finder, poses = claim.finder, claim.poses
    model, kin = finder.target.model, finder.surface.kinematics
    parts = _instances(verdict, camera)
    root = next(p for p in parts if p.component == model.required.name)
    seen = [c for c, patch in enumerate(verdict.shown) if patch >= 0]
    told = np.atleast_1d(kin.moves[seen].any(axis=0))  # joints that move a component in view
    joints = {c.name: float(poses.q[0, j]) for j, c in enumerate(model.joint_components) if told[j]}
    used = finder.supported(claim.scores)
    covariance = pose_covariance(finder.surface, field, camera, poses, used)
    return Detection(
        finder.target.name,
        number,
        verdict.probability,
        ImagePose(root.x, root.y, root.theta, root.scale),
        parts,
        Pose(poses.R[0], poses.t[0]),
        joints,
        covariance,
    )


def _instances(verdict: Verdict, camera: Camera) -> tuple[Instance, ...]:
    """Components as the image shows them: where part of a marker is hidden, x, y are the visible part's centre."""
    surface, poses = verdict.claim.finder.surface, verdict.claim.poses
    frames = surface.kinematics.forward(poses.R, poses.t, poses.q)
    shown = [p for p in verdict.shown if p >= 0]
    patches = [surface.patches[p] for p in shown]
    points = [np.concatenate([p.inside, p.drawn]) for p in patches]
    R, t = frames.R[0], frames.t[0]
    X = np.concatenate([on @ R[p.component].T + t[p.component] for on, p in zip(points, patches, strict=True)])
    sizes = [len(on) for on in points]
    pixels, (height, width) = project(camera, X), verdict.claim.shape
    seen = ~surface.boxes.hidden(frames, X[None], surface.ignored[np.repeat(shown, sizes)])[0]
    seen &= (pixels > -0.5).all(axis=1) & (pixels[:, 0] < width - 0.5) & (pixels[:, 1] < height - 0.5)
    f, ends = np.sqrt(camera.matrix[0, 0] * camera.matrix[1, 1]), np.cumsum(sizes)[:-1]
    parts = zip(shown, patches, np.split(pixels, ends), np.split(seen, ends), strict=True)
    return tuple(_instance(verdict, i, p, px, on, float(f / max(t[p.component, 2], 1e-6))) for i, p, px, on in parts)


def _instance(verdict: Verdict, index: int, patch: Patch, pixels: Array, seen: np.ndarray, scale: float) -> Instance:
    """The component that patch `index` shows; pixels (n, 2) of its `inside` and `drawn`, (n,) in view."""
    claim, n = verdict.claim, len(patch.inside)
    assert patch.marker is not None  # what shows a component is a marker
    inside, (centroid, tail, head), outline = pixels[:n][seen[:n]], pixels[n : n + 3], pixels[n + 3 :]
    centre = inside.mean(axis=0) if len(inside) else centroid
    axis = head - tail
    return Instance(
        claim.finder.target.model.components[patch.component].name,
        patch.marker.name,
        min(max(float(claim.scores.agree[0, index]), 0.0), 1.0),
        float(centre[0]),
        float(centre[1]),
        float(np.arctan2(axis[1], axis[0])),
        scale,
        outline,
    )
