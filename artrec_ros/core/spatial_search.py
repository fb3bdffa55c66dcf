"""Search of one image for whole objects of all targets, blob by blob; a sure object takes its pixels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial

from .base.deadline import Deadline
from .geometry.camera import Camera
from .image.blobs import Blob
from .image.label_field import LabelField
from .pose.finder import WholeObjectFinder
from .pose.surface_model import Poses
from .verdict.acceptance import Verdict, verdict_of
from .verdict.claims import claims_of, silhouette

SURE = 0.999  # trust in an object whose pixels are not searched for others
LIKELY = 0.995  # in one whose blobs need not be looked at again
EXPLAINED = 0.6  # of a blob's contour must be a sure or a likely object's


class SpatialSearch:
    """What is found so far, and the image without the pixels of sure objects.

    :param trust: in a claim by its verdict, 0 to 1.
    :param least: votes of a claim worth looking at.
    """

    def __init__(
        self, field: LabelField, camera: Camera, deadline: Deadline, trust: Callable[[Verdict], float], least: float
    ) -> None:
        self._field, self._camera, self._deadline = field, camera, deadline
        self._trust, self._least = trust, least
        self._found: dict[WholeObjectFinder, list[Poses]] = {}
        self._unexplained: dict[WholeObjectFinder, LabelField] = {}  # without the pixels of its likely objects, too
        # found, and whether sure; its pixels are still in the fields
        self._to_hide: tuple[WholeObjectFinder, Poses, bool] | None = None

    def run(self, finders: Sequence[WholeObjectFinder], blobs: Sequence[Blob]) -> list[tuple[WholeObjectFinder, Poses]]:
        """Candidates of each target: first objects in plain view, then what takes more to find; the largest blobs
        first."""
        queue = [(f, b) for f in finders for b in blobs if b.label == f.root_label]
        queue.sort(key=lambda fb: -fb[1].area_px)
        for find in (WholeObjectFinder.find_plain, WholeObjectFinder.find):
            left = []
            for finder, blob in queue:
                if self._over(finder, blob):
                    continue
                poses = find(finder, self._field, self._camera, blob, self._deadline, self._sure(finder))
                if not self._take(finder, poses):
                    left.append((finder, blob))
            queue = left
        return [(finder, Poses.concatenate(poses)) for finder, poses in self._found.items()]

    def _over(self, finder: WholeObjectFinder, blob: Blob) -> bool:
        """Whether nothing of a blob is left to explain, or no time for it."""
        if self._deadline.expired:
            return True
        self._hide_found()
        return self._unexplained.get(finder, self._field).owned_share(blob.contour) > EXPLAINED

    def _sure(self, finder: WholeObjectFinder) -> Callable[[Poses], bool]:
        return lambda pose: self._trust_in(finder, pose) > SURE

    def _trust_in(self, finder: WholeObjectFinder, pose: Poses) -> float:
        if not len(pose):
            return 0.0
        (claim,) = claims_of(finder, pose, self._field, self._camera)
        return self._trust(verdict_of(claim)) if claim.votes > self._least else 0.0

    def _take(self, finder: WholeObjectFinder, poses: Poses) -> bool:
        """Keep hypotheses, the best one first; whether that is a sure object, which takes its pixels.

        A likely one may share them with a rival, but its own target's is not sought for them again.
        """
        self._found.setdefault(finder, []).append(poses)
        trust = self._trust_in(finder, poses[:1])
        if trust > LIKELY:
            self._to_hide = finder, poses[:1], trust > SURE
        return trust > SURE

    def _hide_found(self) -> None:
        """Take the pixels of what was found last: put off until there is another blob to look at."""
        if self._to_hide is None:
            return
        (finder, pose, sure), self._to_hide = self._to_hide, None
        rest = cache(partial(LabelField.without, solids=silhouette(finder.surface, self._camera, pose)))
        self._unexplained.setdefault(finder, self._field)
        for other in self._unexplained if sure else (finder,):
            self._unexplained[other] = rest(self._unexplained[other])  # several finders may still share one
        if sure:
            self._field = rest(self._field)
