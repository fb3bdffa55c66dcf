"""Where the boundary of a class crosses a contour's normals, all points of a contour in step."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, melted
from ..geometry.pixel_kernels import LabelView, padded_pixel

OWN, KNOWN, SILENT = 0, 1, 2  # kinds of labels along a marker's normal: its own, another's, one that says nothing


class EdgeTerms(NamedTuple):
    """What `find_edges` is told once, and of each of the steps of a fit."""

    reach: Any  # (steps,)
    step_in: float  # factors on the likelihood of a boundary one place further out, by the label passed
    step_seam: float
    step_out: float
    prior: Any  # (steps, n) of each place, the first 2 reach + 2 count
    seam_px: Any  # (M,) half the seam of each marker's class
    on_unknown: bool  # unknown pixels beyond a marker may be a body of the object, which ends it, and no seam
    kind: Any  # (M, 256) int32, of each label for each marker
    no_end: int  # codes from here on end no marker: they begin where the image ends, or what lies before the marker
    beyond: float  # as likely as this beyond reach, there is no edge
    border_px: float  # nor is there one so near to the image's border


class EdgeRoom(NamedTuple):
    """Scratch arrays of the m points of one contour."""

    outline: Any  # (4, m), see `outline_pixels`
    at: Any  # (m,)
    kind: Any  # (2 max reach + 1, m)
    # (8, m) own inside, not own outside, last known place, silent outside, a seam in between; of `leave_bodies` the
    # last own place, unknown ones up to the next known one, whether there was none yet
    flags: Any
    sums: Any  # (6, m) likelihood; its sum, the places' and their squares' by it; its last; one for the caller
    edge: Any  # (m,) signed distance of the edge along the normal
    weight: Any  # (m,) 0: no edge
    rows: Any  # (9 + J, m) of derivatives, and behind those that are used the points' x, y and z


@jit
def edge_room(m: int, most_reach: int, n_par: int) -> EdgeRoom:
    """Scratch arrays for contours of `m` points that move with `n_par` parameters."""
    return EdgeRoom(
        np.empty((4, m)), np.empty(m, np.int32), np.empty((2 * most_reach + 1, m), np.int32),
        np.empty((8, m), np.int32), np.empty((6, m)), np.empty(m), np.empty(m), np.empty((n_par + 3, m)),
    )  # fmt: skip


@melted
def look_along(k: int, reach: int, e: EdgeTerms, view: LabelView, room: EdgeRoom) -> None:
    """Fill room.kind with the kinds of the labels along the normals, and room.flags with what they tell together.

    Points of the outline that are no numbers, or beyond all bounds, are put where there is no edge.
    """
    us, vs, nus, nvs = room.outline[0], room.outline[1], room.outline[2], room.outline[3]
    for i in range(len(us)):
        if not abs(us[i]) + abs(vs[i]) + abs(nus[i]) + abs(nvs[i]) < 1e9:
            us[i], vs[i], nus[i], nvs[i] = -9.0, -9.0, 0.0, 0.0
    at, kinds = room.at, e.kind[k]
    inner, outer, last, silent = room.flags[0], room.flags[1], room.flags[2], room.flags[3]
    inner[:], outer[:], last[:], silent[:] = 0, 0, -1, 0
    for n in range(2 * reach + 1):
        off, row = float(n - reach), room.kind[n]
        for i in range(len(us)):
            at[i] = padded_pixel(us[i] + off * nus[i], vs[i] + off * nvs[i], view)
        for i in range(len(us)):
            row[i] = kinds[view.padded[at[i]]]
        for i in range(len(us)):
            last[i] = n if row[i] == KNOWN else last[i]
        if n < reach:
            for i in range(len(us)):
                inner[i] |= row[i] == OWN
        else:
            for i in range(len(us)):
                outer[i] |= row[i] != OWN
        if n > reach:
            for i in range(len(us)):
                silent[i] |= row[i] == SILENT


@melted
def leave_bodies(reach: int, seam_px: float, room: EdgeRoom) -> None:
    """Along normals on which more unknown pixels lie between the marker's last one and the next known one than in a
    seam, these are of a body: the marker ends where they begin."""
    last, own, gap, goes_on = room.flags[2], room.flags[5], room.flags[6], room.flags[7]
    own[:], gap[:], goes_on[:] = -1, 0, 0
    for n in range(2 * reach + 1):
        row = room.kind[n]
        for i in range(len(last)):
            if row[i] == OWN:
                own[i], gap[i], goes_on[i] = n, 0, 1
            elif row[i] == KNOWN:
                goes_on[i] = 0
            else:
                gap[i] += goes_on[i]
    for i in range(len(last)):
        last[i] = own[i] if gap[i] > math.ceil(2 * max(seam_px, 0.0)) else last[i]


@melted
def find_edges(k: int, e: EdgeTerms, step: int, view: LabelView, room: EdgeRoom) -> None:
    """Where the boundary of marker `k`'s class crosses the normals of its contour, which is room.outline: fill
    room.edge with signed distances along the normals, and room.weight with inverse variances (0: no edge).

    The labels along each normal, up to a step's `reach` in and out, are explained by every place of the boundary; the
    edge is the mean of these places under their likelihood, so it comes to lie in the middle of a seam of unknown
    pixels between two classes. Where only unknown pixels follow, or such as may be the marker's body, half the usual
    seam is added.
    """
    reach, prior = e.reach[step], e.prior[step]
    look_along(k, reach, e, view, room)
    inner, outer, last, silent, seam = room.flags[0], room.flags[1], room.flags[2], room.flags[3], room.flags[4]
    likelihood, total, mean, square, end = room.sums[0], room.sums[1], room.sums[2], room.sums[3], room.sums[4]
    likelihood[:], total[:], mean[:], square[:], seam[:] = 1.0, 0.0, 0.0, 0.0, 0
    m, step_in, step_seam, step_out = len(total), e.step_in, e.step_seam, e.step_out
    if e.on_unknown:
        leave_bodies(reach, e.seam_px[k], room)
    for n in range(2 * reach + 2):
        place, before = n - reach - 0.5, prior[n]
        for i in range(m):
            p = likelihood[i] * before
            total[i] += p
            mean[i] += p * place
            square[i] += p * place * place
            end[i] = p
        if n == 2 * reach + 1:
            break
        row = room.kind[n]
        for i in range(m):
            in_seam = (row[i] == SILENT) & (n < last[i])
            seam[i] |= in_seam
            likelihood[i] *= step_in if row[i] == OWN else (step_seam if in_seam else step_out)
    for i in range(m):
        room.edge[i] = room.weight[i] = 0.0
        if not (inner[i] and outer[i]) or prior[0] + end[i] >= e.beyond * total[i]:
            continue
        edge = mean[i] / total[i]
        variance = square[i] / total[i] - edge * edge
        if silent[i] and not seam[i]:
            edge += e.seam_px[k]
        u, v, out = room.outline[0, i], room.outline[1, i], edge + e.border_px
        if view.padded[padded_pixel(u + out * room.outline[2, i], v + out * room.outline[3, i], view)] >= e.no_end:
            continue  # not the marker ends there but what is seen of it
        room.edge[i], room.weight[i] = edge, 1.0 / (1.0 + variance)
