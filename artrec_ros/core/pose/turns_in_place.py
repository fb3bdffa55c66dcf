"""Turns of an object that lay its required component's markers onto themselves, as half a turn of a box, or of a body
with like legs, or that a joint on it takes back: other components lie where some are seen."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from ..geometry.transforms import Array
from ..image.image_frame import ImageFrame
from .finder import WholeObjectFinder
from .poses import Poses
from .rivals import ANY_DEPTH, WORTH_FIT, Rivals, rivals_at_rest
from .turn_evidence import exchanged_odds, odds_at_first

_Turned = tuple[Poses, NDArray[np.int64]]
_Others = Callable[[WholeObjectFinder, ImageFrame, Poses], _Turned]


def turned_in_place(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Rivals:
    """Turns in place, joints sought anew; what a search has found has more for it than is compared here."""
    return _weighed(finder, frame, poses, _onto_themselves, finder.config.verdict.least_turn_odds)


def turns_taken_back(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> Rivals:
    """Turns that a joint takes back: a search may rest at either, and the likelier one is told."""
    return _weighed(finder, frame, poses, _taken_back, 0.0)


def _weighed(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, others: _Others, least: float) -> Rivals:
    """Such turns; and where one is likelier, these turned back: a pose that lacks what its rival has found may only
    have come to rest beside its own.

    Of what was known before that counted when it was found: in each frame anew it would grow sure of a turn for nothing
    but that it was taken once.

    :param least: log odds from which on one is told in the other's place.
    """
    config, (turned, of) = finder.config, others(finder, frame, poses)
    if not len(of):
        return Rivals(turned, of, np.zeros(0))
    at_first = odds_at_first(finder, frame) + config.verdict.in_place_odds[0]
    before = np.where(goes_on(finder, frame, poses)[of] | goes_on(finder, frame, turned), 0.0, at_first)
    log_odds = before + _exchanged(finder, frame, poses[of], turned)
    won = np.flatnonzero(log_odds > least)
    if not len(won):
        return Rivals(turned, of, log_odds)
    back, by = others(finder, frame, turned[won])
    cosine = (np.einsum("hij,hij->h", back.R, poses.R[of[won[by]]]) - 1) / 2
    near = np.flatnonzero(cosine > np.cos(config.search.niche_rad))
    back, by = back[near], won[by[near]]
    more = (log_odds - before)[by] + _exchanged(finder, frame, turned[by], back)
    return Rivals(Poses.concatenate([turned, back]), np.append(of, of[by]), np.append(log_odds, more))


def goes_on(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> NDArray[np.bool_]:
    """(H,) which of some poses lie where an object of frames before is expected, turned as it was."""
    expected = frame.expected.get(finder.target.name)
    if expected is None:
        return np.zeros(len(poses), bool)
    same = finder.required.is_in_place_of(poses, Poses(*expected), finder.config.search.niche_rad)
    return np.asarray(same.any(axis=1))


def _exchanged(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, rivals: Poses) -> Array:
    """(H,) log odds of turns in place by what is seen."""
    if not len(rivals):
        return np.zeros(0)
    more = _more_borne_out(finder, frame, poses, rivals)
    return finder.config.verdict.in_place_odds[1] * more + exchanged_odds(finder, frame, poses, rivals)


def _onto_themselves(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> _Turned:
    """Turns that the required component's outline does not tell, joints sought anew, at rest; and whose each one is."""
    ways, h = finder.in_place, len(poses)
    if not len(ways) or not h:
        return poses[:0], np.zeros(0, np.int64)
    bent = finder.surface.search_joints(frame, ways.of(poses), finder.first_grids)
    turned = finder.climber.sweep(frame, finder.ranked(frame, bent))
    told, of = finder.voter.votes(frame, poses, occlusion=True), np.repeat(np.arange(h), len(ways))
    worth = np.flatnonzero(turned.votes > WORTH_FIT * finder.config.verdict.mirrored_votes * told[of])
    # what is told was found so: a rival with a limb astray would be worse for that alone
    search, climb = finder.config.search, finder.last_climb
    each = (finder.fit_all(frame, turned.poses[n : n + 1]).best(1, search) for n in worth.tolist())
    again = [finder.rejointed(frame, fitted, climb).poses for fitted in each]
    return _at_rest(finder, frame, poses, told, Poses.concatenate([poses[:0], *again]), of[worth])


def _taken_back(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses) -> _Turned:
    """Turns that a joint takes back, at rest; and whose each one is."""
    if not finder.taken_back or not len(poses):
        return poses[:0], np.zeros(0, np.int64)
    (turned, of), told = finder.taken_back.of(poses), finder.voter.votes(frame, poses, occlusion=True)
    first = finder.ranked(frame, turned)
    worth = np.flatnonzero(first.votes > WORTH_FIT * finder.config.verdict.mirrored_votes * told[of])
    fitted = finder.refit.of(frame, turned[worth], ANY_DEPTH)[len(worth) :]
    return _at_rest(finder, frame, poses, told, fitted.poses, of[worth])


def _at_rest(
    finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, told: Array, turned: Poses, of: NDArray[np.int64]
) -> _Turned:
    """As of `rivals_at_rest`, and at rest on colours."""
    rivals, of = rivals_at_rest(finder, frame, poses, told, turned, of)
    if not len(of):
        return rivals, of
    return finder.rest.on_colours(frame, rivals, finder.voter.supports(frame, rivals)), of


def _more_borne_out(finder: WholeObjectFinder, frame: ImageFrame, poses: Poses, rivals: Poses) -> NDArray[np.int64]:
    """(H,) by how many components labels bear out more of rivals than of poses."""
    component = finder.surface.component[finder.surface.markers]
    each = np.arange(len(finder.target.model.components))[:, None] == component  # (C, M)
    there, here = (finder.voter.supports(frame, some) @ each.T > 0 for some in (rivals, poses))
    return there.sum(axis=1) - here.sum(axis=1)
