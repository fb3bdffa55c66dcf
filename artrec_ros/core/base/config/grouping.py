"""Room `grouping`: parts put together to objects."""

from __future__ import annotations

from dataclasses import dataclass

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
        origin="so that one whole object goes before two halves; a third either way gains or loses one object in 180, "
        "0.45 loses one in 22",
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
        origin="above min_group_match: nothing else speaks for it; where parts alone may be objects, 0.72 brings "
        "half as many false ones again, 0.88 has half of them and loses one object in 180",
    )
    min_satisfied: float = param(
        0.8,
        "least share of the constraints that could be checked and hold",
        low=0,
        high=1,
        paths=_PLANE,
        origin="of the ten pairs of five components two may fail; 0.53 gets one object in 90 wrong, 1 one in 15",
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
        origin="a quarter is left of a marker that merged with three others; 0.17 brings one false object in 30, "
        "0.75 loses a seventh of all",
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
        origin="rivals of neighbours: with 2 one object in a hundred is lost, with 5 nothing changes",
    )
    search_nodes: int = param(
        20000,
        "nodes of an exact search before it falls back to the best so far",
        low=1,
        paths=_PLANE,
        origin="bounds the time; frames of 20 objects need some hundreds",
    )
