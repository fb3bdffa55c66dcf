"""One solution for all groups of a frame and all targets together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..alignment.matching import Matches
from ..base.config import RecognizerConfig
from ..base.deadline import Deadline
from .group_kernels import conflicts
from .group_search import Group, GroupSearch
from .margins import runner_up_margins
from .packing import pack


@dataclass(frozen=True)
class Lost:
    """A group that is no object.

    :param explained: share of its blobs' contours that is explained, where that is too little; else None.
    :param rivals: accepted groups that lay claim to its pixels.
    """

    group: Group
    explained: float | None = None
    rivals: tuple[Group, ...] = ()


@dataclass(frozen=True)
class Solution:
    """:param accepted: groups of which no two share pixels; lost: each other seed's best group, if it had any.
    :param out_of_nodes: `search_nodes` cut the search short, and the choice is only the best so far; whether the
        deadline did is the deadline's to tell.
    :param margins: of each accepted group (`margins.runner_up_margins`).
    """

    accepted: list[Group]
    lost: list[Lost]
    out_of_nodes: bool
    margins: list[float | None]


def solve(searches: list[GroupSearch], matches: Matches, config: RecognizerConfig, deadline: Deadline) -> Solution:
    """Choose the groups that together explain the most contour without sharing pixels."""
    pool: list[Group] = []
    for search in searches:
        pool += search.best_groups_of_all()
    if not pool:
        return Solution([], [], any(s.out_of_nodes for s in searches), [])
    pool += _without_contested(searches, pool, matches, config)
    conflict = _conflicts(pool, matches, config)
    weight = np.array([g.weight for g in pool])
    chosen, _, out_of_nodes = pack(weight, conflict, config.grouping.search_nodes, deadline)
    kept, unexplained = _explained_enough([pool[g] for g in chosen], matches, config)
    stay = [n for n in chosen if any(pool[n] is g for g in kept)]
    same = [(id(g.candidates), g.choice) for g in pool]
    margins = runner_up_margins(weight, conflict, stay, same, config.grouping.search_nodes, deadline)
    held = {g.seed for g in kept} | {u.group.seed for u in unexplained}
    loses_to = conflict[:, stay].tolist()
    lost = [
        Lost(g, rivals=tuple(pool[n] for n, rival in zip(stay, loses_to[i], strict=True) if rival))
        for i, g in enumerate(pool)
        if g.seed not in held
    ]
    out_of_nodes |= any(search.out_of_nodes for search in searches)
    return Solution([pool[n] for n in stay], [*unexplained, *lost], out_of_nodes, margins)


def _without_contested(
    searches: list[GroupSearch], pool: list[Group], matches: Matches, config: RecognizerConfig
) -> list[Group]:
    """Groups that do without the instances other seeds claim too: a leg between two torsos can go to either."""
    shared = matches.overlap > config.grouping.max_overlap
    members: dict[int, list[int]] = {}  # seed's instance -> instances of its groups
    mine: dict[tuple[int, int], set[int]] = {}  # (search, seed) -> instances besides the seed
    number = {id(search.candidates): n for n, search in enumerate(searches)}
    for g in pool:
        members.setdefault(g.seed, []).extend(g.matches)
        mine.setdefault((number[id(g.candidates)], g.members[0]), set()).update(g.matches[1:])
    uses = np.bincount([m for matches_of in members.values() for m in matches_of], minlength=len(matches))
    cases: list[list[tuple[int, frozenset[int]]]] = [[] for _ in searches]
    for (n, seed), others in sorted(mine.items()):
        own = np.array(sorted(others), int)
        instance = int(searches[n].candidates.match[seed])
        theirs = uses > np.bincount(members[instance], minlength=len(matches))
        contested = own[(shared[own] & theirs).any(axis=1)].tolist()
        without = {frozenset([m]) for m in contested} | ({frozenset(contested)} if contested else set())
        cases[n] += [(seed, banned) for banned in without]
    return [g for search, mine_of in zip(searches, cases, strict=True) for g in search.best_without(mine_of)]


def _conflicts(pool: list[Group], matches: Matches, config: RecognizerConfig) -> NDArray[np.bool_]:
    """(G, G) groups that lay claim to the same pixels; a group conflicts with itself."""
    counts = np.array([len(g.matches) for g in pool])
    members = np.zeros((len(pool), counts.max()), np.int64)
    for g, group in enumerate(pool):
        members[g, : counts[g]] = group.matches
    return conflicts(members, counts, matches.overlap > config.grouping.max_overlap)


def _explained_enough(
    accepted: list[Group], matches: Matches, config: RecognizerConfig
) -> tuple[list[Group], list[Lost]]:
    """Drop groups whose blobs' contours stay largely unexplained by all accepted groups together.

    Judged per blob and not per match, so that components merged in one blob stand by each other.
    """
    if matches.cmap is None or not accepted:
        return accepted, []
    blob_of_point, length = matches.cmap.blob, matches.cmap.lengths
    points = {m: matches.explained(m) for g in accepted for m in g.matches}
    explained = np.zeros(len(blob_of_point), bool)
    for mine in points.values():
        explained[mine] = True
    share = np.bincount(blob_of_point[explained], minlength=len(length)) / length
    kept: list[Group] = []
    dropped: list[Lost] = []
    for group in accepted:
        own = np.concatenate([points[m] for m in group.matches])
        # by where the group's evidence lies, so that a corner of a neighbour's blob does not count
        here = float(share[blob_of_point[own]].sum() / len(own)) if len(own) else 1.0
        if here >= config.grouping.min_explained:
            kept.append(group)
        else:
            dropped.append(Lost(group, explained=here))
    return kept, dropped
