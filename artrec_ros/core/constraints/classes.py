"""Classes of configurations: postures or gestures of one object, each with constraints of its own (paper, outlook)."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from ..base.config import LearningConfig
from ..base.errors import ConfigError
from .intervals import Interval, interval_from_list
from .pairs import PairConstraint, pair_from_dict, pair_to_dict

# below which no image resolves a range of a joint: radians, or shares of a sliding joint's
LEAST_RANGE = LearningConfig().least_width


@dataclass(frozen=True)
class JointRange:
    """The positions of one joint in a class, radians (metres where it slides).

    :param allowed: what is checked; seen: the examples' own span.
    """

    examples: int
    allowed: Interval
    seen: Interval


@dataclass(frozen=True)
class ConfigurationClass:
    """One class. Its region is a box in all its dimensions at once, which holds the stated share of new examples.

    :param pairs: as the image plane shows it; :param joints: component -> its joint's range, for objects in space.
    :param examples: how many taught it.
    """

    name: str
    examples: int
    pairs: tuple[PairConstraint, ...] = ()
    joints: Mapping[str, JointRange] = field(default_factory=dict)

    def to_dict(self) -> dict[str, Any]:
        """Plain values for a file."""
        rows: dict[str, Any] = {"name": self.name, "examples": self.examples}
        if self.joints:
            rows["joints"] = {
                name: {"examples": j.examples, "allowed": _ends(j.allowed), "seen": _ends(j.seen)}
                for name, j in self.joints.items()
            }
        rows["pairs"] = [pair_to_dict(p) for p in self.pairs]
        return rows

    @classmethod
    def from_dict(cls, row: Any, where: str) -> ConfigurationClass:
        """Inverse of `to_dict`. Raises `ConfigError` naming `where` and key."""
        try:
            name, examples, pairs = str(row["name"]), int(row["examples"]), list(row["pairs"])
            joints = dict(row.get("joints", {}))
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise ConfigError(f"{where}: needs name, examples and pairs: {error!r}") from error
        where = f"{where} ({name})"
        return cls(
            name,
            examples,
            tuple(pair_from_dict(p, f"{where}: pairs[{n}]") for n, p in enumerate(pairs)),
            {joint: _joint_from_dict(j, f"{where}: joints: {joint}") for joint, j in joints.items()},
        )


def _ends(interval: Interval) -> list[float]:
    ends = [round(interval.low, 6), round(interval.high, 6)]
    return [*ends, round(interval.period, 6)] if interval.period else ends


def _joint_from_dict(row: Any, where: str) -> JointRange:
    try:
        spans = [interval_from_list(row[key], f"{where}: {key}") for key in ("allowed", "seen")]
        return JointRange(int(row["examples"]), *spans)
    except (KeyError, TypeError, ValueError) as error:
        raise ConfigError(f"{where}: needs examples, allowed and seen: {error!r}") from error
