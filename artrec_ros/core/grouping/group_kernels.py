"""The search for one seed's groups: depth first, with a bound of what is to come (paper, step 8)."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from ..base.jit import jit, melted


class Pool(NamedTuple):
    """Candidates of one target, and how they go together in pairs.

    :param component, match, weight, share, score, scale: (n,) as in `Candidates`.
    :param forbidden, checked, violation: (n, n) as in `PairTable`.
    """

    component: np.ndarray
    match: np.ndarray
    weight: np.ndarray
    share: np.ndarray
    score: np.ndarray
    scale: np.ndarray
    forbidden: np.ndarray
    checked: np.ndarray
    violation: np.ndarray


class Rules(NamedTuple):
    """What makes a group an object: values of `RecognizerConfig` and constants of `grouping`.

    :param absent_m: (N,) what each component's absence costs, contour in metres.
    """

    absent_m: np.ndarray
    required: int
    most_options: int
    most_groups: int
    most_nodes: int
    least_components: int
    min_satisfied: float
    min_group_match: float
    min_alone_match: float
    least_weight: float


@jit
def _options(pool: Any, seed: int, rules: Any, banned: Any) -> Any:
    """(N, most_options) candidates of each component that go with the seed, heaviest first, and their numbers."""
    components = len(rules.absent_m)
    options, count = np.empty((components, rules.most_options), np.int64), np.zeros(components, np.int64)
    for i in range(len(pool.component)):
        c = pool.component[i]
        if c == rules.required or pool.forbidden[seed, i] or pool.violation[seed, i] > 0 or banned[pool.match[i]]:
            continue
        at = count[c]
        while at > 0 and pool.weight[options[c, at - 1]] < pool.weight[i]:
            at -= 1
        if at == rules.most_options:
            continue
        count[c] = min(count[c] + 1, rules.most_options)
        for j in range(count[c] - 1, at, -1):
            options[c, j] = options[c, j - 1]
        options[c, at] = i
    return options, count


@melted
def _cost(pool: Any, option: int, members: Any) -> float:
    """What an option's violated constraints with the members cost: each as much as the lighter of the two explains;
    infinite where one is forbidden."""
    cost = 0.0
    for m in members:
        if pool.forbidden[option, m]:
            return np.inf
        if pool.violation[option, m] > 0:
            cost += min(pool.weight[option], pool.weight[m])
    return cost


@jit
def _judge(pool: Any, rules: Any, members: Any) -> Any:
    """(whether the members are an object, score, satisfied, checked): enough components, each tied to another by a
    constraint that holds, and enough of the constraints that can be checked hold."""
    n, components = len(members), len(rules.absent_m)
    checked, satisfied = 0, 0
    share, score, tied = 0.0, 0.0, True
    for i in range(n):
        ties = 0
        for j in range(n):
            if pool.checked[members[i], members[j]]:
                good = pool.violation[members[i], members[j]] <= 0
                ties += good
                if j < i:
                    checked += 1
                    satisfied += good
        tied = tied and ties > 0
        share += pool.share[members[i]]
        score += pool.score[members[i]]
    if n > 1 and not tied:
        return False, 0.0, 0, 0
    if n < min(rules.least_components, components) or satisfied < rules.min_satisfied * checked:
        return False, 0.0, 0, 0
    if share / n < (rules.min_group_match if satisfied else rules.min_alone_match):
        return False, 0.0, 0, 0
    held = satisfied / checked if checked else 1.0
    # A missing component may be hidden; it halves the trust at most.
    return True, score / n * held * (0.5 + 0.5 * n / components), satisfied, checked


class Groups(NamedTuple):
    """The heaviest groups so far, as many as there is room for.

    :param found: (1,) how many there are, and
    :param lightest: (1,) which one gives way when there is no more room.
    :param held, members: (G,) how many members, and (G, N) which, the seed first.
    :param number: (G,) the node of the search that found each.
    """

    found: np.ndarray
    lightest: np.ndarray
    held: np.ndarray
    members: np.ndarray
    weight: np.ndarray
    score: np.ndarray
    satisfied: np.ndarray
    checked: np.ndarray
    number: np.ndarray


@jit
def _no_groups(rules: Any) -> Any:
    most, components = rules.most_groups, len(rules.absent_m)
    held, members = np.zeros(most, np.int64), np.zeros((most, components), np.int64)
    counted = np.zeros(most, np.int64), np.zeros(most, np.int64), np.zeros(most, np.int64)
    one = np.zeros(1, np.int64), np.zeros(1, np.int64)
    return Groups(*one, held, members, np.zeros(most), np.zeros(most), *counted)


@melted
def _least_wanted(groups: Any) -> float:
    """What a group must weigh to be kept."""
    return groups.weight[groups.lightest[0]] if groups.found[0] == len(groups.weight) else -np.inf


@jit
def _keep(groups: Any, rules: Any, pool: Any, members: Any, value: float, number: int) -> None:
    """Take members in, where they are an object and heavy enough; where there is no room, in the lightest's place."""
    valid, score, satisfied, checked = _judge(pool, rules, members)
    # rounded: which of two equal groups goes first does not hang on the order of sums
    heavy = round(max(value, rules.least_weight * pool.weight[members].sum()), 6)
    if not valid or heavy < _least_wanted(groups):
        return
    full = groups.found[0] == len(groups.weight)
    at = groups.lightest[0] if full else groups.found[0]
    groups.found[0] += not full
    groups.members[at, : len(members)], groups.held[at] = members, len(members)
    groups.weight[at], groups.score[at], groups.number[at] = heavy, score, number
    groups.satisfied[at], groups.checked[at] = satisfied, checked
    lightest = 0
    for g in range(1, groups.found[0]):
        equal = groups.weight[g] == groups.weight[lightest]
        if groups.weight[g] < groups.weight[lightest] or (equal and groups.number[g] < groups.number[lightest]):
            lightest = g
    groups.lightest[0] = lightest


@jit
def _to_come(pool: Any, absent: Any, options: Any, order: Any) -> Any:
    """(depths + 1,) what the components of a depth and of those after it add to a group's weight at most."""
    rest = np.zeros(len(order) + 1)
    for d in range(len(order) - 1, -1, -1):
        rest[d] = rest[d + 1] + pool.weight[options[order[d], 0]] + absent[order[d]]
    return rest


@jit
def best_groups(pool: Any, seed: int, rules: Any, banned: Any) -> Any:
    """The heaviest groups around a seed, heaviest first.

    :param banned: (instances,) not to be used.
    :return: count of members; (G, N) members, the seed first; weight, score, satisfied, checked; whether exact.
    """
    options, sizes = _options(pool, seed, rules, banned)
    order = np.argsort(sizes, kind="mergesort")
    order = order[sizes[order] > 0]
    depths = len(order)
    # A missing component costs: one whole object goes before two halves that explain the same contour.
    absent = rules.absent_m * pool.scale[seed]
    rest, groups = _to_come(pool, absent, options, order), _no_groups(rules)
    members, count = np.empty(len(rules.absent_m), np.int64), np.ones(depths + 1, np.int64)
    value, pointer = np.empty(depths + 1), np.zeros(depths + 1, np.int64)
    members[0], value[0] = seed, pool.weight[seed] + absent[rules.required] - absent.sum()
    nodes, depth, entering = 0, 0, True
    while depth >= 0:
        if entering:
            nodes += 1
            entering = False
            pointer[depth] = 0
            hopeless = nodes > rules.most_nodes or value[depth] + rest[depth] <= _least_wanted(groups) + 1e-9
            if not hopeless and depth == depths:
                _keep(groups, rules, pool, members[: count[depth]], value[depth], nodes)
            if hopeless or depth == depths:
                depth -= 1
                continue
        c, i = order[depth], pointer[depth]
        pointer[depth] += 1
        if i > sizes[c]:  # each of its options was tried, and none of them
            depth -= 1
            continue
        count[depth + 1], value[depth + 1] = count[depth], value[depth]
        if i < sizes[c]:
            option = options[c, i]
            cost = _cost(pool, option, members[: count[depth]])
            if cost == np.inf:
                continue
            members[count[depth]] = option
            count[depth + 1] += 1
            value[depth + 1] += pool.weight[option] + absent[c] - cost
        depth += 1
        entering = True
    return (*_heaviest_first(groups), nodes <= rules.most_nodes)


@jit
def _heaviest_first(groups: Any) -> Any:
    """Count of members; members, weight, score, satisfied, checked."""
    order = np.argsort(groups.number[: groups.found[0]])
    order = order[np.argsort(-groups.weight[order], kind="mergesort")]  # of equal ones the first found
    return (
        groups.held[order], groups.members[order], groups.weight[order], groups.score[order], groups.satisfied[order],
        groups.checked[order],
    )  # fmt: skip


@jit
def best_groups_of(pool: Any, seeds: Any, rules: Any, banned: Any, most: int) -> Any:
    """`best_groups`, at most so many, of several seeds one after another; `banned`: (seeds, instances)."""
    room, components = len(seeds) * rules.most_groups, len(rules.absent_m)
    held, members = np.empty(room, np.int64), np.empty((room, components), np.int64)
    weight, score = np.empty(room), np.empty(room)
    satisfied, checked = np.empty(room, np.int64), np.empty(room, np.int64)
    n, exact = 0, True
    for i in range(len(seeds)):
        mine = best_groups(pool, seeds[i], rules, banned[i])
        count = min(len(mine[0]), most)
        end = n + count
        held[n:end], members[n:end] = mine[0][:count], mine[1][:count]
        weight[n:end], score[n:end] = mine[2][:count], mine[3][:count]
        satisfied[n:end], checked[n:end] = mine[4][:count], mine[5][:count]
        exact = exact and mine[6]
        n = end
    return held[:n], members[:n], weight[:n], score[:n], satisfied[:n], checked[:n], exact


@jit
def conflicts(members: Any, counts: Any, shared: Any) -> Any:
    """(G, G) whether any of two groups' instances share pixels. :param members: (G, N) instances, `counts` of them."""
    out = np.zeros((len(counts), len(counts)), np.bool_)
    blocked = np.empty(len(shared), np.bool_)
    for g in range(len(counts)):
        blocked[:] = False
        for i in range(counts[g]):
            for k in range(len(shared)):
                blocked[k] |= shared[members[g, i], k]
        for h in range(g + 1):
            for j in range(counts[h]):
                if blocked[members[h, j]]:
                    out[g, h] = out[h, g] = True
                    break
    return out
