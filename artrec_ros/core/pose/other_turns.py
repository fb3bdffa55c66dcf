"""Which of two turns told poses have that look almost the same, and how probable the other one is.

A flat marker that is slanted looks almost as it does slanted the other way: only perspective tells, and of a small or
distant marker little. Other components in other planes tell, and so do bodies. Both turns are brought to rest, and
compared (turn_evidence.py).

Half a turn of a box, or what else lays the required component's markers onto themselves, leaves most as it was, too:
joints reach where they did. There a component tells that is borne out under one of both alone. A solid of one class
covers almost the same pixels tilted where it is (tilts.py); its outline tells. A base that only one joint ties to all
else that is seen tells alone how it is turned below that (turned_alone.py).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..base.config import SearchConfig
from ..geometry.transforms import Array, Pose, short_way
from ..image.image_frame import ImageFrame
from ..model.found import OtherTurn
from .distinct import best_distinct
from .finder import WholeObjectFinder
from .other_sides import other_sides
from .poses import Poses
from .rivals import ANY_DEPTH, WORTH_FIT, Rivals, rivals_at_rest
from .turn_evidence import even_odds, evidence, turn_odds
from .turned_alone import alone_odds, turned_alone
from .turns_in_place import goes_on, turned_in_place, turns_taken_back

_TILTS = 3  # of a pose that come to rest


def likelier_turns(
    finder: WholeObjectFinder, frame: ImageFrame, poses: Poses
) -> tuple[Poses, Sequence[OtherTurn | None]]:
    """H poses at rest on what the image shows, turned where the mirrored turn is clearly likelier; and each one's other
    turn, where that may be the true one."""
    others: list[OtherTurn | None] = [None] * len(poses)
    config = finder.config.verdict
    clearly = config.least_turn_odds
    kinds = {  # from which odds on they are told, whether they are other sides, and whether turned where they stand
        _mirrored: (clearly, False, False),
        turned_in_place: (clearly, False, True),
        _other_sides: (clearly, True, False),
        turns_taken_back: (0.0, False, True),
        tilted_rivals: (0.0, False, False),
        _alone: (clearly, False, False),
    }
    found = [rivals(finder, frame, poses) for rivals in kinds]
    both = Poses.concatenate([poses, *(kind.poses for kind in found)])
    if len(both) == len(poses):
        return poses, others
    of, log_odds = (np.concatenate([kind[column] for kind in found]) for column in (1, 2))
    counts = [len(kind.of) for kind in found]
    least, is_side, turned = (np.repeat(column, counts) for column in zip(*kinds.values(), strict=True))
    in_place = np.append(np.zeros(len(poses), bool), turned)
    known = goes_on(finder, frame, both) if in_place.any() else in_place
    rows = np.arange(len(poses))
    log_odds = np.where(log_odds > least, log_odds, np.minimum(log_odds, 0.0))  # below, both are as likely
    for h in np.unique(of).tolist():
        mine = np.flatnonzero(of == h)
        rivals = np.concatenate([[h], len(poses) + mine])  # it itself is as likely as it is
        worth = np.concatenate([[0.0], log_odds[mine]])
        first = int(np.argmax(worth))
        rest = np.flatnonzero(look_otherwise(finder, both[rivals[first : first + 1]], both[rivals]))
        if not len(rest):
            continue
        second = int(rest[np.argmax(worth[rest])])
        rows[h], probability = rivals[first], float(1 / (1 + np.exp(worth[first] - worth[second])))
        told, rival = int(rows[h]), int(rivals[second])
        # what leaps from frame to frame tells whence, however sure this frame is of it: all together know better
        leaps = (in_place[told] or in_place[rival]) and known[rival] and not known[told]
        other = other_of(finder, both, told, rival, probability, least=0.0 if leaps else None)
        others[h] = other and replace(other, sides=_other_sides_share(worth, np.append(False, is_side[mine]), first))
    return both[rows], others


def look_otherwise(finder: WholeObjectFinder, told: Poses, others: Poses) -> NDArray[np.bool_]:
    """(H,) which of some rivals of a pose are others to the eye: rivals of a pose that was told before may be one. What
    is a solid alone may be turned by what leaves it as it looks."""
    same, niche = np.zeros(len(others), int), finder.config.search.niche_rad
    if finder.tilts and len(finder.target.model.components) == 1:
        return ~finder.tilts.look_alike(told[same], others)
    turned = (np.einsum("ij,hij->h", told.R[0], others.R) - 1) / 2 < np.cos(niche)
    return np.asarray(turned | ~finder.required.is_at(others, told[same]))


def _other_sides_share(worth: Array, is_side: NDArray[np.bool_], told: int) -> float:
    """How probable it is that another side is seen than under the one that is told.

    :param worth: (n,) log odds of a pose and its rivals. :param is_side: (n,) which show other sides than the pose.
    """
    other = is_side.copy()
    other[told], other[0] = False, is_side[told]
    return float(1 - 1 / (1 + np.exp(worth[other] - worth[told]).sum()))


def _mirrored(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Rivals:
    """Mirrored turns."""
    mirrored, of = mirrored_turns(finder, frame, poses)
    if not len(of):
        return Rivals(mirrored, of, np.zeros(0))
    mirrored = finder.rest.on_colours(frame, mirrored, finder.voter.supports(frame, mirrored))
    return Rivals(mirrored, of, turn_odds(finder, frame, poses[of], mirrored))


def _other_sides(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Rivals:
    """Other sides of the object in the place of those that are seen."""
    sides, of = poses[:0], np.zeros(0, np.int64)
    if len(finder.like_sides):
        told = finder.voter.votes(frame, poses, occlusion=True)
        sides, of = other_sides(finder, frame, poses, WORTH_FIT * finder.config.verdict.mirrored_votes * told)
        sides, of = rivals_at_rest(finder, frame, poses, told, sides, of, elsewhere=True)
        best = _best_of_each(sides, finder.voter.votes(frame, sides, occlusion=True), of, finder.config.search)
        sides, of = sides[best], of[best]  # several may have come to rest at one
    if not len(of):
        return Rivals(sides, of, np.zeros(0))
    sides = finder.rest.on_colours(frame, sides, finder.voter.supports(frame, sides))
    return Rivals(sides, of, even_odds(finder, frame, poses[of], sides))


def tilted_rivals(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Rivals:
    """Solids tilted where they are."""
    tilted, of = _tilted_turns(finder, frame, poses)
    if not len(of):
        return Rivals(tilted, of, np.zeros(0))
    tilted = finder.rest.on_colours(frame, tilted, finder.voter.supports(frame, tilted))
    config, in_colour = finder.config.verdict, finder.rest.tells_colour_edges(frame)
    found = evidence(finder, frame, poses[of], tilted)
    return Rivals(tilted, of, found.log_odds(config.tilt_odds_colour if in_colour else config.tilt_odds))


def _alone(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Rivals:
    """The required component turned by itself."""
    turned, of = turned_alone(finder, frame, poses)
    if not len(of):
        return Rivals(turned, of, np.zeros(0))
    best = _best_of_each(turned, finder.voter.votes(frame, turned, occlusion=True), of, finder.config.search)
    turned, of = turned[best], of[best]
    turned = finder.rest.on_colours(frame, turned, finder.voter.supports(frame, turned))
    return Rivals(turned, of, alone_odds(finder, frame, poses[of], turned))


def other_of(
    finder: WholeObjectFinder, poses: Poses, told: int, other: int, probability: float, least: float | None = None
) -> OtherTurn | None:
    """Of two of some poses the other one, beside the one that is told; None where it need not be known.

    :param least: probability that need not be; None: that of `verdict.least_other_turn`.
    """
    if probability <= (finder.config.verdict.least_other_turn if least is None else least):
        return None
    short = short_way(poses.q[other] - poses.q[told], finder.surface.kinematics.endless)
    bent = dict(zip(finder.target.model.joint_names, (poses.q[told] + short).tolist(), strict=True))
    return OtherTurn(Pose(poses.R[other], poses.t[other]), probability, bent)


def mirrored_turns(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> tuple[Poses, NDArray[np.int64]]:
    """Mirrored turns of poses, at rest on the labels, with votes enough to be the true ones; and whose each one is."""
    flips, of = finder.required.flips_of_each(poses)
    if not len(flips):
        return flips, of
    return rivals_at_rest(finder, frame, poses, finder.voter.votes(frame, poses, occlusion=True), flips, of)


def _tilted_turns(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> tuple[Poses, NDArray[np.int64]]:
    """The same of a required component that is a solid, tilted where it is, but those that look the same."""
    tilts = finder.tilts
    if not tilts or not len(poses):
        return poses[:0], np.zeros(0, np.int64)
    niche, told = finder.config.search.niche_rad, finder.voter.votes(frame, poses, occlusion=True)
    tilted, of = tilts.of(poses)
    first = finder.ranked(frame, tilted)
    worth = np.flatnonzero(first.votes > WORTH_FIT * finder.config.verdict.mirrored_votes * told[of])
    fitted, of = finder.refit.of(frame, tilted[worth], ANY_DEPTH)[len(worth) :], of[worth]
    differ = np.flatnonzero(tilts.look_otherwise(poses[of], fitted.poses, niche))
    best = differ[_best_of_each(fitted.poses[differ], fitted.votes[differ], of[differ], finder.config.search)]
    rivals, of = rivals_at_rest(finder, frame, poses, told, fitted.poses[best], of[best])
    differ = np.flatnonzero(tilts.look_otherwise(poses[of], rivals, niche))
    return rivals[differ], of[differ]


def _best_of_each(found: Poses, votes: Array, of: NDArray[np.int64], config: SearchConfig) -> NDArray[np.int64]:
    """Indices of the few hypotheses of each pose that differ and have most votes."""
    best = [np.zeros(0, np.int64)]
    for h in np.unique(of).tolist():
        mine = np.flatnonzero(of == h)
        best.append(mine[best_distinct(found[mine], votes[mine], _TILTS, config)])
    return np.concatenate(best)
