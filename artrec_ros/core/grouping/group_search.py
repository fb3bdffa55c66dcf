"""Groups of instances that form one object (paper, step 8), grown from each instance of the required component."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property
from typing import NamedTuple

import numpy as np

from ..alignment.matching import Matches
from ..base.config import RecognizerConfig
from ..base.deadline import Deadline
from . import group_kernels as compiled
from .candidates import Candidates
from .pair_table import PairTable, pair_table, relevant

_LEAST_WEIGHT = 0.05  # share of what it explains, of an object whose missing components cost more: any above 0 does
_SEEDS_BETWEEN_LOOKS = 16  # at the clock


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
    """The search for one target's groups in one frame. `out_of_nodes` turns True where its node limit cuts it short."""

    def __init__(self, candidates: Candidates, matches: Matches, config: RecognizerConfig, deadline: Deadline) -> None:
        self._config = config
        self._deadline = deadline
        model = candidates.target.model
        self._required = model.components.index(model.required)
        self._perimeter_m = candidates.roles.least_perimeter_m
        self._overlap = matches.overlap
        self.seeds, self.candidates, self.table = relevant(candidates, self._required, self._overlap, config)
        self._instances = len(matches)
        self.out_of_nodes = False

    @cached_property
    def table(self) -> PairTable:
        """All candidates checked in pairs."""
        return pair_table(self.candidates, self._overlap, self._config)

    def forget_table(self) -> None:
        """Let go of the table, by far the largest part, until it is asked for again."""
        self.__dict__.pop("table", None)
        self.__dict__.pop("_pool", None)

    def best_groups_of_all(self) -> list[Group]:
        """The heaviest groups around each seed in turn, at most `groups_per_seed`, by the deadline."""
        most = self._config.grouping.groups_per_seed
        return self._by_deadline([(int(seed), frozenset()) for seed in self.seeds], most)

    def best_without(self, cases: list[tuple[int, frozenset[int]]]) -> list[Group]:
        """The heaviest group of each (seed, banned), where there is one, by the deadline."""
        return self._by_deadline(cases, 1)

    def _by_deadline(self, cases: list[tuple[int, frozenset[int]]], most: int) -> list[Group]:
        groups: list[Group] = []
        for start in range(0, len(cases), _SEEDS_BETWEEN_LOOKS):
            if self._deadline.expired:
                break
            part = cases[start : start + _SEEDS_BETWEEN_LOOKS]
            groups += self._search([seed for seed, _ in part], [banned for _, banned in part], most)
        return groups

    def _search(self, seeds: Sequence[int], banned: Sequence[frozenset[int]], most: int) -> list[Group]:
        out = np.zeros((len(seeds), self._instances), bool)
        for n, instances in enumerate(banned):
            if instances:
                out[n, list(instances)] = True
        *found, exact = compiled.best_groups_of(self._pool, np.array(seeds), self._rules, out, most)
        self.out_of_nodes |= not exact
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
        config, rules = self._config, self._config.grouping
        return compiled.Rules(
            rules.missing_cost * self._perimeter_m,
            self._required,
            rules.max_options,
            rules.groups_per_seed,
            rules.search_nodes,
            config.min_in_plane,
            rules.min_satisfied,
            rules.min_group_match,
            rules.min_alone_match,
            _LEAST_WEIGHT,
        )
