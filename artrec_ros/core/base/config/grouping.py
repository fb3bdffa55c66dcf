"""Room `grouping`: parts put together to objects."""

from __future__ import annotations

from dataclasses import dataclass

from ..errors import ConfigError
from .params import Room, param

_PLANE = ("plane",)


@dataclass(frozen=True)
class GroupingConfig(Room):
    """What makes a group of instances an object, and how far the search for groups goes."""

    max_scale_ratio: float = param(
        1.35,
        "greatest ratio between the scales of an object's components",
        low=1,
        high=10,
        paths=_PLANE,
        origin="components in unlike depths, and the uncertain scale of small ones",
    )
    missing_cost: float = param(
        0.15,
        "what a missing component costs, as a share of the contour it would explain",
        low=0,
        high=1,
        paths=_PLANE,
        origin="enough that one whole object goes before two halves",
    )
    min_group_match: float = param(
        0.7,
        "least mean share matched of an object's components: a half-hidden one needs others that are clear",
        low=0,
        high=1,
        paths=_PLANE,
        origin="chosen on rendered quadrupeds for few false objects",
    )
    min_alone_match: float = param(
        0.8,
        "the same for an object that no constraint between components supports",
        low=0,
        high=1,
        paths=_PLANE,
        origin="above min_group_match: nothing else speaks for it",
    )
    min_satisfied: float = param(
        0.8,
        "least share of the constraints that could be checked and hold",
        low=0,
        high=1,
        paths=_PLANE,
        origin="of the ten pairs of five components two may fail",
    )
    max_overlap: float = param(
        0.3,
        "two objects may share this much of an instance's area",
        low=0,
        high=1,
        paths=_PLANE,
        origin="neighbours that touch overlap by their contours' tolerance",
    )
    max_group_overlap: float = param(
        0.7,
        "two instances of one object may share this much",
        low=0,
        high=1,
        paths=_PLANE,
        origin="components may pass before each other; a link that folds back wants 0.95 (pendulum)",
    )
    min_explained: float = param(
        0.25,
        "least share of its blobs' contours that accepted objects must explain",
        low=0,
        high=1,
        paths=_PLANE,
        origin="a quarter is left of a marker that merged with three others",
    )
    violation_cost: tuple[float, ...] = param(
        (0.25, 1.0),
        "what a pair that is just violated costs, and one that is far out, in shares of the lighter member's contour",
        low=0,
        high=10,
        paths=_PLANE,
        origin="a slight violation costs less than to leave the member out, a gross one as much",
    )
    far_out: float = param(
        0.5,
        "a violation that is far out: radians, or share of the pair's greatest length",
        low=0.01,
        high=10,
        paths=_PLANE,
        origin="30 degrees: no noise makes that",
    )
    least_weight: float = param(
        0.05,
        "weight of an object whose missing components cost more than it explains, as a share of what it explains",
        low=0.0001,
        high=1,
        paths=_PLANE,
        origin="above 0, so that it is found where nothing else explains its pixels",
    )
    max_partners: int = param(
        500,
        "at most so many candidates that go with the required component are related with each other, the heaviest",
        low=1,
        high=10000,
        paths=_PLANE,
        origin="bounds the time: pairs grow with its square",
    )
    max_options: int = param(
        12,
        "at most so many candidates of a component are tried with an instance of the required one, the heaviest",
        low=1,
        high=100,
        paths=_PLANE,
        origin="bounds the time: groups grow with it",
    )
    groups_per_seed: int = param(
        4,
        "groups carried on per instance of the required component",
        low=1,
        high=100,
        paths=_PLANE,
        origin="rivals of neighbours; more changed nothing",
    )
    search_nodes: int = param(
        20000,
        "nodes of an exact search before it falls back to the best so far",
        low=1,
        paths=_PLANE,
        origin="bounds the time; frames of 20 objects need some hundreds",
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(self.violation_cost) != 2 or self.violation_cost[1] < self.violation_cost[0]:
            raise ConfigError(
                f"expert.grouping.violation_cost: {list(self.violation_cost)} must be of one just violated, and a "
                "greater one of one far out"
            )
