"""Where a told pose may rest otherwise: without what seems to end one of its markers.

Something unknown that lies over part of a marker ends it as its own outline would. A fit to all contours that begins
where such a marker looks whole comes to rest there, smaller, farther or turned, and the other markers give way. What
these say without it leads to the other rest, and where they are few, what all say without one of its ends
(hidden_ends.py); votes and contours of all tell which of the two is right, as they do of mirrored turns.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..image.image_frame import ImageFrame
from ..model.found import OtherTurn
from .distinct import is_near
from .finder import WholeObjectFinder
from .other_turns import other_of
from .poses import PatchScores, Poses
from .turn_evidence import turn_odds, weighed

_LEAST_OTHERS = 2  # markers that tell where an object is without one


def likelier_rests(
    finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_]
) -> tuple[Poses, NDArray[np.bool_], Sequence[OtherTurn | None]]:
    """H poses at rest on what the image shows, elsewhere where that is clearly likelier; the markers used of each; and
    where it may be otherwise.

    :param used: (H, M) markers whose contours tell where they are.
    """
    elsewhere: list[OtherTurn | None] = [None] * len(poses)
    if frame.deadline.expired:
        return poses, used, elsewhere
    hurried, frame = frame, frame.unhurried()
    covered, of_covered = _without_covered(finder, frame, poses, used)
    hidden, of_hidden = poses[:0], of_covered[:0]
    if finder.hidden_ends is not None:
        hidden, of_hidden = finder.hidden_ends.of(hurried, poses, used)
    rests, of = Poses.concatenate([covered, hidden]), np.concatenate([of_covered, of_hidden])
    stand = np.flatnonzero(frame.scene.stand(rests.R, rests.t))
    rests, of = rests[stand], of[stand]
    if not len(of):
        return poses, used, elsewhere
    used_there, log_odds = finder.voter.supports(frame, rests), turn_odds(finder, frame, poses[of], rests)
    likelier, probabilities = weighed(log_odds, finder.config.verdict.least_turn_odds)
    both, rows, used = Poses.concatenate([poses, rests]), np.arange(len(poses)), used.copy()
    # of several the likeliest one counts, but none that is back where it began, if it is not told in its place
    counts = likelier | ~is_near(rests, poses[of], *finder.config.verdict.end_apart)
    for k in np.lexsort((log_odds, counts)).tolist():
        h, other = int(of[k]), len(poses) + k
        rows[h], used[h] = (other, used_there[k]) if likelier[k] else (h, used[h])
        elsewhere[h] = other_of(finder, both, int(rows[h]), h if likelier[k] else other, float(probabilities[k]))
    return both[rows], used, elsewhere


def _without_covered(
    finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, used: NDArray[np.bool_]
) -> tuple[Poses, NDArray[np.int64]]:
    """At rest begun without the marker that lacks most of its label, and of which of H poses each is."""
    row, marker = _partly_covered(finder, finder.voter.judge(frame, poses, occlusion=True), used)
    without = used[row]
    without[np.arange(len(row)), marker] = False
    if not len(row):
        return poses[:0], row
    started = finder.rest.fitted(frame, poses[row], without)
    return finder.rest.at_rest(frame, started, finder.voter.supports(frame, started)), row


def _partly_covered(
    finder: WholeObjectFinder, scores: PatchScores, used: NDArray[np.bool_]
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Which pose's (N,) which marker (N,) lacks most of its label, where that is more than a rim around it can."""
    lacks_px = np.where(used, finder.voter.lacks_px(scores), 0.0)
    marker = np.argmax(lacks_px, axis=1)
    row = np.flatnonzero((lacks_px.max(axis=1) > 0) & (used.sum(axis=1) > _LEAST_OTHERS))
    return row, marker[row]
