"""Which other objects of its own target may be there instead of one, as where another like patch lies beside a part."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import compress

import numpy as np
from numpy.typing import NDArray

from ..image.image_frame import ImageFrame
from ..pose.finder import WholeObjectFinder
from ..pose.poses import Poses
from .claims import left_by
from .judge import Judge
from .verdicts import Verdict, Verdicts


def of_its_target(
    verdict: Verdict, rivals: Sequence[Verdict], others: Sequence[Verdict], judge: Judge
) -> list[Verdict]:
    """Rivals of an object's own target, as they are judged beside all others, that explain what it does, too, and what
    these and it leave, as a part that it shows elsewhere; of several that explain the same the best, which comes first.

    How else it may lie on what it explains is asked of what is told of it, and so is what it lacks.
    """
    finder, turn = verdict.finder, verdict.finder.config.search.niche_rad
    poses, out = Poses.concatenate([v.poses for v in rivals]), list[Verdict]()
    poses = poses[~finder.required.is_in_place_of(poses, verdict.poses, turn)[:, 0]]
    frame = left_by(verdict.claim.frame.unowned.unhurried(), [v.claim for v in others])
    left, may_be = left_by(frame, [verdict.claim]), _as_large(judge, finder, poses, frame, verdict.wider_px)
    while may_be:
        again = judge.verdicts(finder, Poses.concatenate([v.poses for v in may_be]), left)
        free, alone = _shows(again), np.array([v.confirmed for v in may_be])
        both = (alone & ~free).any(axis=1) & (free & np.array(verdict.confirmed)).any(axis=1)
        may_be = list(compress(may_be, both.tolist()))
        if may_be:
            out.append(replace(may_be[0], owners=verdict.owners))
            left = left_by(left, [may_be[0].claim])
    return out


def _shows(verdicts: Verdicts) -> NDArray[np.bool_]:
    """(H, C) which components are confirmed by pixels most of which nobody owns."""
    claims, rows = verdicts.claims, np.arange(len(verdicts))[:, None]
    free_px, full_px = (px[rows, np.maximum(verdicts.shown, 0)] for px in (claims.scores.area_px, claims.seen.full_px))
    least = 1 - claims.finder.config.search.explained
    return np.asarray(np.asarray(verdicts.confirmed, bool) & (free_px >= least * full_px))


def _as_large(
    judge: Judge, finder: WholeObjectFinder, poses: Poses, frame: ImageFrame, wider_px: float
) -> list[Verdict]:
    """Verdicts on those of some poses that are objects, be it with markers that look larger, as another's do."""
    verdicts = judge.verdicts(finder, poses, frame)
    looks = [(verdicts, judge.worth(verdicts), 0.0), *(judge.swollen(verdicts) if wider_px else ())]
    best = np.argmax([worth for _, worth, _ in looks], axis=0).tolist()
    chosen = [(*looks[b], n) for n, b in enumerate(best)]
    found = [replace(v[n], wider_px=px, alone=v[n].probability) for v, worth, px, n in chosen if worth[n] > 0]
    return [v for v in found if judge.tells(v)]


def side_by_side(rivals: Sequence[Verdict], finder: WholeObjectFinder, judge: Judge) -> list[Verdict]:
    """Rivals of an object of their own target that are objects beside each other, one of which comes first; none: any
    excludes all others. Together they explain what an object does that shares something with each, and more."""
    mine = [] if finder.alternatives.unique else rivals
    for first in mine if len(mine) > 1 else ():
        out = [first]
        for other in (v for v in mine if v is not first):
            left = left_by(other.claim.frame, [v.claim for v in out])
            again = judge.verdicts(finder, other.poses, left)
            if judge.worth(again)[0] > 0 and again[0].confirmed == other.confirmed:
                out.append(replace(again[0], owners=(*other.owners, *out), alone=other.alone))
        if len(out) > 1:
            return out
    return []


def is_same(verdict: Verdict, other: Verdict) -> bool:
    """Whether both are about one candidate."""
    own, its = verdict.poses, other.poses
    same = verdict.finder is other.finder and np.array_equal(own.t, its.t) and np.array_equal(own.R, its.R)
    return same and np.array_equal(own.q, its.q)
