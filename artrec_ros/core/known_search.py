"""Search of one image for what earlier ones showed: it is judged by the same evidence as anything else."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import partial

from .base.config import SearchConfig
from .base.crew import Crew
from .finds import Finds
from .haste import Haste, Task
from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .memory.memory import Known
from .memory.recall import Recall
from .memory.turns import Turns
from .pose.finder import WholeObjectFinder
from .pose.poses import Poses
from .spatial_looks import Followed, SpatialLooks
from .verdict.claims import silhouette

_Look = tuple[Followed, Blob, bool]  # at the blob of a known object, in full or not


class KnownSearch:
    """Of all known objects. :param turns: by finder, of which known objects are looked for."""

    def __init__(
        self,
        finds: Finds,
        looks: SpatialLooks,
        recall: Recall,
        turns: Mapping[WholeObjectFinder, Turns],
        haste: Haste,
        crew: Crew,
        config: SearchConfig,
    ) -> None:
        self._finds, self._looks, self._recall, self._turns = finds, looks, recall, turns
        self._haste, self._crew, self._config = haste, crew, config
        self._all_of_it = finds.frame

    def run(self, queue: Sequence[Task]) -> None:
        """Known objects take their pixels. Where it is their turn, or they show less than they did, others are looked
        for in what the rest of them leave, as if they were not known: what is found may prove to be better.

        :param queue: all blobs. Where a newer image waits they and known objects are searched in full in turn.
        """
        whole, followed = self._all_of_it, self._follow()
        looks = self._looks_at(followed, queue)
        taken = [f for f in followed if f.trust > self._config.sure]
        solids = {f.known: silhouette(f.finder.surface, whole.camera, f.found.poses[:1]) for f in taken if looks}

        def look(at: _Look) -> Poses | None:
            f, blob, in_full = at
            rest = whole.without([s for other in taken if other is not f for s in solids[other.known]])
            return (self._looks.full if in_full else self._looks.plain)(rest, f.finder, blob)

        all_looks = partial(self._crew.each, look, looks)
        shown = self._haste.spent_on(all_looks) if any(in_full for _, _, in_full in looks) else all_looks()
        for (f, _, in_full), poses in zip(looks, shown, strict=True):
            if in_full and not whole.deadline.expired:
                self._recall.challenge(f.known)
            if poses is not None and len(poses):
                self._finds.take(f.finder, poses)

    def _looks_at(self, followed: Sequence[Followed], queue: Sequence[Task]) -> list[_Look]:
        """Of which known objects others are looked for."""
        behind, doubt_s = [f.known for f in followed if f.behind], self._haste.longest_s(queue)
        due = self._recall.due([f.known for f in followed], behind, doubt_s)
        camera, again = self._all_of_it.camera, [f for f in followed if f.known in due or not f.well]
        blobs = [
            self._turns[f.finder].largest(f.finder.root_labels, *f.finder.required.discs(camera, f.found.poses[:1]))
            for f in again
        ]
        looks = [(f, blob, f.known in due) for f, blob in zip(again, blobs, strict=True) if blob is not None]
        if not self._haste.is_late:
            return looks
        oldest = min((f for f, _, in_full in looks if in_full), key=lambda f: f.known.challenged_s, default=None)
        return [(f, blob, f is oldest) for f, blob, _ in looks if f is oldest or not f.well]

    def _follow(self) -> list[Followed]:
        """Known objects that are still there, and are taken; the blobs of others do not wait.

        Where most are gone this is another scene, of which what is remembered says nothing.
        """
        known = [(finder, k) for finder in self._turns for k in self._recall.known(finder.target.name)]
        known.sort(key=lambda fk: (not self._recall.was_there(fk[1]), -fk[1].votes))
        followed = [f for f in self._crew.each(lambda one: self._in_time(*one), known) if f is not None]
        if self._all_of_it.deadline.expired:  # then fits are none
            return self._taken(followed)
        if self._is_another_scene([f for f in followed if self._recall.was_there(f.known)]):
            for turns in self._turns.values():
                turns.forget()
            return []
        there = self._taken([f for f in followed if f.well])
        for f in followed:
            if not f.well:
                there += self._taken([self._behind(f)])
        return there

    def _behind(self, f: Followed) -> Followed:
        """A known object that does not show in the frame what it did, in what others leave: its votes were of no more
        before."""
        if self._finds.frame is not self._all_of_it:
            f = replace(self._at(self._finds.frame, f.finder, f.known), behind=True)
        if not f.well and f.trust <= self._config.sure:  # it may be found from its limbs, too
            middles, radii_px = f.finder.required.discs(self._all_of_it.camera, f.expected)
            self._turns[f.finder].hurry(middles, self._recall.config.limbs * radii_px, f.known.seen_s)
        return f

    def _in_time(self, finder: WholeObjectFinder, known: Known) -> Followed | None:
        return None if self._all_of_it.deadline.expired else self._at(self._all_of_it, finder, known)

    def _at(self, frame: ImageFrame, finder: WholeObjectFinder, known: Known) -> Followed:
        return self._looks.follow(frame, finder, known, self._recall.clock_s, self._recall.config)

    def _taken(self, followed: list[Followed]) -> list[Followed]:
        """Those that are there, the most votes first: they take their pixels."""
        there = sorted((f for f in followed if f.trust > 0), key=lambda f: -f.found.votes[0])
        for f in there:
            self._finds.take(f.finder, f.found.poses)
        return there

    def _is_another_scene(self, followed: Sequence[Followed]) -> bool:
        """Whether most of what was there, by its votes, is not there."""
        gone = [f for f in followed if not f.well and f.trust <= self._config.sure]
        return 2 * sum(f.known.votes for f in gone) > sum(f.known.votes for f in followed)
