"""How probable told poses in space are among those that lay like markers on what is seen of them.

Nothing that is seen tells these apart, but where the others would be tells something: what should be in view and is not
speaks against a pose, what is out of view does not.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .finder import WholeObjectFinder
from .poses import Poses
from .turn_evidence import odds_by_seen
from .unseen import in_view, log_unseen


def shares_beside(log_odds: Array | Sequence[float]) -> Array:
    """(1 + K,) probabilities of what is told, and of K others of such log odds against it."""
    worth = np.append(0.0, log_odds)
    return np.asarray(np.exp(worth - np.logaddexp.reduce(worth)))


class LaidOtherwise(NamedTuple):
    """Of one object. :ivar poses: (K,) other ones. :ivar log_odds: (K,) that each is the true one, not the told one."""

    poses: Poses
    log_odds: Array

    def shares(self) -> Array:
        """(1 + K,) probabilities of the one that is told, and of these."""
        return shares_beside(self.log_odds)

    def told_as(self, row: int, pose: Poses) -> LaidOtherwise:
        """Of the object that is told as one of these. :param pose: as it was told."""
        poses = Poses.concatenate([self.poses[:row], pose, self.poses[row + 1 :]])
        log_odds = self.log_odds - self.log_odds[row]
        log_odds[row] = -self.log_odds[row]
        return LaidOtherwise(poses, log_odds)

    def as_found(self) -> LaidOtherwise:
        """Of the object that is told as it was found for all that."""
        return self._replace(log_odds=np.minimum(self.log_odds, 0.0))


def likelier_laid(
    finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_]
) -> tuple[Poses, Sequence[LaidOtherwise | None], Sequence[LaidOtherwise | None]]:
    """H poses at rest, laid otherwise where that is clearly likelier; how else each may be laid, and how else those may
    that were found.

    :param used: (H, M) markers that the labels support.
    """
    return told_likelier(poses, [_others(finder, frame, poses[h : h + 1], used[h]) for h in range(len(poses))])


def told_likelier(
    poses: Poses, found: Sequence[LaidOtherwise | None]
) -> tuple[Poses, Sequence[LaidOtherwise | None], Sequence[LaidOtherwise | None]]:
    """The likeliest of H poses and of how else each may lie; how else each of these may, and those that were found."""
    told, out = [poses[h : h + 1] for h in range(len(poses))], list(found)
    for h, laid in enumerate(found):
        if laid is not None and laid.log_odds.max() > 0:
            row = int(np.argmax(laid.log_odds))
            told[h], out[h] = laid.poses[row : row + 1], laid.told_as(row, told[h])
    moved = any(a is not b for a, b in zip(found, out, strict=True))
    return Poses.concatenate(told) if moved else poses, out, [laid and laid.as_found() for laid in found]


def _others(finder: WholeObjectFinder, frame: ImageFrame, pose: Poses, used: NDArray[np.bool_]) -> LaidOtherwise | None:
    """Those with votes enough; likelier ones but a little are as likely, as mirrored turns are."""
    if finder.laid_alike is None or frame.deadline.expired:
        return None
    others = finder.laid_alike.of(pose, used)
    if finder.on_likes.any:  # it has joints, and of such the former knows none
        seen = {*finder.surface.component[finder.surface.markers[used]].tolist()}
        others = finder.on_likes.of(frame, pose, seen)
    both = Poses.concatenate([pose, others[np.flatnonzero(frame.scene.stand(others.R, others.t))]])
    if len(both) == 1:
        return None
    config, scores = finder.config.verdict, finder.voter.judge(frame, both, occlusion=True)
    fitted = finder.on_likes.any
    votes = finder.voter.borne_out(scores)
    unseen = log_unseen(finder, in_view(finder, frame, both, scores).lacking)
    rows = np.append(0, np.flatnonzero(votes[1:] > config.mirrored_votes * votes[0]) + 1)
    told, both, log_odds = both[rows[:1]], both[rows[1:]], (unseen - unseen[0])[rows[1:]]
    if not len(both):
        return None
    log_odds = log_odds + odds_by_seen(finder, frame, told[np.zeros(len(both), int)], both)
    likelier = log_odds > config.least_turn_odds
    if fitted and used.all():  # what looks the same throughout is another place only where it is likelier
        kept = np.flatnonzero(likelier | ~finder.on_likes.same(frame.camera, pose, both))
        both, log_odds, likelier = both[kept], log_odds[kept], likelier[kept]
    if fitted:
        kept = finder.on_likes.distinct(frame.camera, pose, both, log_odds)
        both, log_odds, likelier = both[kept], log_odds[kept], likelier[kept]
    return LaidOtherwise(both, np.where(likelier, log_odds, np.minimum(log_odds, 0.0))) if len(both) else None
