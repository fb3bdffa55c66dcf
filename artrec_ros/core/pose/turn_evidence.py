"""What tells which of two poses of an object is the true one, once both are at rest: votes, which count pixels of whole
objects, and how near to contours edges lie, and whether there are any, which is finer, most of all in colour images.

Neither suffices; together they tell how probable each is, as fitted on random objects (`benchmarks/turns.py`).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .finder import WholeObjectFinder
from .pose_fit import but_for_common
from .poses import Poses
from .unseen import in_view

_EXACT_PX = 0.03  # contours as near as that to labels' edges are on them: nothing is told by how much nearer
_SHARES = 0.3, 2.0  # of votes, beyond which more tells nothing


class Evidence(NamedTuple):
    """What speaks for the mirrored turns of H poses, against these.

    :ivar votes: (H,) logarithm of their share of the votes.
    :ivar contours: (H,) signed root of the logarithm of the likelihoods' ratio of the contours that both show.
    :ivar floor: (H,) log odds of them by how both stand on the scene's floor; 0: none is known.
    """

    votes: Array
    contours: Array
    floor: Array | float = 0.0

    def log_odds(self, weights: Sequence[float] | Array) -> Array:
        """(H,) of the mirrored turns. :param weights: without evidence, of votes, of contours."""
        return np.asarray(weights[0] + weights[1] * self.votes + weights[2] * self.contours + self.floor, np.float64)


def turn_odds(
    finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, others: Poses, component: int | None = None
) -> Array:
    """(H,) log odds that another pose is the true one, for each of H poses at rest.

    :param component: by what one component shows alone; None: by all that is known.
    """
    return evidence(finder, frame, poses, others, component).log_odds(weights_of(finder, frame))


def even_odds(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, others: Poses) -> Array:
    """The same of others that show the same in the same places by other markers: before anything is known of them they
    are as likely."""
    return evidence(finder, frame, poses, others).log_odds((0.0, *weights_of(finder, frame)[1:]))


def exchanged_odds(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, others: Poses) -> Array:
    """As `even_odds` of others under which what is seen in one place is another component, each by the markers that it
    shows itself."""
    return evidence(finder, frame, poses, others, exchanged=True).log_odds((0.0, *weights_of(finder, frame)[1:]))


def odds_at_first(finder: WholeObjectFinder, frame: ImageFrame) -> float:
    """Log odds of a turn of what a search has found, before anything is known of it."""
    return weights_of(finder, frame)[0]


def odds_by_seen(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, others: Poses) -> Array:
    """The same of others of which some show as many markers by other ones: these are as likely before anything is known
    of them, and where the ones that they lack would be is no evidence here. What shows fewer leaves some of what is
    seen unexplained."""
    h, both, voter = len(poses), Poses.concatenate([poses, others]), finder.voter
    scores = voter.judge(frame, both, occlusion=True)
    used, seen = voter.supported(scores).reshape(2, h, -1), in_view(finder, frame, both, scores).seen
    count = seen.reshape(2, h, -1).sum(axis=2)
    as_many, shown = count[1] >= count[0], scores.votes[:, finder.surface.marker_columns]
    by_seen = np.where(seen, shown, 0.0).sum(axis=1)
    votes = np.where(as_many, by_seen.reshape(2, h), voter.total(scores).reshape(2, h))
    found = contour_evidence(finder, frame, both, share_of_votes(votes[1], votes[0]), used, np.ones_like(used[0]))
    at_first, *weights = weights_of(finder, frame)
    return found.log_odds((0.0, *weights)) + np.where(as_many, 0.0, at_first)


def weights_of(finder: WholeObjectFinder, frame: ImageFrame) -> Sequence[float]:
    """As of `Evidence.log_odds`."""
    config = finder.config.verdict
    return config.turn_odds_colour if finder.rest.tells_colour_edges(frame) else config.turn_odds


def evidence(
    finder: WholeObjectFinder,
    frame: ImageFrame,
    poses: Poses,
    mirrored: Poses,
    component: int | None = None,
    *,
    exchanged: bool = False,
) -> Evidence:
    """Of poses, and the mirrored turn of each. :param component: as of `turn_odds`. :param exchanged: see
    `contour_evidence`."""
    h, both, surface = len(poses), Poses.concatenate([poses, mirrored]), finder.surface
    scores = finder.voter.judge(frame, both, occlusion=True)
    votes, used = finder.voter.total(scores).reshape(2, h), finder.voter.supported(scores).reshape(2, h, -1)
    differ = np.ones_like(used[0])
    if component is not None:
        votes = scores.votes[:, surface.component == component].sum(axis=1).reshape(2, h)
        differ &= surface.component[surface.markers] == component
    share = share_of_votes(votes[1], votes[0])
    return contour_evidence(finder, frame, both, share, used, differ, exchanged=exchanged)


def weighed(log_odds: Array, least: float | Array) -> tuple[NDArray[np.bool_], Array]:
    """(N,) whether other turns or bends are told in place of those found, and how probable is what is not told.

    :param least: log odds from which on they are.
    """
    turned = log_odds > least
    return turned, 1 / (1 + np.exp(np.where(turned, log_odds, np.maximum(-log_odds, 0.0))))


def share_of_votes(votes: Array, told: Array) -> Array:
    """(H,) of the votes that are told, as far as it tells something."""
    return np.asarray(np.minimum(np.maximum(votes / np.maximum(told, 1e-9), _SHARES[0]), _SHARES[1]), np.float64)


def contour_evidence(
    finder: WholeObjectFinder,
    frame: ImageFrame,
    both: Poses,
    share: Array,
    used: NDArray[np.bool_],
    differ: NDArray[np.bool_],
    *,
    exchanged: bool = False,
) -> Evidence:
    """Of H poses and another one for each, behind them. :param share: (H,) of the votes. :param used: (2, H, M)
    markers that the labels support. :param differ: (H, M) markers that are not in one place under both.
    :param exchanged: what is seen in one place is another marker under each, so that which ones both show says nothing
        of what these are; who shows fewer lacks some."""
    h, used = len(share), finder.surface.sides.with_all(used)
    use = used if exchanged else np.tile(used.all(axis=0), (2, 1, 1))
    scatter, points = (
        values.reshape(2, h)
        for values in scatters(finder, frame, both, use.reshape(2 * h, -1), np.tile(differ, (2, 1)))
    )
    # who rests on fewer markers fits these better without being right: that does not count for it
    lacks = np.asarray((used[:, None] & ~used & differ).any(axis=-1))
    alone = lacks[(0, 1), (1, 0)]  # (2, H) whether either shows one that the other lacks
    if exchanged:
        shown = used.sum(axis=-1)
        alone = shown > shown[::-1]
    against = frame.scene.odds_against(both.R, both.t)
    return Evidence(np.log(share), signed_ratio(scatter, points, alone), against[:h] - against[h:])


def signed_ratio(scatter: Array, points: Array, alone: NDArray[np.bool_]) -> Array:
    """(H,) `Evidence.contours` of two poses each.

    :param scatter, points: (2, H) as of `scatters`. :param alone: (2, H) which of the two shows a marker that the other
        one lacks: that it fits it no better does not count against it.
    """
    ratio = np.where((points > 0).all(axis=0), points.mean(axis=0) / 2 * (scatter[0] - scatter[1]), 0.0)
    ratio = np.where(alone[0], np.minimum(ratio, 0.0), ratio)
    ratio = np.where(alone[1], np.maximum(ratio, 0.0), ratio)
    return np.asarray(np.sign(ratio) * np.sqrt(np.abs(ratio)))


def scatters(
    finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, use: NDArray[np.bool_], of: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """(H,) logarithm of the mean square of the distances of contours from edges, in pixels, but for what all have in
    common; and of how many points: neighbours nearer than a pixel see the same.

    Points that should lie on an edge and lie on none are as unlikely as if all edges lay about as far off as they are
    looked for. They count by themselves: in one mean with the others a few of them would be all it tells.

    :param use, of: (H, M) markers that tell what they have in common, and those of them whose distances count.
    """
    if not use.any():
        return np.zeros(len(poses)), np.zeros(len(poses))
    fit, residual, weight = finder.rest.edges(frame, poses, use)
    alone = np.minimum(1.0, fit.spacing_px)[..., None]
    weight, counts = weight * alone, (of & use)[:, use.any(axis=0)][..., None] * alone
    lost = (counts * finder.rest.lost(frame, poses, use, fit)).sum(axis=(1, 2))
    off, weight = but_for_common(residual, weight), np.where(counts > 0, weight, 0.0)
    seen, total = (counts * (weight > 0)).sum(axis=(1, 2)), np.maximum(weight.sum(axis=(1, 2)), 1e-9)
    about_edges = np.log((weight * off**2).sum(axis=(1, 2)) / total + _EXACT_PX**2)
    points = seen + lost
    share = lost / np.maximum(points, 1e-9)
    return (1 - share) * about_edges + share * np.log(finder.rest.reach_px(frame) ** 2), points
