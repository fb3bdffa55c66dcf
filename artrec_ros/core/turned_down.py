"""What is said of a frame besides its objects: candidates that were turned down, and blobs that led to none."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import islice

import numpy as np

from .geometry.projection import project
from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .model.found import Detection
from .model.frame_result import Rejection
from .model.target import Target
from .pose.finder import WholeObjectFinder
from .verdict.claims import Claim, left_by
from .verdict.identity import NOT_FIRST
from .verdict.judge import Judge
from .verdict.offers import Told
from .verdict.verdicts import Verdict

_MOST = 3  # are told of each object, the largest: what an image is full of is clutter
_AROUND_PX = 2.0  # of a blob's bounding box: seams


def turned_down(
    frame: ImageFrame,
    judge: Judge,
    told: Told,
    finders: Sequence[WholeObjectFinder],
    blobs: Sequence[Blob],
) -> Iterator[Rejection]:
    """Of every candidate the reason, and of large blobs that nothing explains that there was no candidate.

    :param told: what is told of the frame.
    :param blobs: that were looked at, as far as `finders` look for their class.
    """
    rejected = [_rejection_of(v, frame, judge, NOT_FIRST, told.shares.get(v)) for v in told.surplus]
    rejected += [_rejection_of(v, frame, judge) for v in told.shared.others]
    yield from rejected
    yield from _unexplained(frame, finders, blobs, [v.claim for v in told.shared.accepted], rejected)


def _rejection_of(
    verdict: Verdict,
    frame: ImageFrame,
    judge: Judge,
    otherwise: str = "its pixels belong to another",
    share: float | None = None,
) -> Rejection:
    """Why a claim became no object. :param otherwise: where nothing speaks against it by itself. :param share: how
    probable it is beside others; None: as by itself."""
    x, y = project(frame.camera, verdict.claim.poses.t)[0]
    name, reason = verdict.claim.finder.target.name, judge.reason(verdict)
    return Rejection(name, reason or otherwise, verdict.probability if share is None else share, float(x), float(y))


def _unexplained(
    frame: ImageFrame,
    finders: Sequence[WholeObjectFinder],
    blobs: Sequence[Blob],
    accepted: Sequence[Claim],
    rejected: Sequence[Rejection],
) -> Iterator[Rejection]:
    """The largest blobs of each object's required component that no accepted claim explains, and in which nothing lies
    that was turned down."""
    places = np.array([(r.x, r.y) for r in rejected]).reshape(-1, 2)
    left = left_by(frame, accepted).field
    for finder in finders:
        free = (b for b in _largest(finder.target, blobs, places)
                if left.owned_inside(b.pixels) < finder.config.search.explained)  # fmt: skip
        yield from _without(finder.target, free, "no candidate is left in")


def unmatched(
    targets: Sequence[Target],
    blobs: Sequence[Sequence[Blob]],
    detections: Sequence[Detection],
    rejected: Sequence[Rejection],
) -> Iterator[Rejection]:
    """The same of targets that are found by their outlines and constraints.

    :param blobs: of each target those that no outline of its required component fits.
    """
    seen = [(c.x, c.y) for d in detections for c in d.components] + [(r.x, r.y) for r in rejected]
    for target, mine in zip(targets, blobs, strict=True):
        largest = _largest(target, mine, np.array(seen).reshape(-1, 2))
        yield from _without(target, largest, f"no outline of '{target.model.required.name}' fits")


def _largest(target: Target, blobs: Sequence[Blob], places: np.ndarray) -> Iterator[Blob]:
    """Blobs of the required component's class in which none of these places (n, 2) lies, the largest first."""
    mine = sorted((b for b in blobs if b.label in target.root_labels), key=lambda b: -b.area_px)
    return (b for b in mine if not _holds(b, places))


def _without(target: Target, blobs: Iterator[Blob], what: str) -> Iterator[Rejection]:
    """That the first few of some blobs led to nothing. :param what: is said of each."""
    for blob in islice(blobs, _MOST):
        x, y = blob.middle.tolist()
        yield Rejection(target.name, f"{what} this blob of {blob.area_px:.0f} pixels of its class", 0.0, x, y)


def _holds(blob: Blob, places: np.ndarray) -> bool:
    """Whether one of these places (n, 2) lies in its bounding box."""
    low, high = blob.box[0] - _AROUND_PX, blob.box[1] + 1 + _AROUND_PX
    return bool(((places >= low) & (places <= high)).all(axis=1).any())
