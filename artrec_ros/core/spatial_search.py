"""Search of one image for whole objects of all targets, blob by blob; a sure object takes its pixels."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache, partial

from .base.config import SearchConfig
from .base.crew import Ahead, Crew
from .image.blobs import Blob
from .image.image_frame import ImageFrame
from .memory.recall import Recall
from .memory.turns import Turns
from .pose.finder import WholeObjectFinder
from .pose.surface_model import Poses
from .spatial_looks import Followed, SpatialLooks
from .verdict.claims import silhouette
from .verdict.judge import Judge

_Task = tuple[WholeObjectFinder, Blob]
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
        # found, and whether sure; its pixels are still in the frames
        self._to_hide: tuple[WholeObjectFinder, Poses, bool] | None = None

    def run(self, finders: Sequence[WholeObjectFinder], blobs: Sequence[Blob]) -> list[tuple[WholeObjectFinder, Poses]]:
        """Candidates of each target: known objects, then others in plain view, then what takes more to find; the
        largest blobs first."""
        queue = [(f, b) for f in finders for b in blobs if b.label in f.root_labels]
        queue.sort(key=lambda fb: -fb[1].area_px)
        for finder in finders:
            self._turns[finder] = self._recall.turns(finder.target.name, [b for f, b in queue if f is finder])
        all_blobs = queue
        queue, waiting = self._without_waiting(self._look_again(queue))
        queue = self._look(self._looks.plain, queue, Crew(1))  # most are of objects, which change what is next
        self._look(self._looks.close, queue, self._crew)
        for finder, blob in all_blobs:
            if self._turns[finder].is_searched(blob) and self._over(finder, blob):
                self._turns[finder].explain(blob)
        self._recall.waiting = sum(not self._over(finder, blob) for finder, blob in waiting)
        return [(finder, Poses.concatenate(poses)) for finder, poses in self._found.items()]

    def _without_waiting(self, queue: list[_Task]) -> tuple[list[_Task], list[_Task]]:
        """Blobs that are looked at in this frame where nothing explains them, and those that are left alone."""
        waits = [self._turns[finder].waits(blob) for finder, blob in queue]
        split = [[task for task, wait in zip(queue, waits, strict=True) if wait == which] for which in (False, True)]
        return split[0], split[1]

    def _look(self, look: _Look, queue: list[_Task], crew: Crew) -> list[_Task]:
        """Look at all blobs, one after the other; those in which no sure object was found, but one may be."""
        left: list[_Task] = []
        ahead: Ahead[_Task, Poses | None] | None = None
        frame = self._frame
        for number, (finder, blob) in enumerate(queue):
            if self._over(finder, blob):
                continue
            if ahead is None or frame is not self._frame:  # what was begun was of other pixels
                frame = self._frame
                ahead = Ahead(crew, partial(_at, look, frame), queue, lambda task: not self._over(*task))
            self._turns[finder].search(blob)
            found = ahead.take(number)
            if found is not None and not self._take(finder, found):
                left.append((finder, blob))
        return left

    def _look_again(self, queue: list[_Task]) -> list[_Task]:
        """Look for known objects, which take their pixels, and at the blobs that they explain whose turn it is as if
        nothing were known: what is found may prove to be better. What is left."""
        known, frame = self._follow(), self._frame
        if known is None:
            return queue
        for k in known:
            self._hide_found()
            self._take(k.finder, k.found.poses)
        turns = self._turns
        due = [turns[f].is_due(b) and self._over(f, b) for f, b in queue]
        again = [task for task, yes in zip(queue, due, strict=True) if yes or turns[task[0]].is_doubted(task[1])]
        for finder, blob in (task for task, yes in zip(queue, due, strict=True) if yes):
            turns[finder].search(blob)
        found = self._crew.each(partial(self._look_at_old, frame), again)
        for (finder, _), poses in zip(again, found, strict=True):
            if poses is not None and len(poses):
                self._hide_found()
                self._take(finder, poses)
        return [task for task, yes in zip(queue, due, strict=True) if not yes]

    def _look_at_old(self, frame: ImageFrame, task: _Task) -> Poses | None:
        finder, blob = task
        look = self._looks.full if self._turns[finder].is_due(blob) else self._looks.plain
        return look(frame, finder, blob)

    def _follow(self) -> list[Followed] | None:
        """Known objects that are still there, the most votes first; blobs of others are looked at anew.

        None: most are gone, so this is another scene, of which what is remembered says nothing.
        """
        frame, now_s, config = self._frame, self._recall.clock_s, self._recall.config
        known = [(finder, k) for finder in self._turns for k in self._recall.known(finder.target.name)]
        followed = [self._looks.follow(frame, finder, k, now_s, config) for finder, k in known]
        asked = [f for f in followed if self._recall.was_there(f.known)]
        if self._is_another_scene(asked):
            for turns in self._turns.values():
                turns.forget()
            return None
        for f in followed:
            if not f.well:
                turns = self._turns[f.finder]
                middles, radii_px = f.finder.discs(frame.camera, f.expected)
                if f.trust > self._config.sure:
                    turns.doubt(middles, radii_px)
                else:  # it may be found from its limbs, too
                    turns.hurry(middles, config.limbs * radii_px)
        return sorted((f for f in followed if f.trust > 0), key=lambda f: -f.found.votes[0])

    def _is_another_scene(self, followed: Sequence[Followed]) -> bool:
        """Whether most of what was there, by its votes, is not there as it was; of a single object: is not there."""
        if len(followed) == 1:
            return followed[0].trust <= self._config.sure
        return 2 * sum(f.known.votes for f in followed if f.well) < sum(f.known.votes for f in followed)

    def _over(self, finder: WholeObjectFinder, blob: Blob) -> bool:
        """Whether nothing of a blob is left to explain, or no time for it."""
        if self._frame.deadline.expired:
            return True
        self._hide_found()
        return self._unexplained.get(finder, self._frame).field.owned_share(blob.contour) > self._config.explained

    def _take(self, finder: WholeObjectFinder, poses: Poses) -> bool:
        """Keep hypotheses, the best one first; whether that is a sure object, which takes its pixels.

        A likely one may share them with a rival, but its own target's is not sought for them again.
        """
        self._found.setdefault(finder, []).append(poses)
        trust = self._judge.trust_in(finder, poses, self._frame)
        sure = trust > self._config.sure
        if sure or trust > self._config.likely:
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


def _at(look: _Look, frame: ImageFrame, task: _Task) -> Poses | None:
    return look(frame, *task)
