"""What is known of all objects that are followed, as arrays with a row for each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ..base.config import ExistenceConfig
from ..geometry.transforms import Array
from ..model.found import Detection, IdentityFit
from .existence import Existence
from .motion import Bodies, MotionModel, MotionState


@dataclass(frozen=True)
class Tracks:
    """T objects that are followed.

    :param names: the object's name of each. :param ids: None: it has not been told of. :param identities: what has been
        seen of which one of several like objects each is. :param last: as each was seen last.
    :param image: x, y and log scale in the image. :param theta: (T,) last direction in it.
    :param posed: (T,) whether it was seen in space; `bodies` says nothing of others.
    :param age_s: (T,) since it was seen. :param strange: (T,) frames in a row that showed it elsewhere in space.
    :param times: (T,) how often it was seen where it was expected in space.
    """

    names: tuple[str, ...]
    ids: tuple[int | None, ...]
    identities: tuple[IdentityFit | None, ...]
    last: tuple[Detection, ...]
    image: MotionState
    theta: Array
    bodies: Bodies
    posed: NDArray[np.bool_]
    existence: Existence
    age_s: Array
    strange: NDArray[np.intp]
    times: NDArray[np.intp]

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, rows: Sequence[int]) -> Tracks:
        if len(rows) == len(self) and list(rows) == list(range(len(self))):
            return self
        index = np.array(rows, int)
        told = (tuple(all_of[r] for r in rows) for all_of in (self.names, self.ids, self.identities, self.last))
        known = (self.image[index], self.theta[index], self.bodies[index], self.posed[index], self.existence[index])
        return Tracks(*told, *known, self.age_s[index], self.strange[index], self.times[index])

    def joined(self, other: Tracks) -> Tracks:
        if not len(self) or not len(other):
            return self if len(self) else other
        told = (
            a + b
            for a, b in (
                (self.names, other.names), (self.ids, other.ids), (self.identities, other.identities),
                (self.last, other.last),
            )
        )  # fmt: skip
        return Tracks(
            *told,
            MotionState.joined([self.image, other.image]),
            np.append(self.theta, other.theta),
            Bodies.joined([self.bodies, other.bodies]),
            np.append(self.posed, other.posed),
            self.existence.joined(other.existence),
            *(np.append(a, b) for a, b in ((self.age_s, other.age_s), (self.strange, other.strange))),
            np.append(self.times, other.times),
        )

    @classmethod
    def none(cls) -> Tracks:
        nothing, turns = np.zeros(0), np.zeros((0, 3, 3))
        flat, solid = (MotionState(np.zeros((0, 2, n)), np.zeros((0, 2, 2, n, n)), np.zeros((0, n))) for n in (3, 6))
        counts, existence = np.zeros(0, int), Existence.of(nothing)
        return cls((), (), (), (), flat, nothing, Bodies(solid, turns), np.zeros(0, bool), existence, nothing, counts, counts)

    @property
    def are_told(self) -> NDArray[np.bool_]:
        """(T,) whether each has been told of."""
        return np.array([number is not None for number in self.ids], bool)

    def after(self, dt_s: float, model: MotionModel, config: ExistenceConfig) -> Tracks:
        """A time later."""
        if not len(self):
            return self
        return replace(
            self,
            existence=self.existence.after(dt_s, config),
            image=self.image.after(dt_s, model),
            bodies=self.bodies.after(dt_s, model) if self.posed.any() else self.bodies,
            age_s=self.age_s + dt_s,
        )
