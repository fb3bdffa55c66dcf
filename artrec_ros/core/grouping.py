"""Groups of instances that form one object (paper, step 8), grown from each instance of the required component."""

from __future__ import annotations

import heapq
from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from .candidates import Candidates
from .compiled import group_search as compiled
from .compiled.jit import COMPILED
from .config import RecognizerConfig
from .deadline import Deadline
from .matching import Matches
from .pair_table import PairTable, pair_table, relevant
from .transforms import Array

_MAX_OPTIONS = 12  # candidates of a component carried for one seed
_DISAGREEMENT = (0.25, 1.0)  # weight lost by a pair just violated and by one far out, in shares of the lighter member's
_LEAST_WEIGHT = 0.05  # of an object whose missing components would cost more than it explains
_SEEDS_BETWEEN_LOOKS = 16  # at the clock
_FAR_OUT = 0.5  # a violation: radians, or share of the pair's greatest length


class Group(NamedTuple):
    """A possible object. A frame has hundreds: a tuple is made in a fraction of a frozen dataclass' time.

    :param members: candidates' numbers, the required component's first.
    :param matches: the instances they stand for.
    :param weight: contour explained, pixels, less what violated constraints and missing components cost.
    :param satisfied, checked: pairs.
    """

    candidates: Candidates
    members: tuple[int, ...]
    matches: tuple[int, ...]
    weight: float
    score: float
    satisfied: int
    checked: int

    @property
    def seed(self) -> int:
        """The required component's instance."""
        return self.matches[0]

    @property
    def components(self) -> tuple[int, ...]:
        """Numbers of the members' components, in the members' order."""
        component = self.candidates.component_list
        return tuple([component[m] for m in self.members])

    @property
    def choice(self) -> frozenset[tuple[int, int]]:
        """(component, instance) of all members: the same for groups that differ in turns alone."""
        choices = self.candidates.choices
        return frozenset([choices[m] for m in self.members])


class GroupSearch:
    """The search for one target's groups in one frame. `exact` turns False where its node limit cuts it short."""

    def __init__(self, candidates: Candidates, matches: Matches, config: RecognizerConfig, deadline: Deadline) -> None:
        self._config = config
        self._deadline = deadline
        components = candidates.target.model.components
        self._count = len(components)
        self._required = components.index(candidates.target.model.required)
        self._perimeter_m = candidates.roles.least_perimeter_m
        self._overlap = matches.overlap
        self.seeds, self.candidates, self.table = relevant(candidates, self._required, self._overlap, config)
        self._instances = len(matches)
        self.exact = True

    @cached_property
    def table(self) -> PairTable:
        """All candidates checked in pairs."""
        everyone = np.arange(len(self.candidates))
        return pair_table(self.candidates, everyone, everyone, self._overlap, self._config)

    def forget_table(self) -> None:
        """Let go of the table, by far the largest part, until it is asked for again."""
        self.__dict__.pop("table", None)
        self.__dict__.pop("_pool", None)
        self.__dict__.pop("_pair_cost", None)

    def best_groups(self, seed: int, banned: frozenset[int] = frozenset()) -> list[Group]:
        """The heaviest groups around a seed, at most `groups_per_seed`; instances in `banned` are left out."""
        if COMPILED:
            return self._search_compiled([seed], [banned], self._config.groups_per_seed)
        return self._search(seed, banned)

    def best_groups_of_all(self) -> list[Group]:
        """Each seed's `best_groups` in turn, by the deadline."""
        return self._by_deadline([(int(seed), frozenset()) for seed in self.seeds], self._config.groups_per_seed)

    def best_without(self, cases: list[tuple[int, frozenset[int]]]) -> list[Group]:
        """The heaviest group of each (seed, banned), where there is one, by the deadline."""
        return self._by_deadline(cases, 1)

    def _by_deadline(self, cases: list[tuple[int, frozenset[int]]], most: int) -> list[Group]:
        groups: list[Group] = []
        for start in range(0, len(cases), _SEEDS_BETWEEN_LOOKS):
            if self._deadline.expired:
                break
            part = cases[start : start + _SEEDS_BETWEEN_LOOKS]
            if COMPILED:
                groups += self._search_compiled([seed for seed, _ in part], [banned for _, banned in part], most)
            else:
                groups += [g for case in part for g in self._search(*case)[:most]]
        return groups

    def _search_compiled(self, seeds: Sequence[int], banned: Sequence[frozenset[int]], most: int) -> list[Group]:
        out = np.zeros((len(seeds), self._instances), bool)
        for n, instances in enumerate(banned):
            if instances:
                out[n, list(instances)] = True
        *found, exact = compiled.best_groups_of(self._pool, np.array(seeds), self._rules, out, most)
        self.exact &= exact
        match, candidates, groups = self._match, self.candidates, []
        for count, row, *values in zip(*(column.tolist() for column in found), strict=True):
            members = tuple(row[:count])
            groups.append(Group(candidates, members, tuple([match[m] for m in members]), *values))
        return groups

    @cached_property
    def _match(self) -> list[int]:
        return self.candidates.match.tolist()

    @cached_property
    def _pool(self) -> compiled.Pool:
        c, table = self.candidates, self.table
        return compiled.Pool(
            c.component,
            c.match,
            c.weight,
            c.share,
            c.score,
            c.poses.scale,
            table.forbidden,
            table.checked,
            table.violation,
        )

    @cached_property
    def _rules(self) -> compiled.Rules:
        config = self._config
        return compiled.Rules(
            config.missing_cost * self._perimeter_m,
            self._required,
            _MAX_OPTIONS,
            config.groups_per_seed,
            config.search_nodes,
            config.min_components,
            config.min_satisfied,
            config.min_group_match,
            config.min_alone_match,
            *_DISAGREEMENT,
            _FAR_OUT,
            _LEAST_WEIGHT,
        )

    @cached_property
    def _pair_cost(self) -> Array:
        return _pair_costs(self.candidates, self.table)

    def _search(self, seed: int, banned: frozenset[int]) -> list[Group]:
        options = self._options(seed, banned)
        order = sorted(options, key=lambda c: len(options[c]))
        # A missing component costs: one whole object goes before two halves that explain the same contour.
        absent = self._config.missing_cost * float(self.candidates.poses.scale[seed]) * self._perimeter_m  # (N,) px
        gain = self.candidates.weight + absent[self.candidates.component]
        rest = np.cumsum([0.0] + [gain[options[c][0]] for c in reversed(order)])[::-1]  # bound of what is to come
        found: list[tuple[float, int, Group]] = []
        nodes = 0

        def grow(depth: int, members: list[int], value: float) -> None:
            nonlocal nodes
            nodes += 1
            if nodes > self._config.search_nodes or (nodes % 256 == 0 and self._deadline.expired):
                self.exact = False
                return
            if len(found) == self._config.groups_per_seed and value + rest[depth] <= found[0][0] + 1e-9:
                return
            if depth == len(order):
                self._keep(found, nodes, members, value)
                return
            for option in options[order[depth]]:
                cost = float(self._pair_cost[option, members].sum())
                if cost < np.inf:
                    grow(depth + 1, [*members, option], value + gain[option] - cost)
            grow(depth + 1, members, value)

        grow(0, [seed], float(gain[seed] - absent.sum()))
        return [group for _, _, group in sorted(found, key=lambda f: (-f[0], f[1]))]

    def _options(self, seed: int, banned: frozenset[int]) -> dict[int, list[int]]:
        """Component -> its candidates that go with the seed, heaviest first."""
        c, table = self.candidates, self.table
        fits = ~table.forbidden[seed] & (table.violation[seed] <= 0) & ~np.isin(c.match, list(banned))
        options = {}
        for component in range(self._count):
            mine = np.flatnonzero(fits & (c.component == component))
            if component != self._required and len(mine):
                options[component] = [int(n) for n in mine[np.argsort(-c.weight[mine], kind="stable")][:_MAX_OPTIONS]]
        return options

    def _keep(self, found: list[tuple[float, int, Group]], number: int, members: list[int], value: float) -> None:
        group = self._group(members, value)
        if group is None:
            return
        heapq.heappush(found, (group.weight, number, group))
        if len(found) > self._config.groups_per_seed:
            heapq.heappop(found)

    def _group(self, members: list[int], value: float) -> Group | None:
        """The group if it is an object: enough components, and enough of the constraints that can be checked hold."""
        config, index = self._config, np.ix_(members, members)
        checked = self.table.checked[index]
        good = checked & (self.table.violation[index] <= 0)
        if len(members) > 1 and not good.any(axis=1).all():
            return None  # a member that nothing ties to the others
        pairs, satisfied = int(checked.sum()) // 2, int(good.sum()) // 2
        if len(members) < min(config.min_components, self._count) or satisfied < config.min_satisfied * pairs:
            return None
        least = config.min_group_match if satisfied else config.min_alone_match
        if np.mean(self.candidates.share[members]) < least:
            return None
        share = satisfied / pairs if pairs else 1.0
        # A missing component may be hidden; it halves the trust at most.
        found = 0.5 + 0.5 * len(members) / self._count
        score = float(np.mean(self.candidates.score[members])) * share * found
        matches = tuple(int(m) for m in self.candidates.match[members])
        # rounded: which of two equal groups goes first does not hang on the order of sums
        weight = round(max(value, _LEAST_WEIGHT * float(self.candidates.weight[members].sum())), 6)
        return Group(self.candidates, tuple(members), matches, weight, score, satisfied, pairs)


def _pair_costs(candidates: Candidates, table: PairTable) -> Array:
    """(n, n) what two members' violated constraint costs, pixels; infinite where they cannot be together."""
    lighter = np.minimum(candidates.weight[:, None], candidates.weight[None])
    share = np.interp(table.violation, (0.0, _FAR_OUT), _DISAGREEMENT) * (table.violation > 0)
    return np.where(table.forbidden, np.inf, share * lighter)
