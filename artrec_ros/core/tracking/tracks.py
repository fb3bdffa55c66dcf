"""What is known of all objects that are followed, as arrays with a row for each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any

import numpy as np

from ..base.config import TrackingConfig
from ..geometry.transforms import Array
from ..model.found import Detection, IdentityFit
from .existence import Existence
from .motion import Bodies, Counts, Flags, MotionModel, MotionState
from .turns import Turns


@dataclass(frozen=True)
class Tracks:
    """T objects that are followed.

    :param names: the object's name of each. :param ids: None: it has not been told of. :param identities: what has been
        seen of which one of several like objects each is. :param last: as each was seen last.
    :param image: x, y and log scale in the image. :param theta: (T,) last direction in it.
    :param posed: (T,) whether it was seen in space or on a plane, in the frame of `last`; `bodies` says nothing of
        others.
    :param age_s: (T,) since it was seen. :param strange: (T,) frames in a row that showed it elsewhere in space.
    :param times: (T,) how often it was seen where it was expected in space. :param turns: what frames say of turns.
    :param lived_s: (T,) since it was seen first.
    """

    names: tuple[str, ...]
    ids: tuple[int | None, ...]
    identities: tuple[IdentityFit | None, ...]
    last: tuple[Detection, ...]
    image: MotionState
    theta: Array
    bodies: Bodies
    posed: Flags
    existence: Existence
    age_s: Array
    strange: Counts
    times: Counts
    turns: Turns
    lived_s: Array

    @property
    def in_camera(self) -> Flags:
        """(T,) whether `bodies` says where it is before the camera: not on a plane, which has a frame of its own."""
        fitted = np.array([d.pose_from == "fit" for d in self.last], bool)
        return np.asarray(self.posed & fitted)

    @cached_property
    def expected(self) -> Array:
        """(T, 3) x, y and log scale where each is in the image by now: of what is not seen and has a pose before the
        camera, from where it was seen last as that pose moves, which is known better than how what is seen of it does.
        """
        place = self.image.place.copy()
        known = np.flatnonzero(self.in_camera & (self.age_s > 0) & (self.bodies.motion.place[:, 2] > 0)).tolist()
        last = {row: d.pose.position for row in known if (d := self.last[row]).pose is not None}
        if not last:
            return place
        rows, before = list(last), np.array(list(last.values()))
        now = self.bodies.motion.place[rows, :3]
        seen = np.array([(d.image.x, d.image.y, d.image.scale) for d in (self.last[row] for row in rows)])
        focal_px = seen[:, 2:] * before[:, 2:]
        place[rows, :2] = seen[:, :2] + focal_px * (now[:, :2] / now[:, 2:] - before[:, :2] / before[:, 2:])
        place[rows, 2:] = np.log(focal_px / now[:, 2:])
        return place

    def __len__(self) -> int:
        return len(self.names)

    def __getitem__(self, rows: Sequence[int]) -> Tracks:
        index = np.array(rows, int)
        if len(rows) == len(self) and (index == np.arange(len(self))).all():
            return self

        def picked(column: Any) -> Any:
            return tuple(column[row] for row in rows) if isinstance(column, tuple) else column[index]

        return Tracks(*(picked(getattr(self, f.name)) for f in fields(self)))

    def joined(self, other: Tracks) -> Tracks:
        """These, and then the others."""
        if not len(self) or not len(other):
            return self if len(self) else other

        def both(a: Any, b: Any) -> Any:
            if isinstance(a, tuple):
                return a + b
            return np.concatenate([a, b]) if isinstance(a, np.ndarray) else type(a).joined([a, b])

        return Tracks(*(both(getattr(self, f.name), getattr(other, f.name)) for f in fields(self)))

    @classmethod
    def none(cls) -> Tracks:
        """No tracks at all."""
        nothing, turns = np.zeros(0), np.zeros((0, 3, 3))
        flat, solid = (MotionState(np.zeros((0, 2, n)), np.zeros((0, 2, 2, n, n)), np.zeros((0, n))) for n in (3, 6))
        counts, existence = np.zeros(0, int), Existence.of(nothing)
        bodies, posed = Bodies(solid, turns), np.zeros(0, bool)
        return cls(
            (), (), (), (), flat, nothing, bodies, posed, existence, nothing, counts, counts, Turns(nothing, nothing),
            nothing,
        )  # fmt: skip

    @property
    def are_told(self) -> Flags:
        """(T,) whether each has been told of."""
        return np.array([number is not None for number in self.ids], bool)

    def after(self, dt_s: float, model: MotionModel, config: TrackingConfig) -> Tracks:
        """A time later."""
        if not len(self):
            return self
        return replace(
            self,
            existence=self.existence.after(dt_s, config.existence),
            image=self.image.after(dt_s, model),
            bodies=self.bodies.after(dt_s, model) if self.posed.any() else self.bodies,
            age_s=self.age_s + dt_s,
            lived_s=self.lived_s + dt_s,
            turns=self.turns.after(dt_s, config.sightings),
        )
