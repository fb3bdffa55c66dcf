"""Instances given by hand, without any image, and the groups they make."""

import numpy as np
from scene import Placed, flag, rectangle
from settings import settings

from artrec_ros.core.alignment.matching import Matches
from artrec_ros.core.alignment.placements import Evidence, Placements
from artrec_ros.core.alignment.shapes import SAMPLES, Shape
from artrec_ros.core.base.deadline import Deadline
from artrec_ros.core.constraints.constraint_set import ConstraintSet
from artrec_ros.core.constraints.intervals import Interval
from artrec_ros.core.constraints.pairs import PairConstraint
from artrec_ros.core.grouping.candidates import Roles, candidates_of
from artrec_ros.core.grouping.group_search import GroupSearch
from artrec_ros.core.grouping.solution import solve
from artrec_ros.core.model.objects import Component, ObjectModel
from artrec_ros.core.model.target import Target

FLAG, BAR = flag(), rectangle("bar", 0.8, 0.16)
SHAPES = [Shape.from_marker(FLAG), Shape.from_marker(BAR)]
MODEL = ObjectModel(
    "toy", (Component("base", (FLAG,), required=True), Component("fore", (BAR,)), Component("aft", (BAR,)))
)
SHAPE_OF = {("base", "flag"): 0, ("fore", "bar"): 1, ("aft", "bar"): 1}
KEYS = [("base", "flag"), ("fore", "bar"), ("aft", "bar")]


def pair(first, second, low, high):
    distance = {"distance_m": Interval(low, high)}
    return PairConstraint(KEYS[first], KEYS[second], 20, distance, distance)


def found(*instances):
    """Instances (shape, Placed, share) as matching would have found them."""
    t = np.array([p.x + 1j * p.y for _, p, _ in instances])
    angle = [p.theta - (FLAG, BAR)[s].axis_angle for s, p, _ in instances]
    z = np.array([p.scale * np.exp(1j * a) for (_, p, _), a in zip(instances, angle, strict=True)])
    none = np.zeros(len(t), np.int32)
    share = np.array([s for _, _, s in instances])
    placed = Placements.similarities(t, z, np.array([s for s, _, _ in instances], np.int32), none, none)
    matched = np.full((len(t), SAMPLES), -1, np.int32)
    return Matches(SHAPES, placed.replace(score=share), np.ones(len(t), int), Evidence(share, share, share, matched))


def at(x, y=0.0):
    """Upright markers of 100 px a metre; centres in metres, right of (500, 500) px."""
    return Placed(500 + 100 * x, 500 + 100 * y, 0.0, 100.0)


def solved(matches, *pairs, **options):
    config = settings(**options)
    target = Target("toy", MODEL, 1, ConstraintSet("toy", 0.95, pairs))
    search = GroupSearch(candidates_of(Roles.of(target, SHAPE_OF), matches, config), matches, config, Deadline())
    return solve([search], matches, config, Deadline()), search, config


def names(group):
    return {group.candidates.key(n)[0]: int(group.candidates.match[n]) for n in group.members}


BASE_FORE, BASE_AFT = pair(0, 1, 0.9, 1.1), pair(0, 2, 1.9, 2.1)
