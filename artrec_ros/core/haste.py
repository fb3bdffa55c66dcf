"""What of a frame's long looks is put off while newer images wait, and in which order what waits has its turn."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TypeVar

from .image.blobs import Blob
from .memory.recall import Recall
from .memory.turns import Turns
from .pose.finder import WholeObjectFinder
from .rests import Rests

Task = tuple[WholeObjectFinder, Blob]
_Shown = TypeVar("_Shown")


class Haste:
    """Of one frame's search. Blobs, and the places of known objects, are searched in full in turn, the one that has
    waited longest first.

    :param turns: by finder, once they are known. :param is_wanted: whether a blob has something left to explain.
    """

    def __init__(
        self,
        recall: Recall,
        turns: Mapping[WholeObjectFinder, Turns],
        rests: Rests,
        is_wanted: Callable[[Task], bool],
    ) -> None:
        self._recall, self._turns, self._rests, self._is_wanted = recall, turns, rests, is_wanted
        self._put_off: dict[tuple[int, int], Task] = {}  # of a finder and a blob

    @property
    def is_late(self) -> bool:
        """Whether a newer image waits."""
        return self._recall.patience.is_late

    @property
    def is_over(self) -> bool:
        """Whether there is no time for another long look."""
        return self._recall.patience.is_over

    def longest_s(self, queue: Sequence[Task]) -> float:
        """For how long the blob whose turn it is has waited; 0 where nobody is late: then all have theirs."""
        return max(map(self._age_s, self._due(queue)), default=0.0) if self.is_late else 0.0

    def leave_all_but_one(self, queue: Sequence[Task]) -> None:
        """Who is late looks again at one blob at a time, while there is patience."""
        if self.is_late:
            due = sorted(self._due(queue), key=self._age_s, reverse=True)
            for finder, blob in due if self.is_over else due[1:]:
                self._turns[finder].leave(blob)

    def puts_off(self, task: Task, *, again: bool) -> bool:
        """Whether a long look at a blob is put off. :param again: it was not looked at closely before: it is its turn
        in the next frame."""
        if not self.is_over:
            return False
        finder, blob = task[0], self._rests.whole(task[1])
        if again:
            self._turns[finder].put_off(blob)
        self._put_off[id(finder), id(blob)] = finder, blob
        return True

    def has_put_off(self, task: Task) -> bool:
        """Whether a long look at a blob was."""
        return (id(task[0]), id(self._rests.whole(task[1]))) in self._put_off

    def spent_on(self, look: Callable[[], _Shown]) -> _Shown:
        """What a long look shows."""
        return self._recall.patience.spent_on(look, self._recall.config.doubt_share)

    def waiting(self, others: Sequence[Task]) -> list[Task]:
        """What was put off, and others that wait, each once."""
        return [*{**{(id(f), id(b)): (f, b) for f, b in others}, **self._put_off}.values()]

    def _due(self, queue: Sequence[Task]) -> list[Task]:
        """Blobs that were searched before, that nothing explains, and whose turn it is."""
        turns = self._turns
        return [(f, b) for f, b in queue if not (turns[f].is_new(b) or turns[f].waits(b)) and self._is_wanted((f, b))]

    def _age_s(self, task: Task) -> float:
        return self._turns[task[0]].age_s(task[1])
