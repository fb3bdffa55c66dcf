"""Training of classes of configurations: one region each, in all pairs of markers and all joints at once."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from ..constraints.classes import LEAST_RANGE, ConfigurationClass, JointRange
from ..constraints.intervals import Interval
from ..constraints.pairs import PairConstraint, at_one_scale, configuration
from ..geometry.transforms import Array
from ..model.objects import ObjectModel
from .conformal import conformal_margin, left_out_scores, unwrapped, widened
from .pair_learning import Example, learn, least_widths, widened_pair


def learn_class(
    name: str,
    model: ObjectModel,
    examples: Sequence[Example],
    joints: Sequence[Mapping[str, float]] = (),
    coverage: float = 0.95,
) -> ConfigurationClass:
    """A class from its examples.

    :param examples: as for `learning.learn`.
    :param joints: per example whose joints are known, component -> its joint's position.
    :param coverage: share of new examples that the region of the pairs, and that of the joints, shall hold.
    """
    areas = {key: m.area for key, m in model.markers.items()}
    pairs = _pairs(model, [at_one_scale(e, areas) for e in examples if e], coverage)
    return ConfigurationClass(name, len(examples), pairs, _joints(model, joints, coverage))


def _pairs(model: ObjectModel, examples: Sequence[Example], coverage: float) -> tuple[PairConstraint, ...]:
    bare = learn(model, examples, coverage=0.0).pairs
    if not bare:
        return ()
    values = np.hstack([_pair_offsets(p, examples) for p in bare])
    least = np.concatenate([least_widths(p) for p in bare])
    shown = ~np.isnan(values).all(axis=1)  # an example of a single marker says nothing
    margin = conformal_margin(left_out_scores(values[shown], least), coverage, values.shape[1])
    return tuple(widened_pair(p, margin) for p in bare)


def _pair_offsets(pair: PairConstraint, examples: Sequence[Example]) -> Array:
    """(n, d) the pair's configuration in each example, from the middle of its box; nan where it is not seen."""
    rows = np.full((len(examples), len(pair.allowed)), np.nan)
    for n, e in enumerate(examples):
        if pair.first in e and pair.second in e:
            T = configuration(e[pair.first], e[pair.second])
            rows[n] = [unwrapped(T[d], pair.seen[d]) for d in pair.allowed]
    return rows


def _joints(model: ObjectModel, rows: Sequence[Mapping[str, float]], coverage: float) -> dict[str, JointRange]:
    bare: dict[str, JointRange] = {}
    least: dict[str, float] = {}
    for name, joint in model.joints.items():
        values = np.array([row[name] for row in rows if name in row], float)
        if len(values) < 2:
            continue
        span = Interval.around_angles(values) if joint.is_endless else Interval.around(values)
        bare[name] = JointRange(len(values), span, span)
        least[name] = LEAST_RANGE * (1.0 if joint.kind == "revolute" else joint.upper - joint.lower)
    if not bare:
        return {}
    offsets = np.array([[unwrapped(np.array(row.get(n, np.nan)), j.seen) for n, j in bare.items()] for row in rows])
    scores = left_out_scores(offsets, np.array(list(least.values())))
    margin = conformal_margin(scores, coverage, len(bare))
    return {n: replace(j, allowed=widened(j.seen, margin, least[n])) for n, j in bare.items()}
