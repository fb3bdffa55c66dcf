"""One frame's view of what is remembered, and what it leaves to the next."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from ..base.config import RecallConfig
from ..base.patience import Patience
from ..base.stamps import seconds_since
from ..geometry.camera import Camera
from ..geometry.transforms import Array
from ..image.blobs import Blob
from ..pose.finder import WholeObjectFinder
from ..pose.poses import Poses
from ..pose.surface_kernels import LEAST_DEPTH_M
from ..verdict.other_objects import Rival
from ..verdict.verdicts import Verdict
from .likes import Likes
from .looks import NO_LOOKS, Looks
from .memory import Instead, Known, Memory, numbers_of
from .turns import Turns

_DEFAULTS = RecallConfig()


class Recall:
    """What to expect in a frame, and which blobs wait; without a memory nothing.

    :ivar waiting: blobs that wait their turn, each counted once for each object that may be there.
    :ivar likes: what objects may be instead.
    """

    def __init__(
        self,
        memory: Memory | None = None,
        stamp_ns: int = 0,
        refresh_s: float = 1.0,
        config: RecallConfig = _DEFAULTS,
        patience: Patience | None = None,
    ) -> None:
        """:param patience: of whoever waits for what is found."""
        self.patience = patience or Patience()
        self._memory, self._stamp_ns, self._refresh_s, self.config = memory, stamp_ns, refresh_s, config
        self._passed_s = seconds_since(memory.stamp_ns if memory else None, stamp_ns)
        self.clock_s = memory.clock_s + self._passed_s if memory else 0.0
        self._turns: dict[str, Turns] = {}
        self._known: dict[str, tuple[Known, ...]] = {}
        self._challenged: list[Known] = []
        self.waiting = 0
        self.likes = Likes(memory.known if memory else {}, self.clock_s, self._passed_s, refresh_s, config)

    def known(self, name: str) -> tuple[Known, ...]:
        """The objects of a name that may be there, the most votes first."""
        return self._memory.known.get(name, ()) if self._memory else ()

    def expected(self, finder: WholeObjectFinder) -> Poses:
        """(2 K,) where its objects may be, see `Known.at`."""
        known = self.known(finder.target.name)
        return Poses.concatenate([k.at(self.clock_s) for k in known]) if known else finder.surface.no_poses

    def due(self, known: Sequence[Known], behind: Sequence[Known], doubt_s: float = 0.0) -> list[Known]:
        """Those in whose place others are looked for in this frame: all for which the next one would be too late, else
        the one for which it is the longest time ago, if that is half the time. Where a newer image waits those that are
        too late for longer than any blob, while there is patience.

        :param doubt_s: since the blob whose turn it is was searched that has waited for the longest time.
        :param behind: those of them that are followed in what others leave: what is taken for what is easily mistaken
            there, and their time is that of blobs that are searched in vain.
        """
        wait_s = {id(k): min(self.config.retry_s, self._refresh_s) for k in behind}
        age_s = {id(k): self.clock_s - k.challenged_s for k in known}
        late = [k for k in known if k.unsure or age_s[id(k)] + self._passed_s > wait_s.get(id(k), self._refresh_s)]
        old = [k for k in known if age_s[id(k)] > self._refresh_s / 2]
        if self.patience.is_late:
            return [k for k in late if age_s[id(k)] >= doubt_s and not self.patience.is_over]
        return late or sorted(old, key=lambda k: -age_s[id(k)])[:1]

    def challenge(self, known: Known) -> None:
        """Others were looked for in the place of an object."""
        self._challenged.append(known)

    def rests(self, finder: WholeObjectFinder, poses: Poses) -> bool:
        """Whether an object is known, and it is not its turn to be looked for in this frame."""
        known = self._nearest(finder, poses, self.known(finder.target.name))
        return known is not None and known not in self._challenged

    def keeps(self, finder: WholeObjectFinder, poses: Poses, votes: float) -> bool:
        """Whether the known object that is expected next to where one is was sure, and had about as many votes."""
        known = self._nearest(finder, poses, self.known(finder.target.name))
        if known is None or known.unsure:
            return False
        return self.config.kept * max(votes, known.votes) <= min(votes, known.votes)

    def was_there(self, known: Known) -> bool:
        """Whether it was seen in the frame before, and not only earlier."""
        return self._memory is not None and known.seen_s == self._memory.clock_s

    def turns(self, name: str, blobs: Sequence[Blob]) -> Turns:
        """When the blobs in which an object of a name may be are searched."""
        looks = self._memory.looks.get(name, NO_LOOKS) if self._memory else NO_LOOKS
        turns = Turns(blobs, looks, self.clock_s, self._passed_s, self._refresh_s, self.config)
        self._turns[name] = turns
        return turns

    def waits(self, name: str, blobs: Sequence[Blob]) -> NDArray[np.bool_]:
        """(n,) which blobs wait their turn to be searched for objects of a name."""
        turns = self._turns.get(name)
        return np.array([turns is not None and turns.waits(blob) for blob in blobs], bool)

    def accept(
        self,
        finder: WholeObjectFinder,
        verdicts: Sequence[Verdict],
        camera: Camera,
        rivals: Mapping[Verdict, Sequence[Rival]],
        unsure: Sequence[bool],
    ) -> None:
        """What is told of a target in this frame: one that was turned as is likelier is not to be followed as it was
        found. What is not seen is forgotten where something new is in its place.

        :param rivals: of all objects of the frame what each may be instead. :param unsure: of each verdict whether
            another one of the target may be there instead.
        """
        before, told, new = list(self.known(finder.target.name)), [], []
        for verdict, doubted in sorted(zip(verdicts, unsure, strict=True), key=lambda both: -both[0].claim.votes):
            seen = verdict.claim.poses, self.clock_s, verdict.claim.votes
            old = self._nearest(finder, verdict.claim.poses, before)
            if old is None:
                known = Known.first(*seen)
                new.append(verdict.claim.poses)
            else:
                before.remove(old)
                challenged_s = self.clock_s if old in self._challenged else old.challenged_s
                known = old.then(*seen, challenged_s, finder.surface.kinematics.endless, self.config.steadiness)
            told.append(replace(known, instead=self._instead(verdict, rivals), unsure=doubted))
        lost = [
            k
            for k in sorted(before, key=lambda k: -k.seen_s)
            if self.clock_s - k.seen_s <= self.config.gone_s
            and not any(finder.required.is_over(camera, k.at(self.clock_s), poses).any() for poses in new)
        ]
        self._known[finder.target.name] = (*told, *lost[: self.config.most_gone])

    def _instead(self, verdict: Verdict, rivals: Mapping[Verdict, Sequence[Rival]]) -> Mapping[str, Instead]:
        """:param verdict: it may be turned otherwise than it was found."""
        mine = [v for v in rivals if v.finder is verdict.finder]
        found = min(mine, key=lambda v: float(np.linalg.norm(v.poses.t[0] - verdict.poses.t[0])), default=verdict)
        return self.likes.left(found, rivals.get(found, ()))

    def doubt(self, finder: WholeObjectFinder, verdicts: Iterable[Verdict], camera: Camera) -> None:
        """What of a target is not told in this frame, not being probable enough: if it moves it may be in the next."""
        turns = self._turns.get(finder.target.name)
        if turns is not None:
            for verdict in verdicts:
                turns.doubt(*finder.required.discs(camera, verdict.claim.poses))

    def _nearest(self, finder: WholeObjectFinder, poses: Poses, known: Sequence[Known]) -> Known | None:
        """The object that is expected next to where one is; None: none is so near."""
        if not known:
            return None
        off_m = [np.linalg.norm(self._places(finder, poses, k) - poses.t[0], axis=1).min() for k in known]
        nearest = int(np.argmin(off_m))
        return known[nearest] if off_m[nearest] < finder.surface.extent else None

    def _places(self, finder: WholeObjectFinder, poses: Poses, known: Known) -> Array:
        """(2, 3) where an object is expected; of what faces the camera, whose depth stands for its scale, as far off as
        another one is."""
        places = known.places(self.clock_s)
        # led on fast towards the camera it may be expected behind it, where nothing lies
        return places * (poses.t[0, 2] / np.maximum(places[:, 2:], LEAST_DEPTH_M)) if finder.facing else places

    def left(self, size: tuple[int, int], camera: Camera | None) -> Memory:
        """For the next frame. :param size: (width, height) of this one's image. :param camera: that took it."""
        looks: Mapping[str, Looks] = {name: turns.left() for name, turns in self._turns.items()}
        return Memory(self._stamp_ns, self.clock_s, size, numbers_of(camera), self._known, looks)
