"""Votes of the label image for a surface under many hypotheses."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, melted
from ..geometry.pixel_kernels import LabelView, locate, locate_level, turned
from ..model.chain_kernels import Chain, place_seen
from .covering_kernels import COVERED, cover
from .hiding_kernels import ALL_BOXES, bit_of, boxes_in_camera, boxes_in_front, hide
from .sharing_kernels import choose_of_stacks, explain_once
from .surface_kernels import (
    LEAST_DEPTH_M,
    MOST_LENGTH,
    Room,
    Surface,
    SurfaceLimits,
    aspect,
    count_for,
    is_near,
    is_turned_here,
    look_beside,
    points_of,
    room_of,
    surface_share,
    weigh_points,
    widened,
)

LEAST_KNOWN = 0.5  # of a contour, that what is seen of it speaks for all of it


class Scores(NamedTuple):
    """What the labels say of the patches of one hypothesis, see `spatial.PatchScores`."""

    votes: Any  # (P,)
    area_px: Any  # (P,)
    agree: Any  # (P,)
    near: Any  # (P,) boxes that may hide it: a bit for each, several may share one


@melted
def ring_votes(
    s: Surface, k: int, own: Any, A: Any, b: Any, depth: float, near: bool, cut: bool, view: LabelView,
    limits: SurfaceLimits, room: Room,
) -> tuple[float, float]:  # fmt: skip
    """Mean vote of what lies just inside and just outside the contour of marker `k`, and the share of the contour
    within the image that does not lie amid its class; 0 where none is. Where other parts of the object's lie beyond,
    nothing is told; where these leave less than half of it, no more is known than of half. Where another side of its
    component begins is no contour.

    :param own: (256,) how far each code is of its class. :param depth: of its middle. :param near: see `is_near`.
    :param cut: whether `room.hidden` tells which points of it boxes hide: there it is their outline that is seen.
    """
    look_beside(s, k, A, b, depth, view, limits, room)
    outer, inner, meets, goes_on = room.at[0], room.at[1], s.has_meets[k], room.inner
    out, into, is_open, on = s.table[s.ring_role[k]], s.table[s.rim_role[k]], room.open[k], s.contour[k]
    m, ring, seen, amid, within = on.shape[1], 0.0, 0, 0.0, 0
    for i in range(m):
        if (cut and room.hidden[i]) or (meets and goes_on[i]):
            continue
        beyond = view.padded[outer[i]]
        if beyond != limits.outside:  # else not the marker ends there but the image
            within += 1
            if is_open[i] == COVERED:
                continue
            vote = is_open[i] * out[beyond] + into[view.padded[inner[i]]]
            if near:  # lengths shrink with their depth
                z = A[2, 0] * on[0, i] + A[2, 1] * on[1, i] + A[2, 2] * on[2, i] + b[2]
                vote *= min(depth / max(z, LEAST_DEPTH_M), MOST_LENGTH)
            ring += vote
            seen += 1
            amid += is_open[i] * own[beyond]
    if meets and within == 0:
        return 0.0, 1.0  # other sides part all of them from what is around
    return ring / m, (seen - amid) / max(seen, LEAST_KNOWN * within, 1.0)


@jit
def score_patches(
    s: Surface, chain: Chain, R: Any, t: Any, q: Any, patches: Any, view: LabelView, limits: SurfaceLimits,
    occlusion: bool, covered: bool, votes: Any, area_px: Any, agree: Any,
) -> None:  # fmt: skip
    """Fill votes, area_px, agree (H, P) of hypotheses R (H, 3, 3), t (H, 3), q (H, J): see `spatial.PatchScores`.

    :param covered: markers' contours are looked at with the object's other parts in place.
    """
    room, scratch, n_c = room_of(s), np.empty((3, 3, 3)), len(chain.parent)
    frames_R, frames_t, joints = np.empty((n_c, 3, 3)), np.empty((n_c, 3)), np.empty((2, q.shape[1], 3))
    all_moved, near, column = np.ones(n_c, np.bool_), np.empty(len(patches), np.int64), np.empty(len(s.area), np.int64)
    column[:] = -1
    for i in range(len(patches)):
        column[patches[i]] = i
    for h in range(len(R)):
        place_seen(chain, R[h], t[h], q[h], frames_R, frames_t, joints[0], joints[1], scratch)
        if covered:
            cover(s, frames_R, frames_t, view, limits, room)
        scores = Scores(votes[h], area_px[h], agree[h], near)
        score_hypothesis(s, frames_R, frames_t, patches, all_moved, view, limits, occlusion, room, scores)
        choose_of_stacks(s, column, scores.votes, scores.area_px, scores.agree)
        if len(patches) == len(s.area):
            f2 = view.K[0, 0] * view.K[1, 1]
            explain_once(
                s, frames_R, frames_t, f2, limits, True, room, scores.votes, scores.area_px, scores.agree
            )  # fmt: skip


@melted
def score_hypothesis(
    s: Surface, R: Any, t: Any, patches: Any, moved: Any, view: LabelView, limits: SurfaceLimits, occlusion: bool,
    room: Room, scores: Scores,
) -> None:  # fmt: skip
    """Fill the scores of patches under one hypothesis: (C, 3, 3), (C, 3).

    :param moved: (C,) components that are elsewhere than the scores are of: patches of others, of which these hide
        nothing and hid nothing, keep theirs.
    """
    blocked, moved_boxes, f2 = occlusion and len(s.half) > 0, 0, view.K[0, 0] * view.K[1, 1]
    if blocked:
        boxes_in_camera(s, R, t, room.box_rotation, room.eye, room.middle)
        for k in range(len(s.half)):
            if moved[s.box_component[k]]:
                moved_boxes |= bit_of(k)
    for column in range(len(patches)):
        p = patches[column]
        stays = not moved[s.component[p]]
        if stays and not moved_boxes:
            continue
        A, b = R[s.component[p]], t[s.component[p]]
        cosine, mx, my, mz = aspect(s, p, A, b)
        in_view = is_turned_here(s, p, cosine, mz, f2, limits.least_cosine) and mz > LEAST_DEPTH_M
        normal, centre, n_near, near = turned(A, s.normal[p]), (mx, my, mz), 0, 0
        if stays and in_view:
            stays = scores.near[column] & moved_boxes == 0
            stays = stays and boxes_in_front(s, p, A, normal, centre, room, moved_boxes) == 0
        if stays:
            continue
        if in_view and blocked:
            n_near = boxes_in_front(s, p, A, normal, centre, room, ALL_BOXES)
            for n in range(n_near):
                near |= bit_of(room.near[n])
        scores.near[column] = near
        scores.votes[column] = scores.area_px[column] = scores.agree[column] = 0.0
        if in_view:
            said = said_of(s, p, A, b, cosine, mz, n_near, view, limits, room)
            scores.votes[column], scores.area_px[column], scores.agree[column] = said


@melted
def enlarge(A: Any, b: Any, centre: Any, times: float, room: Room) -> None:
    """Fill room.wide, room.moved with a patch's place at which its points are so many times as far from its centre."""
    wide, moved = room.wide, room.moved
    for i in range(3):
        moved[i] = b[i]
        for j in range(3):
            wide[i, j] = times * A[i, j]
            moved[i] += (1 - times) * A[i, j] * centre[j]


@melted
def said_of(
    s: Surface, p: int, A: Any, b: Any, cosine: float, depth: float, n_near: int, view: LabelView,
    limits: SurfaceLimits, room: Room,
) -> tuple[float, float, float]:  # fmt: skip
    """Votes, visible pixels and agreement of a patch in view; the first `n_near` boxes of `room.near` may hide it."""
    f2 = view.K[0, 0] * view.K[1, 1]
    total, all_of_it, shown, seen, same, beyond = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    role, own = s.table[s.role[p]], s.own[s.role[p]]
    size = s.area[p] * f2 / depth**2 * cosine
    count, near = count_for(s, p, size, limits), is_near(s, p, depth)
    on, times, A_of_all, b_of_all = points_of(s, p, count), 1.0, A, b
    if limits.swollen_px != 0.0 and s.marker_of[p] >= 0:  # twice the area over the perimeter: a radius
        times += limits.swollen_px * depth * s.perimeter[s.marker_of[p]] / (2 * s.area[p] * math.sqrt(f2))
        enlarge(A, b, s.centre[p], times, room)
        A_of_all, b_of_all = room.wide, room.moved
    if limits.level:
        locate_level(A_of_all, b_of_all, on, view, room.at[0])
    else:
        locate(A_of_all, b_of_all, on, view, room.at[0])
    if near:
        weigh_points(A_of_all, b_of_all, on, depth, room.weight)
    if n_near:
        hide(s, A_of_all, b_of_all, on, room, n_near, surface_share(s, p, depth, limits.behind))
    k = s.marker_of[p]
    for i in range(count):
        weight = room.weight[i] if near else 1.0
        all_of_it += weight
        if n_near and room.hidden[i]:
            continue
        shown += weight
        found = view.padded[room.at[0, i]]
        if found == limits.owned:
            continue
        if found == limits.outside:  # says nothing, and may stand for more pixels than the image has
            weight = min(weight, 1.0)
            beyond += weight if s.bulge[p] > 0.0 else 0.0
        seen += weight
        total += weight * role[found]
        same += weight * own[found]
    size *= times * times
    value = total / count * size
    cut = k >= 0 and seen > 0.0 and n_near > 0 and shown < all_of_it
    if cut:  # as by a bezel, the outline may be hidden altogether
        on = s.contour[k]
        hide(s, A, b, (on[0], on[1], on[2]), room, n_near, surface_share(s, p, depth, limits.behind))
        cut = not room.hidden[: on.shape[1]].all()
    if k >= 0 and seen > limits.ring_visible * (shown if cut else all_of_it):
        ring, parted = ring_votes(s, k, own, A, b, depth, near, cut, view, limits, room)
        value = value * parted if value > 0.0 else value  # amid its class there is nothing to tell a marker by
        value += ring * ring_px2(s, k, cosine, depth, f2, limits) * times
    seen -= beyond  # what the image shows of a ball tells all of it
    return value, size * seen / count, same / max(seen, 1e-9)


@melted
def is_supported(votes: float, area_px: float, agree: float, min_px: float, least_agree: float) -> bool:
    """Whether labels support a marker by what they say of it: see `WholeObjectFinder.supported`."""
    return area_px > min_px and agree > least_agree and votes > 0.0


@melted
def ring_px2(s: Surface, k: int, cosine: float, depth: float, f2: float, limits: SurfaceLimits) -> float:
    """Pixels that a marker's ring stands for."""
    width_px = limits.ring_width_px * widened(s, k, depth, f2, limits)
    return s.perimeter[k] * (1 + min(cosine, 1.0)) / 2 * math.sqrt(f2) / depth * width_px
