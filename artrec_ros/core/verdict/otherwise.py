"""What else may be true of a detection than what is told, and what that costs the telling."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..geometry.camera import Camera
from ..geometry.transforms import Array, Pose, short_way
from ..model.found import Detection, Missing, OtherTurn
from ..pose.along_joints import Bent
from ..pose.exchanges import OFF
from ..pose.finder import WholeObjectFinder
from ..pose.other_ways import LEAST_BEND
from ..pose.poses import Poses
from .other_blobs import OnOthers


def otherwise(
    detection: Detection, elsewhere: OtherTurn | None, other: OtherTurn | None, way: OtherTurn | None
) -> Detection:
    """A detection with what else may be true of it.

    :param elsewhere: where it may lie as well, which covariance and deviations alone tell. :param other: another turn.
    :param way: another way to bend it.
    """
    if elsewhere is not None:
        detection = replace(_beside(detection, elsewhere), other_turn=None)
    if other is not None:
        detection = as_it_lies(detection, 1 - other.sides)
    return _beside_way(_beside(detection, other), way)


def as_it_lies(detection: Detection, share: float) -> Detection:
    """A detection that may lie otherwise: one that would be none turned as its pixels are likelier, or one that shows
    another of its like sides. It is there, but its name may be that of its turns, and its components others'.

    :param share: how probable it is that it lies as it is told.
    """
    if share == 1:
        return detection
    parts = tuple(part.rated(part.score * share) for part in detection.components)
    as_told = detection.as_told * share
    return replace(detection, score=detection.score * share, as_told=as_told, components=parts)


def bent_otherwise(detection: Detection, bent: Bent) -> Detection:
    """A detection of which a joint may be elsewhere: so may be the components that it carries."""
    if not bent.stays:
        return detection
    parts = tuple(part.rated(part.score * bent.stays.get(part.component, 1.0)) for part in detection.components)
    deviations = {
        name: float(np.sqrt(deviation**2 + bent.variance.get(name, 0.0)))
        for name, deviation in detection.joint_deviations.items()
    }
    return replace(detection, components=parts, joint_deviations=deviations)


def on_other_blobs(
    finder: WholeObjectFinder, found: OnOthers | None, pose: Poses, camera: Camera, detection: Detection
) -> Detection:
    """A detection told at a pose of which something may be on another blob: so may be what it carries, and of each
    component the likeliest other blob is told."""
    if found is None:
        return detection
    kin, others = finder.surface.kinematics, found.bends.poses
    shares, of = found.shares(finder.config.verdict.least_turn_odds), finder.surface.component[finder.surface.markers]
    at, size_px = finder.on_likes.pixels(camera, Poses.concatenate([pose, others]))
    off = np.linalg.norm(at[1:] - at[0], axis=2) > OFF * size_px[0]
    names = [c.name for c in finder.target.model.components]
    stays = {n: max(1 - float(shares @ off[:, of == c].any(axis=1)), 0.0) for c, n in enumerate(names)}
    bent = shares @ short_way(others.q - pose.q, kin.endless) ** 2
    variance = dict(zip(finder.target.model.joint_names, bent.tolist(), strict=True))
    turned = [finder.strayed(others[n : n + 1], pose) >= 1 for n in range(len(others))]
    detection = _turned(bent_otherwise(detection, Bent(stays, variance)), others, shares * turned)
    missing, least = list(detection.missing), finder.config.verdict.least_other_turn
    for c in dict.fromkeys(found.components):
        share, row = max((s, n) for n, s in enumerate(shares.tolist()) if found.components[n] == c)
        x, y = found.blobs[row].middle.tolist()
        if share > least * (share + stays[names[c]]) and all(m.component != names[c] for m in missing):
            missing.append(Missing(names[c], "elsewhere", x, y, score=share))
    return replace(detection, missing=tuple(missing))


def _turned(detection: Detection, others: Poses, shares: Array) -> Detection:
    """A detection that may be turned otherwise. :param shares: (K,) how probable each other pose is, of which it is."""
    stays = max(1 - float(shares.sum()), 0.0)
    if stays == 1:
        return detection
    covariance = detection.pose_covariance
    if covariance is not None and detection.pose is not None:
        for n in np.flatnonzero(shares).tolist():
            other = OtherTurn(Pose(others.R[n], others.t[n]), float(shares[n]))
            covariance = covariance + other.probability * other.spread(detection.pose)
    score, as_told = detection.score * stays, detection.as_told * stays
    return replace(detection, score=score, as_told=as_told, pose_covariance=covariance)


def _beside(detection: Detection, other: OtherTurn | None) -> Detection:
    """A detection in space, with another pose that may be the true one: its joints are those that are told."""
    if other is None or detection.pose is None or detection.pose_covariance is None:
        return detection
    other = replace(other, joints={name: q for name, q in other.joints.items() if name in detection.joints})
    return detection.beside(other, other.probability)


def _beside_way(detection: Detection, way: OtherTurn | None) -> Detection:
    """A detection with another way to bend it: in space beside it, as far as none is; of what is found flat as less
    probable to be as it is told."""
    if way is None:
        return detection
    if detection.pose_covariance is not None:
        other = _beside(detection, way)
        return other if detection.other_turn is None else replace(other, other_turn=detection.other_turn)
    if not any(abs(way.joints[name] - q) > LEAST_BEND for name, q in detection.joints.items()):
        return detection  # nothing that is told would be otherwise
    share = 1 - way.probability
    return replace(detection, score=detection.score * share, as_told=detection.as_told * share)
