"""What labels confirm of claims, and what speaks for each of them, a claim at a time."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, lean, melted
from ..geometry.pixel_kernels import LabelView, locate, project, turned
from ..model.chain_kernels import Chain, place_seen
from ..pose.covering_kernels import COVERED, cover
from ..pose.surface_kernels import (
    LEAST_DEPTH_M,
    Room,
    Surface,
    SurfaceLimits,
    aspect,
    look_beside,
    points_of,
    room_of,
    widened,
)
from ..pose.vote_kernels import LEAST_KNOWN, is_supported
from .alike_kernels import Alike, freedom, times_mixed_up

ALONE, DESERTED, BORNE_OUT, UNSEEN, FADED = range(5)  # see `Verdict.case`
UNSEEN_ALONE, FADED_ALONE = 5, 8  # and from there on the first three, with another component in its place


class Criteria(NamedTuple):
    """What a claim is examined by."""

    root: int  # the required component
    rigid: Any  # (C,) bool: other components of the rigid body that it is part of
    n_components: int
    told: Any  # (P,) bool: faces that have a class
    choices: Any  # (P,) how many classes each patch may be of,
    each: Any  # (P, n, 256) and how far each code is of each of them
    enough: float  # share of the outline of one that may be of several which counts as all of it
    bare: float  # mean vote of faces where there are none
    min_px: float  # markers that show fewer say nothing
    supported_agree: float  # least share of a marker's pixels with its label for it to be confirmed,
    told_agree: float  # and for a thin one to be told
    thin_px: float
    inside: float  # greatest vote of a marker's pixel,
    mixed: float  # by how much more than the vote of one of another class,
    around: float  # of a pixel of its outline's length,
    rim: float  # and of what lies at one place of that
    fades: bool  # whether an object may be one whose required component bears no labels where it should be seen
    others: Any  # (256,) how far each code is of a known class that is none of the required component's
    facing: bool  # of what faces the camera; outlines of what is in space are weighed as its curves were fitted
    overlaps: bool  # whether parts of one class can lie over each other's contours
    alike: Alike


class Said(NamedTuple):
    """What labels say of H claims, see `PatchScores`, and where these are."""

    votes: Any  # (H, P)
    area_px: Any
    agree: Any
    full_px: Any  # (H, P) pixels that would be seen if nobody owned any
    total: Any  # (H,) votes of each whole claim
    scale: Any  # (H,) pixels per metre


class Found(NamedTuple):
    """What is found out of them, to fill; see `Verdict` and `Evidence`."""

    shown: Any  # (H, C)
    confirmed: Any  # (H, C) bool
    marker_votes: Any  # (H, C)
    outline: Any  # (H, C) how well the outline of what shows a component parts its class from others
    parted: Any  # (H, C) share of that outline that does not lie amid its class
    case: Any  # (H,)
    evidence: Any  # (H, columns)
    times: Any  # (H,) how many times as easily chance bears it out because its components look alike


@melted
def supports(said: Said, by: Criteria, h: int, p: int, mixed: float) -> bool:
    """Whether the labels support a marker of claim `h`. :param mixed: share of its pixels of its classes that are not
    of the one that it shows: these are another's."""
    agree, area_px = said.agree[h, p], said.area_px[h, p]
    votes = said.votes[h, p] - by.mixed * mixed * agree * area_px
    return is_supported(votes, area_px, (1 - mixed) * agree, by.min_px, by.supported_agree)


@melted
def perimeter_px(s: Surface, said: Said, h: int, p: int) -> float:
    """Length of a marker's outline as it is seen."""
    return s.perimeter[s.marker_of[p]] * math.sqrt(max(said.area_px[h, p], 1e-9) / s.area[p])


@melted
def class_shown(
    s: Surface, p: int, by: Criteria, A: Any, b: Any, view: LabelView, limits: SurfaceLimits, room: Room
) -> tuple[int, float]:
    """Of the classes that marker `p` in a frame (3, 3), (3,) may be of that which most of its pixels show, and the
    share of those of any of them that do not: what is of several is no marker of any."""
    if by.choices[p] == 1:
        return 0, 0.0
    n, best, most, total = s.count[p], 0, 0.0, 0.0
    locate(A, b, points_of(s, p, n), view, room.at[0])
    for c in range(by.choices[p]):
        px = 0.0
        for i in range(n):
            code = view.padded[room.at[0, i]]
            if code != limits.owned and code != limits.outside:
                px += by.each[p, c, code]
        total += px
        if px > most:
            best, most = c, px
    return best, 1 - most / total if total > 0.0 else 0.0


@melted
def along_outline(
    s: Surface, p: int, shown: Any, A: Any, b: Any, view: LabelView, limits: SurfaceLimits, room: Room
) -> tuple[float, float, float, float]:
    """Mean vote of what lies just inside and just outside the outline of marker `p` in a frame (3, 3), (3,), the share
    of it that does not lie amid the class that it shows, and amid any that it may be of, and that over which the
    object's own parts do not lie; of what nobody owns in the image, 0 where that is nothing. Where another side of its
    component begins is no outline.

    :param shown: (256,) how far each code is of the class that it shows.
    """
    k, own = s.marker_of[p], s.own[s.role[p]]
    _, _, depth = turned(A, s.centre[p])
    look_beside(s, k, A, b, depth + b[2], view, limits, room)
    out, into, is_open = s.table[s.ring_role[k]], s.table[s.rim_role[k]], room.open[k]
    m, votes, seen, amid, amid_any, known, free = s.contour.shape[2], 0.0, 0, 0.0, 0.0, 0, 0
    for i in range(m):
        if s.has_meets[k] and room.inner[i]:
            continue
        free += 1
        beyond, within = view.padded[room.at[0, i]], view.padded[room.at[1, i]]
        if beyond != limits.outside and beyond != limits.owned:
            seen += 1
            if is_open[i] == COVERED:
                continue
            votes += is_open[i] * out[beyond] + into[within]
            amid += is_open[i] * shown[beyond]
            amid_any += is_open[i] * own[beyond]
            known += 1
    least = max(known, LEAST_KNOWN * seen, 1.0)
    return votes / least, (known - amid) / least, (known - amid_any) / least, least / max(seen, 1) * free / m


@melted
def outline_of(
    s: Surface, said: Said, by: Criteria, h: int, best: int, shown: Any, looked: bool, A: Any, b: Any, view: LabelView,
    limits: SurfaceLimits, room: Room,
) -> tuple[float, float, float]:  # fmt: skip
    """How well the outline of marker `best` of claim `h` parts its class from others, and as of `along_outline` its
    rim and its parted share: of sides that meet it of what all in view look like together, the longer ones counting
    more. :param shown: as of `along_outline`. :param looked: whether it is looked at; else it votes alone.
    """
    votes, inside, around, rims, parts, total = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    together = looked and s.has_meets[s.marker_of[best]]
    for p in range(len(s.component)):
        side = together and s.component[p] == s.component[best] and s.marker_of[p] >= 0
        if p != best and not (side and s.has_meets[s.marker_of[p]] and said.area_px[h, p] > 0.0):
            continue
        rim, parted, voting, free = 0.0, 1.0, 1.0, 1.0
        if looked:
            rim, parted, voting, free = along_outline(s, p, shown, A, b, view, limits, room)
        _, _, z = turned(A, s.centre[p])
        wide = widened(s, s.marker_of[p], z + b[2], view.K[0, 0] * view.K[1, 1], limits)
        length = by.around * perimeter_px(s, said, h, p) * free * wide
        # as far as it votes, of what faces the camera
        inside += by.inside * said.agree[h, p] * said.area_px[h, p] * (voting if by.facing else 1.0)
        votes += said.votes[h, p]
        around += length
        weight = length if together else 1.0
        rims, parts, total = rims + weight * rim, parts + weight * parted, total + weight
    if together and around <= 0.0:
        return 0.0, 0.0, 1.0  # what would part it from others is out of sight
    # nothing, where it does not vote
    return (votes - inside) / max(around, 1e-12), rims / max(total, 1e-12), parts / max(total, 1e-12)


@melted
def confirm(
    s: Surface, said: Said, by: Criteria, h: int, R: Any, t: Any, view: LabelView, limits: SurfaceLimits, room: Room,
    found: Found, rims: Any,
) -> None:  # fmt: skip
    """Which marker shows each component of claim `h`, and whether the labels confirm it.

    :param R, t: (C, 3, 3), (C, 3) the frames of its components. :param rims: (C,) to fill: `Evidence.rim` of each.
    """
    for c in range(by.n_components):
        best, most, total = -1, -1.0, 0.0
        for p in range(len(s.component)):
            if s.component[p] == c and s.marker_of[p] >= 0:
                total += said.votes[h, p]
                size = said.area_px[h, p] * ((1.0 if supports(said, by, h, p, 0.0) else 0.0) + 1e-3)
                if size > most:
                    best, most = p, size
        looked = said.area_px[h, best] > 0.0
        which, mixed = class_shown(s, best, by, R[c], t[c], view, limits, room) if looked else (0, 0.0)
        sure = supports(said, by, h, best, mixed)
        # a wider one has room for what would confirm it between the seams on its two sides
        width = 2 * said.full_px[h, best] / max(s.perimeter[s.marker_of[best]] * said.scale[h], 1e-9)
        seen = said.agree[h, best] > by.told_agree and said.area_px[h, best] > by.min_px
        shown = sure or c == by.root or (total > 0.0 and seen and width < by.thin_px)
        found.marker_votes[h, c], found.confirmed[h, c] = total, sure
        found.shown[h, c] = best if shown else -1
        looked = looked and (shown or by.facing)
        looks = outline_of(s, said, by, h, best, by.each[best, which], looked, R[c], t[c], view, limits, room)
        found.outline[h, c], rim, parted = looks
        found.parted[h, c] = rims[c] = 0.0
        if found.shown[h, c] >= 0 and said.area_px[h, best] > 0.0:
            found.parted[h, c] = parted if by.choices[best] == 1 else min(parted / by.enough, 1.0)
            rims[c] = rim / max(by.rim, 1e-12)


@lean
def in_image(s: Surface, p: int, A: Any, b: Any, view: LabelView) -> bool:
    """Whether some of the contour of marker `p` lies in the image."""
    on = s.contour[s.marker_of[p]]
    for i in range(on.shape[1]):
        x, y, z = turned(A, on[:, i])
        u, v = project(x + b[0], y + b[1], z + b[2], view)
        if z + b[2] > LEAST_DEPTH_M and -0.5 < u < view.width - 0.5 and -0.5 < v < view.height - 0.5:
            return True
    return False


@lean
def out_of_sight(s: Surface, said: Said, by: Criteria, h: int, A: Any, b: Any, view: LabelView) -> bool:
    """Whether the required component, in a frame (3, 3), (3,), is turned away, hidden or out of the image."""
    seen_px = 0.0
    for p in range(len(s.component)):
        if s.component[p] == by.root and s.marker_of[p] >= 0 and in_image(s, p, A, b, view):
            seen_px += said.area_px[h, p]
    return seen_px <= by.min_px


@lean
def bears_others(
    s: Surface, said: Said, by: Criteria, h: int, A: Any, b: Any, view: LabelView, limits: SurfaceLimits, room: Room
) -> bool:  # fmt: skip
    """Whether some marker of the required component, in a frame (3, 3), (3,), shows another class: then it is not the
    labels that are gone, but it is not there."""
    for p in range(len(s.component)):
        if s.component[p] != by.root or s.marker_of[p] < 0 or (s.stack[p] >= 0 and said.area_px[h, p] <= 0.0):
            continue
        cosine, _, _, depth = aspect(s, p, A, b)
        if cosine <= limits.least_cosine or depth <= LEAST_DEPTH_M:
            continue
        locate(A, b, points_of(s, p, s.count[p]), view, room.at[0])
        others, seen = 0.0, 0
        for i in range(s.count[p]):
            code = view.padded[room.at[0, i]]
            if code != limits.owned and code != limits.outside:
                seen += 1
                others += by.others[code]
        if others > by.supported_agree * seen:
            return True
    return False


@lean
def weigh(s: Surface, said: Said, by: Criteria, h: int, root: int, cosine: float, rim: float, found: Found) -> None:
    """What speaks for claim `h`, after `confirm`.

    :param root: the required component, or another one that stands in for it. :param cosine: see `Evidence.facing`, of
        that. :param rim: `Evidence.rim`.
    """
    root_votes, root_px, votes, area_px, missing_px = 0.0, 0.0, 0.0, 0.0, 0.0
    seen, body_votes, body_px, face_votes, face_px, bare, faceless = False, 0.0, 0.0, 0.0, 0.0, True, True
    for p in range(len(s.component)):
        c, v, a = s.component[p], said.votes[h, p], said.area_px[h, p]
        if s.marker_of[p] < 0:
            if by.told[p] and a > 0.0:
                face_votes, face_px, faceless = face_votes + v, face_px + a, False
                if c == root:
                    body_votes, body_px, bare = body_votes + v, body_px + a, False
        elif c == root:
            root_votes, root_px = root_votes + v, root_px + a
        else:
            votes, area_px, seen = votes + v, area_px + a, seen or a > by.min_px
            missing_px += 0.0 if found.confirmed[h, c] else a
    others, shown, outlines, parted, length = 0, -1, 0.0, 0.0, 0.0
    for c in range(by.n_components):
        shown += found.shown[h, c] >= 0 and (c != by.root or c == root)
        if c != root and found.confirmed[h, c]:
            others += 1
            px = perimeter_px(s, said, h, found.shown[h, c])
            outlines, length = outlines + found.outline[h, c] * px, length + px
            parted += found.parted[h, c] * px
    found.case[h] = BORNE_OUT if others else (DESERTED if seen else ALONE)
    row = found.evidence[h]
    row[0], row[1], row[2] = math.log(max(said.total[h], 1.0)), found.outline[h, root], 1.0 if bare else 0.0
    row[3], row[4] = by.bare if bare else body_votes / max(body_px, 1.0), shown
    row[5], row[6] = (root_votes + votes) / max(root_px + area_px, 1.0), votes / max(area_px, 1.0)
    row[7], row[8] = outlines / max(length, 1e-9), by.bare if faceless else face_votes / max(face_px, 1.0)
    row[9], row[10] = cosine, -math.log1p(missing_px)
    row[11] = -missing_px / max(root_px + area_px, 1.0)
    row[12], row[13] = rim, found.parted[h, root]
    row[14] = parted / max(length, 1e-9)


@lean
def stand_in(s: Surface, said: Said, by: Criteria, h: int, R: Any, t: Any, rims: Any, found: Found) -> None:
    """What speaks for claim `h`, whose required component shows nothing, with the one that shows most of the rigid body
    that it is part of in its place: which of them is called required makes no other object of it.

    :param R, t, rims: as of `confirm`.
    """
    root, most = -1, 0.0
    for c in range(by.n_components):
        if by.rigid[c] and found.confirmed[h, c] and said.area_px[h, found.shown[h, c]] > most:
            root, most = c, said.area_px[h, found.shown[h, c]]
    if root >= 0:
        first = UNSEEN_ALONE if found.case[h] == UNSEEN else FADED_ALONE
        weigh(s, said, by, h, root, aspect(s, found.shown[h, root], R[root], t[root])[0], rims[root], found)
        found.case[h] += first


@jit
def examine(
    s: Surface, chain: Chain, R: Any, t: Any, q: Any, view: LabelView, limits: SurfaceLimits, said: Said, by: Criteria,
    found: Found,
) -> None:  # fmt: skip
    """Fill `found` with what labels say of claims R (H, 3, 3), t (H, 3), q (H, J)."""
    n_c, n_joints = len(chain.parent), q.shape[1]
    frames_R, frames_t, scratch = np.empty((n_c, 3, 3)), np.empty((n_c, 3)), np.empty((3, 3, 3))
    joints, room, rims = np.empty((2, n_joints, 3)), room_of(s), np.empty(n_c)
    for h in range(len(R)):
        place_seen(chain, R[h], t[h], q[h], frames_R, frames_t, joints[0], joints[1], scratch)
        if by.overlaps:
            cover(s, frames_R, frames_t, view, limits, room)
        confirm(s, said, by, h, frames_R, frames_t, view, limits, room, found, rims)
        spare, distinct = freedom(chain, by.alike, found.confirmed[h])
        found.evidence[h, 18], found.evidence[h, 19] = spare, distinct
        found.times[h] = times_mixed_up(by.alike, spare, distinct)
        A, b = frames_R[by.root], frames_t[by.root]
        weigh(s, said, by, h, by.root, aspect(s, found.shown[h, by.root], A, b)[0], rims[by.root], found)
        if found.case[h] == BORNE_OUT and not found.confirmed[h, by.root]:
            if out_of_sight(s, said, by, h, A, b, view):
                found.case[h] = UNSEEN
            elif by.fades and not bears_others(s, said, by, h, A, b, view, limits, room):
                found.case[h] = FADED
            if found.case[h] != BORNE_OUT:
                stand_in(s, said, by, h, frames_R, frames_t, rims, found)
