"""All that was learned about one object: constraints of its pairs of markers, its classes, its axes' offsets."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..base.errors import ConfigError
from ..model.objects import ObjectModel
from .axis_offsets import AxisOffset
from .classes import ConfigurationClass
from .pairs import Key, PairConstraint, pair_from_dict, pair_to_dict


@dataclass(frozen=True)
class ConstraintSet:
    """What was learned about one object.

    :param coverage: the share of new examples for which each pair's box, and each class's region, was widened.
    :param classes: its classes of configurations; none: it has no classes.
    :param axes: how annotated axes differ from those of fitted outlines, where they do.
    """

    object: str
    coverage: float
    pairs: tuple[PairConstraint, ...]
    classes: tuple[ConfigurationClass, ...] = ()
    axes: tuple[AxisOffset, ...] = ()

    def pair(self, first: Key, second: Key) -> PairConstraint | None:
        """The constraint that relates the two in this order, or None."""
        return next((p for p in self.pairs if p.first == first and p.second == second), None)

    @cached_property
    def surprises(self) -> tuple[tuple[frozenset[Key], float], ...]:
        """Of each pair the two markers, and minus the logarithm of its chance by the background model."""
        return tuple((frozenset((p.first, p.second)), float(-np.log(p.chance(self.reach_m)))) for p in self.pairs)

    @cached_property
    def reach_m(self) -> float:
        """The farthest that two markers of the object may lie apart; 0 where no pair tells."""
        return max((p.reach_m for p in self.pairs), default=0.0)

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a file."""
        rows: dict[str, Any] = {"object": self.object, "coverage": self.coverage}
        if self.axes:
            rows["axes"] = [a.to_dict() for a in self.axes]
        rows["pairs"] = [pair_to_dict(p) for p in self.pairs]
        if self.classes:
            rows["classes"] = [c.to_dict() for c in self.classes]
        return rows

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> ConstraintSet:
        """Inverse of `to_dict`. Raises `ConfigError` naming the pair and key."""
        try:
            name, coverage, rows = str(values["object"]), float(values["coverage"]), list(values["pairs"])
            class_rows, axis_rows = list(values.get("classes", ())), list(values.get("axes", ()))
        except (KeyError, TypeError, ValueError) as error:
            raise ConfigError(f"constraints need object, coverage and pairs: {error!r}") from error
        pairs = tuple(pair_from_dict(row, f"pairs[{n}]") for n, row in enumerate(rows))
        classes = tuple(ConfigurationClass.from_dict(row, f"classes[{n}]") for n, row in enumerate(class_rows))
        axes = tuple(AxisOffset.from_dict(row, f"axes[{n}]") for n, row in enumerate(axis_rows))
        for group in (pairs, *(c.pairs for c in classes)):
            _refuse_repeated(group)
        names = [c.name for c in classes]
        if len(set(names)) < len(names):
            raise ConfigError(f"classes: {', '.join(names)}: each needs a name of its own")
        return cls(name, coverage, pairs, classes, axes)

    def check_model(self, model: ObjectModel) -> None:
        """Raise `ConfigError` where something names a component, marker or joint that the model lacks."""
        for where, key in self._keys():
            if key not in model.markers:
                raise ConfigError(
                    f"{where}: '{'/'.join(key)}' is no component/marker of object '{model.name}'; "
                    f"it has {', '.join('/'.join(k) for k in sorted(model.markers))}"
                )
        joints = model.joint_names
        for c in self.classes:
            for joint in c.joints:
                if joint not in joints:
                    raise ConfigError(
                        f"classes: {c.name}: joints: '{joint}' is no joint of object '{model.name}'; "
                        f"it has {', '.join(joints) or 'none'}"
                    )

    def _keys(self) -> Iterator[tuple[str, Key]]:
        groups = [("pairs", self.pairs), *((f"classes: {c.name}: pairs", c.pairs) for c in self.classes)]
        yield from ((where, key) for where, pairs in groups for p in pairs for key in (p.first, p.second))
        yield from (("axes", axis.key) for axis in self.axes)


def _refuse_repeated(pairs: Iterable[PairConstraint]) -> None:
    seen: set[tuple[Key, Key]] = set()
    for p in pairs:
        if (p.first, p.second) in seen or (p.second, p.first) in seen or p.first[0] == p.second[0]:
            raise ConfigError(f"pairs: {'/'.join(p.first)} - {'/'.join(p.second)}: given twice, or of one component")
        seen.add((p.first, p.second))
