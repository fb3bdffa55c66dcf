"""Search of one image for whole objects of all targets: known ones, then blob by blob; a sure one takes its pixels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

from .base.config import SearchConfig
from .base.crew import Ahead, Crew
from .finds import Finds
from .haste import Haste, Task
from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .known_search import KnownSearch
from .memory.recall import Recall
from .memory.turns import Turns
from .pose.finder import WholeObjectFinder
from .pose.poses import Poses
from .rests import Rests
from .spatial_looks import SpatialLooks
from .verdict.judge import Judge

_MOST_IN_ONE = 12  # objects in one blob
_Look = Callable[[ImageFrame, WholeObjectFinder, Blob], Poses | None]


class SpatialSearch:
    """Which blobs are looked at, in which order, and how."""

    def __init__(
        self,
        frame: ImageFrame,
        judge: Judge,
        config: SearchConfig,
        recall: Recall | None = None,
        crew: Crew | None = None,
    ) -> None:
        """:param recall: what earlier frames say of this one. :param crew: who looks at blobs; results are the same."""
        self._judge, self._config = judge, config
        self._recall, self._crew, self._looks = recall or Recall(), crew or Crew(1), SpatialLooks(judge, config)
        self._finds = Finds(frame, judge, config)
        self._turns: dict[WholeObjectFinder, Turns] = {}
        self._roots: list[Task] = []  # that the required component may have made
        self._near: dict[tuple[int, int], list[Blob]] = {}  # of a finder and a limb's blob
        self._seen: dict[tuple[int, int], ImageFrame] = {}  # in which a finder looked at a blob last
        self._rests = Rests()
        self._haste = Haste(self._recall, self._turns, self._rests, self._is_wanted)
        self._in_doubt: list[tuple[Task, Poses]] = []  # by few guesses

    def run(self, finders: Sequence[WholeObjectFinder], blobs: Sequence[Blob]) -> list[tuple[WholeObjectFinder, Poses]]:
        """Candidates of each target: known objects, then others in plain view, then what takes more to find; the
        largest blobs first."""
        queue = [(f, b) for f in finders for b in blobs if b.label in f.seed_labels]
        queue.sort(key=lambda fb: -fb[1].area_px)
        for finder in finders:
            self._turns[finder] = self._recall.turns(finder.target.name, [b for f, b in queue if f is finder])
        all_blobs = queue
        self._roots = [(f, b) for f, b in queue if b.label in f.root_labels]
        known = KnownSearch(self._finds, self._looks, self._recall, self._turns, self._haste, self._crew, self._config)
        known.run(queue)
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
        for task, poses in self._in_doubt:
            if self._finds.frame.deadline.expired or self._haste.has_put_off(task):
                self._finds.keep(task[0], poses)
        for finder, blob in all_blobs:
            if self._turns[finder].is_searched(blob) and self._finds.explains(blob):
                self._turns[finder].explain(blob)
        self._recall.waiting = sum(not self._is_explained(task) for task in self._haste.waiting(waiting))
        return self._finds.candidates

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

        :param least: see `Finds.take`: what has less is kept for the case that there is no time to look again.
        :param whole: blobs of which what sure objects leave is looked at, too, and first.
        """
        left: list[Task] = []
        frame, todo, number = self._finds.frame, [*self._left_of(whole, queue), *queue], 0
        ahead = self._ahead(crew, look, todo)
        while True:
            while number < len(todo) and not self._is_due(look, todo[number]):
                number += 1
            if frame is not self._finds.frame:  # what was begun was of other pixels
                frame, todo, number = self._finds.frame, [*self._left_of(whole, todo[number:]), *todo[number:]], 0
                ahead.close()
                ahead = self._ahead(crew, look, todo)
                continue
            if number == len(todo):
                break
            finder, blob = todo[number]
            take = partial(ahead.take, number)
            found = take() if look == self._looks.plain else self._haste.spent_on(take)
            self._seen[id(finder), id(blob)] = frame
            if not frame.deadline.expired:  # else it was cut short, and is looked at again
                self._turns[finder].search(self._rests.whole(blob))
            if found is not None and not self._finds.take(finder, found, least):
                left.append((finder, blob))
                if least is not None:
                    self._in_doubt.append(((finder, blob), found))
            number += 1
        ahead.close()
        return left

    def _ahead(self, crew: Crew, look: _Look, todo: Sequence[Task]) -> Ahead[Task, Poses | None]:
        """Looks at blobs in the frame as it is now. What others begin, and nobody takes, ends when they look at their
        clock: it would be in the way of the next looks."""
        frame = self._finds.frame.hurried(1.0)
        return Ahead(crew, partial(_at, look, frame), todo, self._is_wanted, frame.deadline.give_up)

    def _is_due(self, look: _Look, task: Task) -> bool:
        """Whether a blob is to be looked at, and a long look at it is not put off."""
        if not self._is_wanted(task):
            return False
        closely = look in (self._looks.thorough, self._looks.close)
        return look == self._looks.plain or not self._haste.puts_off(task, again=closely)

    def _left_of(self, whole: Sequence[Task], queue: Sequence[Task]) -> list[Task]:
        """What objects leave of blobs, but of those that are yet to be looked at: one that is mostly explained, or was
        looked at before, may be another object's, too."""
        next_ones = {(id(task[0]), id(task[1])) for task in queue if not self._is_explained(task)}
        return [
            (finder, rest)
            for finder, blob in whole
            if (id(finder), id(blob)) not in next_ones
            for rest in self._rests.of(self._finds.left_to(finder).field, finder, blob)
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
        return blob.label not in finder.root_labels or self._seen.get((id(finder), id(blob))) is not self._finds.frame

    def _is_wanted(self, task: Task) -> bool:
        """Whether there is something of a blob left to explain, and time for it."""
        late = self._finds.frame.deadline.expired
        return not (late or self._is_explained(task)) and self._may_show_required(*task)

    def _is_explained(self, task: Task) -> bool:
        finder, blob = task
        return self._finds.explains(blob, finder)

    def _may_show_required(self, finder: WholeObjectFinder, blob: Blob) -> bool:
        """Whether the required component may be in view of an object of which a component made a blob."""
        if self._judge.unseen or blob.label in finder.root_labels:
            return True
        key = id(finder), id(blob)
        if key not in self._near:
            self._near[key] = [root for f, root in self._roots if f is finder and finder.may_belong(blob, root)]
        return not all(self._is_explained((finder, root)) for root in self._near[key])


def _at(look: _Look, frame: ImageFrame, task: Task) -> Poses | None:
    return look(frame, *task)
