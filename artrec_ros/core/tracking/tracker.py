"""Names that stay: which detection of this frame is which object of the frames before.

Of every object it is known where it was and how it moved, in space and in the image. A detection continues an
object where its place and turn are likelier for it than for a newcomer, who may be anywhere in view; all pairs of
a frame are settled together.

Ids are small: a newcomer has the lowest one that nobody else has, or had within `max_gap_s`. An object of whose name
never two were seen at once is number 0, however it moves: there is nobody whom it could be taken for.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count

import numpy as np
from scipy.optimize import linear_sum_assignment

from ..base.config import TrackingConfig
from ..geometry.transforms import Array
from ..model.found import Detection, FrameResult, IdentityFit
from ..verdict.identity import named
from .motion import MotionModel
from .sightings import Sighting, Trace, surprise

_NO_CLOCK_S = 1 / 30  # what a frame counts as where stamps stand still


@dataclass(frozen=True)
class Look:
    """One detection as the tracker sees it."""

    object: str
    image: Sighting
    space: Sighting | None
    identity: IdentityFit | None = None

    def may_be(self, track: Track) -> bool:
        """Whether nothing that is told of their names keeps them apart."""
        mine, its = self.identity, track.identity
        if self.object != track.object or mine is None or its is None:
            return self.object == track.object
        return not (mine.unique and mine.name and its.name) or mine.name == its.name

    def meets_in_space(self, track: Track) -> bool:
        """Whether both have a pose."""
        return self.space is not None and track.space is not None

    def surprise(self, tracks: Sequence[Track], in_space: bool, config: TrackingConfig) -> Array:
        """(T,) how little it looks like each track, in space or in the image; below 0: more so than like a newcomer."""
        if in_space and self.space is not None:
            return surprise(self.space, [t.space for t in tracks if t.space is not None], config)
        return surprise(self.image, [t.image for t in tracks], config)


@dataclass(frozen=True)
class Track:
    """An object with a name, seen in so many frames, and not in the last so many."""

    object: str
    id: int
    image: Trace
    space: Trace | None
    identity: IdentityFit | None = None
    seen: int = 1
    missed: int = 0

    def older(self, dt_s: float, model: MotionModel) -> Track:
        space = self.space and self.space.older(dt_s, model)
        return replace(self, image=self.image.older(dt_s, model), space=space, missed=self.missed + 1)

    def is_remembered(self, config: TrackingConfig) -> bool:
        """What was seen once or twice was perhaps nothing: it is soon forgotten."""
        soon = config.sightings.missed_per_seen * self.seen + 1
        return self.image.age_s <= config.max_gap_s and self.missed <= soon

    def continued(self, look: Look, model: MotionModel, memory: float) -> Track:
        """:param memory: what earlier sightings' evidence of its name counts, of one frame's."""
        space, identity = self.space, look.identity
        if identity is not None and self.identity is not None:
            before = self.identity.evidence
            evidence = {k: v + memory * before.get(k, 0.0) for k, v in identity.evidence.items()}
            identity = replace(identity, evidence=evidence)
        if look.space is not None:
            space = Trace.begun(look.space, model) if space is None else space.continued(look.space)
        image = self.image.continued(look.image)
        return replace(self, image=image, space=space, identity=identity, seen=self.seen + 1, missed=0)


class Tracker:
    """Gives detections the ids of the objects that they continue. For the frames of one camera, in their order."""

    def __init__(self, config: TrackingConfig) -> None:
        self._tracks: list[Track] = []
        self._unseen_s: dict[tuple[str, int], float] = {}  # who had which id: since when not seen; not for ever
        self._in_company: set[str] = set()  # names of which two were seen at once
        self._stamp_ns: int | None = None
        self._size = (0, 0)
        self._frame_id = ""
        self.configure(config)

    def configure(self, config: TrackingConfig) -> None:
        """Go on with other parameters."""
        self._config = config
        self._motion = MotionModel(config.speed, config.steady_s)
        if not config.enabled:
            self.forget()

    def forget(self) -> None:
        """Forget all objects: whoever comes next is somebody else. Who was seen just now keeps the id for a while."""
        self._tracks, self._stamp_ns = [], None

    def update(self, stamp_ns: int, result: FrameResult, frame_id: str = "") -> FrameResult:
        """The same result with lasting ids.

        All objects are forgotten where the clock goes back, as when a bag starts again, or where the images' size
        or frame is another one.

        :param frame_id: the camera's optical frame; empty: not known.
        """
        if not self._config.enabled:
            return result
        self._advance(stamp_ns, result.size, frame_id)
        of = self._config.sightings
        looks = [
            Look(d.object, Sighting.in_image(d, result.size, of), Sighting.in_space(d, of), d.identity)
            for d in result.detections
        ]
        self._in_company |= {name for name, n in Counter(look.object for look in looks).items() if n > 1}
        matched = self._match(looks)
        continued = {
            n: self._tracks[i].continued(looks[n], self._motion, self._config.sightings.identity_memory)
            for n, i in matched.items()
        }
        self._unseen_s |= {(t.object, t.id): 0.0 for t in continued.values()}
        seen = [continued[n] if n in continued else self._begun(look) for n, look in enumerate(looks)]
        ids = {(t.object, t.id) for t in seen}  # who was alone and has been lost has given the id away
        self._tracks = [*seen, *(t for t in self._tracks if (t.object, t.id) not in ids)]
        detections: list[Detection] = [
            replace(d, id=track.id) for d, track in zip(result.detections, seen, strict=True)
        ]
        return replace(result, detections=tuple(self._named(detections)))

    def _named(self, detections: Sequence[Detection]) -> list[Detection]:
        """The same, told which one each is by what has been seen of it so far; all of an object's together."""
        out = list(detections)
        mine: dict[str, list[int]] = {}
        for n, d in enumerate(detections):
            if d.identity is not None and d.identity.evidence:
                mine.setdefault(d.object, []).append(n)
        for numbers in mine.values():
            fits = [self._tracks[n].identity for n in numbers]  # those of detections come first
            first = next(fit for fit in fits if fit is not None)
            names = list(first.evidence)
            evidence = np.array([[fit.evidence[k] for k in names] for fit in fits if fit is not None])
            for n, fit in zip(numbers, named(evidence, names, first.unique, first.least), strict=True):
                out[n] = replace(detections[n], identity=fit)
                self._tracks[n] = replace(self._tracks[n], identity=fit)
        return out

    def _advance(self, stamp_ns: int, size: tuple[int, int], frame_id: str) -> None:
        """Let time pass up to a frame."""
        other_view = size != self._size or (frame_id and self._frame_id and frame_id != self._frame_id)
        if other_view or (self._stamp_ns is not None and stamp_ns < self._stamp_ns):
            self.forget()
        passed_s = 0.0 if self._stamp_ns is None else (stamp_ns - self._stamp_ns) * 1e-9
        dt_s = passed_s or _NO_CLOCK_S
        self._unseen_s = {k: s + dt_s for k, s in self._unseen_s.items() if s + dt_s <= self._config.max_gap_s}
        older = (t.older(dt_s, self._motion) for t in self._tracks)
        self._tracks = [t for t in older if t.is_remembered(self._config)]
        self._stamp_ns, self._size, self._frame_id = stamp_ns, size, frame_id or self._frame_id

    def _begun(self, look: Look) -> Track:
        alone = look.object not in self._in_company
        number = 0 if alone else next(i for i in count() if (look.object, i) not in self._unseen_s)
        self._unseen_s[look.object, number] = 0.0
        space = None if look.space is None else Trace.begun(look.space, self._motion)
        return Track(look.object, number, Trace.begun(look.image, self._motion), space, look.identity)

    def _match(self, looks: Sequence[Look]) -> dict[int, int]:
        """Index of a look -> index of the track it continues. Poses go first: they tell more than images."""
        matched: dict[int, int] = {}
        for in_space in (True, False):
            taken = set(matched.values())
            free = [i for i in range(len(self._tracks)) if i not in taken]
            cost = np.full((len(looks), len(self._tracks)), np.inf)
            for n, look in enumerate(looks):
                fitting = [i for i in free if look.may_be(self._tracks[i])]
                fitting = [i for i in fitting if look.meets_in_space(self._tracks[i]) == in_space]
                if fitting and n not in matched:
                    cost[n, fitting] = look.surprise([self._tracks[i] for i in fitting], in_space, self._config)
            matched.update(_assign(cost))
        return matched


def _assign(cost: Array) -> dict[int, int]:
    """Row -> column, each once, so that the pairs' sum is least; pairs that are not below 0 stay apart."""
    rows, columns = linear_sum_assignment(np.minimum(cost, 0.0))
    return {int(r): int(c) for r, c in zip(rows, columns, strict=True) if cost[r, c] < 0}
