"""Search of one image for whole objects of all targets, blob by blob; a sure object takes its pixels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cache, partial

from .base.config import SearchConfig
from .base.crew import Ahead, Crew
from .haste import Haste, Task
from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .memory.memory import Known
from .memory.recall import Recall
from .memory.turns import Turns
from .pose.finder import WholeObjectFinder
from .pose.surface_model import Poses
from .rests import Rests
from .spatial_looks import Followed, SpatialLooks
from .verdict.claims import silhouette
from .verdict.judge import Judge

_MOST_IN_ONE = 12  # objects in one blob
_Look = Callable[[ImageFrame, WholeObjectFinder, Blob], Poses | None]


class SpatialSearch:
    """What is found so far, and the frame without the pixels of sure objects."""

    def __init__(
        self,
        frame: ImageFrame,
        judge: Judge,
        config: SearchConfig,
        recall: Recall | None = None,
        crew: Crew | None = None,
    ) -> None:
        """:param recall: what earlier frames say of this one. :param crew: who looks at blobs; results are the same."""
        self._frame, self._judge, self._config = frame, judge, config
        self._recall, self._crew, self._looks = recall or Recall(), crew or Crew(1), SpatialLooks(judge, config)
        self._turns: dict[WholeObjectFinder, Turns] = {}
        self._found: dict[WholeObjectFinder, list[Poses]] = {}
        self._unexplained: dict[WholeObjectFinder, ImageFrame] = {}  # without the pixels of its likely objects, too
        self._roots: list[Task] = []  # that the required component may have made
        self._near: dict[tuple[int, int], list[Blob]] = {}  # of a finder and a limb's blob
        self._seen: dict[tuple[int, int], ImageFrame] = {}  # in which a finder looked at a blob last
        self._rests = Rests()
        self._haste = Haste(self._recall, self._turns, self._rests, self._is_wanted)
        self._in_doubt: list[tuple[Task, Poses]] = []  # by few guesses
        # found, and whether sure; its pixels are still in the frames
        self._to_hide: tuple[WholeObjectFinder, Poses, bool] | None = None

    def run(self, finders: Sequence[WholeObjectFinder], blobs: Sequence[Blob]) -> list[tuple[WholeObjectFinder, Poses]]:
        """Candidates of each target: known objects, then others in plain view, then what takes more to find; the
        largest blobs first."""
        queue = [(f, b) for f in finders for b in blobs if b.label in f.seed_labels]
        queue.sort(key=lambda fb: -fb[1].area_px)
        for finder in finders:
            self._turns[finder] = self._recall.turns(finder.target.name, [b for f, b in queue if f is finder])
        all_blobs = queue
        self._roots = [(f, b) for f, b in queue if b.label in f.root_labels]
        self._look_for_known(queue)
        queue, waiting = self._without_waiting(queue)
        limbs = [(f, b) for f, b in queue if b.label not in f.root_labels]
        queue = [(f, b) for f, b in queue if b.label in f.root_labels]
        # most are of objects, which change what is next
        whole, queue = queue, self._look(self._looks.plain, queue, Crew(1), self._config.beyond_doubt)
        # what others begin for who is late may not be taken any more
        crew = Crew(1) if self._haste.is_late else self._crew
        self._look(self._looks.thorough, queue, crew, whole=whole)
        limbs = self._look(self._looks.close, limbs, crew)
        self._look_for_pieces(queue + limbs if self._judge.unseen else queue, crew)
        self._hide_found()
        for task, poses in self._in_doubt:
            if self._frame.deadline.expired or self._haste.has_put_off(task):
                self._found.setdefault(task[0], []).append(poses)
        for finder, blob in all_blobs:
            if self._turns[finder].is_searched(blob) and self._explains(self._frame, blob):
                self._turns[finder].explain(blob)
        self._recall.waiting = sum(not self._is_explained(*task) for task in self._haste.waiting(waiting))
        return [(finder, Poses.concatenate(poses)) for finder, poses in self._found.items()]

    def _without_waiting(self, queue: list[Task]) -> tuple[list[Task], list[Task]]:
        """Blobs that are looked at in this frame where nothing explains them, and those that are left alone. Where a
        newer image waits, of those that are not new one at a time, the one that has waited for the longest time."""
        self._haste.leave_all_but_one(queue)
        waits = [self._turns[finder].waits(blob) for finder, blob in queue]
        split = [[task for task, wait in zip(queue, waits, strict=True) if wait == which] for which in (False, True)]
        return split[0], split[1]

    def _look(
        self, look: _Look, queue: list[Task], crew: Crew, least: float | None = None, whole: Sequence[Task] = ()
    ) -> list[Task]:
        """Look at all blobs, one after the other; those in which no sure object was found, but one may be.

        :param least: see `_take`: what has less is kept for the case that there is no time to look again.
        :param whole: blobs of which what sure objects leave is looked at, too, and first.
        """
        left: list[Task] = []
        frame, todo, number = self._frame, [*self._left_of(whole, queue), *queue], 0
        ahead = Ahead(crew, partial(_at, look, frame), todo, self._is_wanted)
        while True:
            while number < len(todo) and not self._is_due(look, todo[number]):
                number += 1
            self._hide_found()
            if frame is not self._frame:  # what was begun was of other pixels
                frame, todo, number = self._frame, [*self._left_of(whole, todo[number:]), *todo[number:]], 0
                ahead.close()
                ahead = Ahead(crew, partial(_at, look, frame), todo, self._is_wanted)
                continue
            if number == len(todo):
                break
            finder, blob = todo[number]
            take = partial(ahead.take, number)
            found = take() if look == self._looks.plain else self._haste.spent_on(take)
            self._seen[id(finder), id(blob)] = frame
            if not frame.deadline.expired:  # else it was cut short, and is looked at again
                self._turns[finder].search(self._rests.whole(blob))
            if found is not None and not self._take(finder, found, least):
                left.append((finder, blob))
                if least is not None:
                    self._in_doubt.append(((finder, blob), found))
            number += 1
        ahead.close()
        return left

    def _is_due(self, look: _Look, task: Task) -> bool:
        """Whether a blob is to be looked at, and a long look at it is not put off."""
        if not self._is_wanted(task):
            return False
        closely = look in (self._looks.thorough, self._looks.close)
        return look == self._looks.plain or not self._haste.puts_off(task, again=closely)

    def _left_of(self, whole: Sequence[Task], queue: Sequence[Task]) -> list[Task]:
        """What objects leave of blobs, but of those that are yet to be looked at: one that is mostly explained, or was
        looked at before, may be another object's, too."""
        self._hide_found()
        next_ones = {(id(finder), id(blob)) for finder, blob in queue if not self._is_explained(finder, blob)}
        return [
            (finder, rest)
            for finder, blob in whole
            if (id(finder), id(blob)) not in next_ones
            for rest in self._rests.of(self._unexplained.get(finder, self._frame).field, finder, blob)
        ]

    def _look_for_pieces(self, queue: list[Task], crew: Crew) -> None:
        """Blobs that nothing explains may be of several objects: these are looked for in one range of sizes after the
        other, for one large alignment over several has more votes than a right one; and again where one was found."""
        several = [task for task in queue if self._may_show_more(*task)]
        for piece in range(1, self._config.pieces + 1):
            left = several
            for _ in range(_MOST_IN_ONE):
                in_vain = self._look(partial(self._looks.close, piece=piece), left, crew)
                vain = {(id(finder), id(blob)) for finder, blob in in_vain}
                left = [(f, b) for f, b in left if (id(f), id(b)) not in vain and self._is_wanted((f, b))]
                if not left or self._haste.is_over:
                    break

    def _may_show_more(self, finder: WholeObjectFinder, blob: Blob) -> bool:
        """Whether pieces of a blob are worth a look: one of the required component's had it, unless others have taken
        pixels since."""
        if not (self._is_wanted((finder, blob)) and finder.may_be_several(blob)):
            return False
        return blob.label not in finder.root_labels or self._seen.get((id(finder), id(blob))) is not self._frame

    def _look_for_known(self, queue: Sequence[Task]) -> None:
        """Known objects take their pixels. Where it is their turn, or they show less than they did, others are looked
        for in what the rest of them leave, as if they were not known: what is found may prove to be better.

        :param queue: all blobs. Where a newer image waits they and known objects are searched in full in turn.
        """
        frame, followed = self._frame, self._follow()
        behind, doubt_s = [f.known for f in followed if f.behind], self._haste.longest_s(queue)
        due = self._recall.due([f.known for f in followed], behind, doubt_s)
        again = [f for f in followed if f.known in due or not f.well]
        blobs = [
            self._turns[f.finder].largest(
                f.finder.root_labels, *f.finder.required.discs(frame.camera, f.found.poses[:1])
            )
            for f in again
        ]
        tasks = [(f, blob, f.known in due) for f, blob in zip(again, blobs, strict=True) if blob is not None]
        if self._haste.is_late:
            oldest = min((f for f, _, in_full in tasks if in_full), key=lambda f: f.known.challenged_s, default=None)
            tasks = [(f, blob, f is oldest) for f, blob, _ in tasks if f is oldest or not f.well]
        taken = [f for f in followed if f.trust > self._config.sure]
        solids = {id(f): silhouette(f.finder.surface, frame.camera, f.found.poses[:1]) for f in taken if tasks}

        def look(task: tuple[Followed, Blob, bool]) -> Poses | None:
            f, blob, in_full = task
            rest = frame.without([s for other in taken if other is not f for s in solids[id(other)]])
            return (self._looks.full if in_full else self._looks.plain)(rest, f.finder, blob)

        looks = partial(self._crew.each, look, tasks)
        shown = self._haste.spent_on(looks) if any(in_full for _, _, in_full in tasks) else looks()
        for (f, _, in_full), poses in zip(tasks, shown, strict=True):
            if in_full and not frame.deadline.expired:
                self._recall.challenge(f.known)
            if poses is not None and len(poses):
                self._hide_found()
                self._take(f.finder, poses)

    def _follow(self) -> list[Followed]:
        """Known objects that are still there, and are taken; the blobs of others do not wait.

        Where most are gone this is another scene, of which what is remembered says nothing.
        """
        known = [(finder, k) for finder in self._turns for k in self._recall.known(finder.target.name)]
        known.sort(key=lambda fk: (not self._recall.was_there(fk[1]), -fk[1].votes))
        followed = [f for f in self._crew.each(lambda one: self._followed_in_time(*one), known) if f is not None]
        if self._frame.deadline.expired:  # then fits are none
            return self._taken(followed)
        if self._is_another_scene([f for f in followed if self._recall.was_there(f.known)]):
            for turns in self._turns.values():
                turns.forget()
            return []
        all_of_it, there = self._frame, self._taken([f for f in followed if f.well])
        for f in followed:
            if not f.well:
                there += self._taken([self._followed_behind(f, all_of_it)])
        return there

    def _followed_behind(self, f: Followed, all_of_it: ImageFrame) -> Followed:
        """A known object that does not show in the frame what it did, in what others leave: its votes were of no more
        before."""
        self._hide_found()
        if self._frame is not all_of_it:
            f = replace(self._followed(f.finder, f.known), behind=True)
        if not f.well and f.trust <= self._config.sure:  # it may be found from its limbs, too
            middles, radii_px = f.finder.required.discs(self._frame.camera, f.expected)
            self._turns[f.finder].hurry(middles, self._recall.config.limbs * radii_px, f.known.seen_s)
        return f

    def _followed_in_time(self, finder: WholeObjectFinder, known: Known) -> Followed | None:
        return None if self._frame.deadline.expired else self._followed(finder, known)

    def _followed(self, finder: WholeObjectFinder, known: Known) -> Followed:
        return self._looks.follow(self._frame, finder, known, self._recall.clock_s, self._recall.config)

    def _taken(self, followed: list[Followed]) -> list[Followed]:
        """Those that are there, the most votes first: they take their pixels."""
        there = sorted((f for f in followed if f.trust > 0), key=lambda f: -f.found.votes[0])
        for f in there:
            self._hide_found()
            self._take(f.finder, f.found.poses)
        return there

    def _is_another_scene(self, followed: Sequence[Followed]) -> bool:
        """Whether most of what was there, by its votes, is not there."""
        gone = [f for f in followed if not f.well and f.trust <= self._config.sure]
        return 2 * sum(f.known.votes for f in gone) > sum(f.known.votes for f in followed)

    def _is_wanted(self, task: Task) -> bool:
        """Whether there is something of a blob left to explain, and time for it."""
        return not (self._frame.deadline.expired or self._is_explained(*task)) and self._may_show_required(*task)

    def _may_show_required(self, finder: WholeObjectFinder, blob: Blob) -> bool:
        """Whether the required component may be in view of an object of which a component made a blob."""
        if self._judge.unseen or blob.label in finder.root_labels:
            return True
        key = id(finder), id(blob)
        if key not in self._near:
            self._near[key] = [root for f, root in self._roots if f is finder and finder.may_belong(blob, root)]
        return not all(self._is_explained(finder, root) for root in self._near[key])

    def _is_explained(self, finder: WholeObjectFinder, blob: Blob) -> bool:
        self._hide_found()
        return self._explains(self._unexplained.get(finder, self._frame), blob)

    def _explains(self, frame: ImageFrame, blob: Blob) -> bool:
        """Whether somebody owns a blob's pixels in a frame."""
        return frame.field.owned_share(blob.contour) > self._config.explained

    def _take(self, finder: WholeObjectFinder, poses: Poses, least: float | None = None) -> bool:
        """Keep hypotheses, the best one first; whether that is a sure object, which takes its pixels.

        A likely one may share them with a rival, but its own target's is not sought for them again. One whose required
        component has no place of its own takes none: whose it lies across is yet to be found.

        :param least: trust that makes it sure; the blobs of what has less are looked at again.
        """
        trust, placed = self._judge.trust_and_place(finder, poses, self._frame)
        sure = placed and trust > (self._config.sure if least is None else least)
        if least is not None and not sure:
            return False
        self._found.setdefault(finder, []).append(poses)
        if placed and (sure or trust > self._config.likely):
            self._to_hide = finder, poses[:1], sure
        return sure

    def _hide_found(self) -> None:
        """Take the pixels of what was found last: put off until there is another blob to look at."""
        if self._to_hide is None:
            return
        (finder, pose, sure), self._to_hide = self._to_hide, None
        rest = cache(partial(ImageFrame.without, solids=silhouette(finder.surface, self._frame.camera, pose)))
        self._unexplained.setdefault(finder, self._frame)
        for other in self._unexplained if sure else (finder,):
            self._unexplained[other] = rest(self._unexplained[other])  # several finders may still share one
        if sure:
            self._frame = rest(self._frame)


def _at(look: _Look, frame: ImageFrame, task: Task) -> Poses | None:
    return look(frame, *task)
