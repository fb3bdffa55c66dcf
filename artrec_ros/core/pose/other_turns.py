"""Which of two turns told poses have that look almost the same, and how probable the other one is.

A flat marker that is slanted looks almost as it does slanted the other way: only perspective tells, and of a small or
distant marker little. Other components in other planes tell, and so do bodies. Two things bear out either turn, once
both are at rest: votes, which count pixels of whole objects, and how near to contours edges lie, and whether there are
any, which is finer, most of all in colour images. Neither suffices; together they tell how probable each turn is, as
fitted on random objects (`benchmarks/turns.py`).

Half a turn of a box, or what else lays the required component's markers onto themselves, leaves most as it was, too:
joints reach where they did. There a component tells that is borne out under one of both alone.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..base.config import SearchConfig
from ..geometry.transforms import Array, Pose, short_way
from ..image.image_frame import ImageFrame
from ..model.found import OtherTurn
from .distinct import best_distinct
from .finder import WholeObjectFinder
from .pose_fit import but_for_common
from .surface_model import Poses

WORTH_REST = 0.9  # share of what makes a rival without which a first fit will not become one by the last
_WORTH_FIT = 0.5  # the same before that fit
ANY_DEPTH = 0.0, np.inf
_TILTS = 3  # of a pose that come to rest
_EXACT_PX = 0.03  # contours as near as that to labels' edges are on them: nothing is told by how much nearer
_SHARES = 0.3, 2.0  # of votes, beyond which more tells nothing


class Evidence(NamedTuple):
    """What speaks for the mirrored turns of H poses, against these.

    :ivar votes: (H,) logarithm of their share of the votes.
    :ivar contours: (H,) signed root of the logarithm of the likelihoods' ratio of the contours that both show.
    """

    votes: Array
    contours: Array

    def log_odds(self, weights: Sequence[float]) -> Array:
        """(H,) of the mirrored turns. :param weights: without evidence, of votes, of contours."""
        return np.asarray(weights[0] + weights[1] * self.votes + weights[2] * self.contours, np.float64)


def likelier_turns(
    finder: WholeObjectFinder, frame: ImageFrame, poses: Poses
) -> tuple[Poses, Sequence[OtherTurn | None]]:
    """H poses at rest on what the image shows, turned where the mirrored turn is clearly likelier; and each one's other
    turn, where that may be the true one."""
    others: list[OtherTurn | None] = [None] * len(poses)
    config = finder.config.verdict
    turns, tilts = _turns(finder, frame, poses), tilted_rivals(finder, frame, poses)
    both = Poses.concatenate([poses, turns.poses, tilts.poses])
    of, log_odds = (np.concatenate(pair) for pair in zip(turns[1:], tilts[1:], strict=True))
    rows = np.arange(len(poses))
    turned, probabilities = weighed(log_odds, np.repeat([config.least_turn_odds, 0.0], [len(turns.of), len(tilts.of)]))
    for n in np.argsort(log_odds, kind="stable").tolist():  # of several the likeliest one counts
        probability, row, other = float(probabilities[n]), int(of[n]), len(poses) + n
        if turned[n]:
            rows[row], other = other, row
        others[row] = other_of(finder, both, int(rows[row]), other, probability)
    return both[rows], others


class Rivals(NamedTuple):
    """Other poses at rest, whose each one is, and the log odds that it is the true one."""

    poses: Poses
    of: NDArray[np.int64]
    log_odds: Array


def _turns(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Rivals:
    """Mirrored turns and turns in place."""
    mirrored, of = mirrored_turns(finder, frame, poses)
    in_place, of_these = turned_in_place(finder, frame, poses)
    rivals, of = Poses.concatenate([mirrored, in_place]), np.concatenate([of, of_these])
    if not len(of):
        return Rivals(rivals, of, np.zeros(0))
    rivals = finder.rest.on_colours(frame, rivals, finder.voter.supports(frame, rivals))
    log_odds = turn_odds(finder, frame, poses[of], rivals)
    if n := len(of_these):
        at_first, for_each = finder.config.verdict.in_place_odds
        log_odds[-n:] += at_first + for_each * _more_borne_out(finder, frame, poses[of_these], rivals[-n:])
    return Rivals(rivals, of, log_odds)


def tilted_rivals(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Rivals:
    """Solids tilted where they are."""
    tilted, of = tilted_turns(finder, frame, poses)
    if not len(of):
        return Rivals(tilted, of, np.zeros(0))
    tilted = finder.rest.on_colours(frame, tilted, finder.voter.supports(frame, tilted))
    config, in_colour = finder.config.verdict, finder.rest.tells_colour_edges(frame)
    found = evidence(finder, frame, poses[of], tilted)
    return Rivals(tilted, of, found.log_odds(config.tilt_odds_colour if in_colour else config.tilt_odds))


def turn_odds(
    finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, others: Poses, component: int | None = None
) -> Array:
    """(H,) log odds that another pose is the true one, for each of H poses at rest.

    :param component: by what one component shows alone; None: by all that is known.
    """
    config = finder.config.verdict
    weights = config.turn_odds_colour if finder.rest.tells_colour_edges(frame) else config.turn_odds
    return evidence(finder, frame, poses, others, component).log_odds(weights)


def other_of(finder: WholeObjectFinder, poses: Poses, told: int, other: int, probability: float) -> OtherTurn | None:
    """Of two of some poses the other one, beside the one that is told; None where it need not be known."""
    if probability <= finder.config.verdict.least_other_turn:
        return None
    short = short_way(poses.q[other] - poses.q[told], finder.surface.kinematics.endless)
    bent = dict(zip(finder.target.model.joint_names, (poses.q[told] + short).tolist(), strict=True))
    return OtherTurn(Pose(poses.R[other], poses.t[other]), probability, bent)


def mirrored_turns(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> tuple[Poses, NDArray[np.int64]]:
    """Mirrored turns of poses, at rest on the labels, with votes enough to be the true ones; and whose each one is."""
    flips, of = finder.required.flips_of_each(poses)
    if not len(flips):
        return flips, of
    return _at_rest(finder, frame, poses, finder.voter.votes(frame, poses, occlusion=True), flips, of)


def tilted_turns(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> tuple[Poses, NDArray[np.int64]]:
    """The same of a required component that is a solid, tilted where it is, but those that look the same."""
    tilts = finder.tilts
    if not tilts or not len(poses):
        return poses[:0], np.zeros(0, np.int64)
    niche, told = finder.config.search.niche_rad, finder.voter.votes(frame, poses, occlusion=True)
    tilted, of = tilts.of(poses)
    first = finder.ranked(frame, tilted)
    worth = np.flatnonzero(first.votes > _WORTH_FIT * finder.config.verdict.mirrored_votes * told[of])
    fitted, of = finder.refit.of(frame, tilted[worth], ANY_DEPTH)[len(worth) :], of[worth]
    differ = np.flatnonzero(tilts.look_otherwise(poses[of], fitted.poses, niche))
    best = differ[_best_of_each(fitted.poses[differ], fitted.votes[differ], of[differ], finder.config.search)]
    rivals, of = _at_rest(finder, frame, poses, told, fitted.poses[best], of[best])
    differ = np.flatnonzero(tilts.look_otherwise(poses[of], rivals, niche))
    return rivals[differ], of[differ]


def _best_of_each(found: Poses, votes: Array, of: NDArray[np.int64], config: SearchConfig) -> NDArray[np.int64]:
    """Indices of the few hypotheses of each pose that differ and have most votes."""
    best = [np.zeros(0, np.int64)]
    for h in np.unique(of).tolist():
        mine = np.flatnonzero(of == h)
        best.append(mine[best_distinct(found[mine], votes[mine], _TILTS, config)])
    return np.concatenate(best)


def turned_in_place(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> tuple[Poses, NDArray[np.int64]]:
    """The same of turns that the required component's outline does not tell, joints sought anew."""
    ways, h = finder.in_place, len(poses)
    if not len(ways) or not h:
        return poses[:0], np.zeros(0, np.int64)
    bent = finder.surface.search_joints(frame, ways.of(poses), finder.first_grids)
    turned = finder.climber.sweep(frame, finder.ranked(frame, bent))
    told, of = finder.voter.votes(frame, poses, occlusion=True), np.repeat(np.arange(h), len(ways))
    worth = np.flatnonzero(turned.votes > _WORTH_FIT * finder.config.verdict.mirrored_votes * told[of])
    return _at_rest(finder, frame, poses, told, turned.poses[worth], of[worth])


def _at_rest(
    finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, told: Array, flips: Poses, of: NDArray[np.int64]
) -> tuple[Poses, NDArray[np.int64]]:
    """Those of some other turns of poses, at rest, that may be the true ones.

    :param told: (H,) votes of the poses. :param of: whose each other turn is.
    """
    if not len(flips):
        return flips, of
    first = finder.refit.of(frame, flips, ANY_DEPTH)[len(flips) :]
    least = finder.config.verdict.mirrored_votes * told
    near = np.flatnonzero(first.votes > WORTH_REST * least[of])
    fitted, of = first.poses[near], of[near]
    if not len(near):
        return fitted, of
    fitted = finder.rest.settled(frame, fitted, finder.voter.supports(frame, fitted))
    cosine = (np.einsum("hij,hij->h", fitted.R, poses.R[of]) - 1) / 2
    apart = (cosine < np.cos(finder.config.search.niche_rad)) & finder.required.is_at(fitted, poses[of])
    apart &= finder.voter.votes(frame, fitted, occlusion=True) > least[of]
    apart &= frame.scene.stand(fitted.R, fitted.t)
    kept = np.flatnonzero(apart)
    return fitted[kept], of[kept]


def _more_borne_out(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, rivals: Poses) -> NDArray[np.int64]:
    """(H,) by how many components labels bear out more of rivals than of poses."""
    component = finder.surface.component[finder.surface.markers]
    each = np.arange(len(finder.target.model.components))[:, None] == component  # (C, M)
    there, here = (finder.voter.supports(frame, some) @ each.T > 0 for some in (rivals, poses))
    return there.sum(axis=1) - here.sum(axis=1)


def evidence(
    finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, mirrored: Poses, component: int | None = None
) -> Evidence:
    """Of poses, and the mirrored turn of each. :param component: as of `turn_odds`."""
    h, both, surface = len(poses), Poses.concatenate([poses, mirrored]), finder.surface
    scores = finder.voter.judge(frame, both, occlusion=True)
    votes, used = finder.voter.total(scores).reshape(2, h), finder.voter.supported(scores).reshape(2, h, -1)
    differ = np.ones_like(used[0])
    if component is not None:
        votes = scores.votes[:, surface.component == component].sum(axis=1).reshape(2, h)
        differ &= surface.component[surface.markers] == component
    return contour_evidence(finder, frame, both, share_of_votes(votes[1], votes[0]), used, differ)


def weighed(log_odds: Array, least: float | Array) -> tuple[NDArray[np.bool_], Array]:
    """(N,) whether other turns or bends are told in place of those found, and how probable is what is not told.

    :param least: log odds from which on they are.
    """
    turned = log_odds > least
    return turned, 1 / (1 + np.exp(np.where(turned, log_odds, np.maximum(-log_odds, 0.0))))


def share_of_votes(votes: Array, told: Array) -> Array:
    """(H,) of the votes that are told, as far as it tells something."""
    return np.clip(votes / np.maximum(told, 1e-9), *_SHARES)


def contour_evidence(
    finder: WholeObjectFinder,
    frame: ImageFrame,
    both: Poses,
    share: Array,
    used: NDArray[np.bool_],
    differ: NDArray[np.bool_],
) -> Evidence:
    """Of H poses and another one for each, behind them. :param share: (H,) of the votes. :param used: (2, H, M)
    markers that the labels support. :param differ: (H, M) markers that are not in one place under both."""
    h, used = len(share), finder.surface.with_sides(used)
    scatter, points = (
        values.reshape(2, h)
        for values in _scatters(finder, frame, both, np.tile(used.all(axis=0), (2, 1)), np.tile(differ, (2, 1)))
    )
    ratio = np.where((points > 0).all(axis=0), points.mean(axis=0) / 2 * (scatter[0] - scatter[1]), 0.0)
    # who rests on fewer markers fits these better without being right: that does not count for it
    lacks = np.asarray((used[:, None] & ~used & differ).any(axis=-1))
    alone = lacks[(0, 1), (1, 0)]  # (2, H) whether either shows one that the other lacks
    ratio = np.where(alone[0], np.minimum(ratio, 0.0), ratio)
    ratio = np.where(alone[1], np.maximum(ratio, 0.0), ratio)
    return Evidence(np.log(share), np.sign(ratio) * np.sqrt(np.abs(ratio)))


def _scatters(
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
    weight, counts = weight * alone, of[:, use.any(axis=0)][..., None] * alone
    lost = (counts * finder.rest.lost(frame, poses, use, fit)).sum(axis=(1, 2))
    off, weight = but_for_common(residual, weight), np.where(counts > 0, weight, 0.0)
    seen, total = (counts * (weight > 0)).sum(axis=(1, 2)), np.maximum(weight.sum(axis=(1, 2)), 1e-9)
    about_edges = np.log((weight * off**2).sum(axis=(1, 2)) / total + _EXACT_PX**2)
    points = seen + lost
    share = lost / np.maximum(points, 1e-9)
    return (1 - share) * about_edges + share * np.log(finder.rest.reach_px(frame) ** 2), points
