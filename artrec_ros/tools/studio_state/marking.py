"""What a person does in a frame: draws axes one after the other, mends, accepts or rejects what is proposed."""

from __future__ import annotations

import numpy as np

from ...core.base.errors import ConfigError
from ...core.geometry.transforms import Array
from ...core.model.frame_result import FrameResult
from ...core.model.target import Target
from ...io.learned.annotations import AnnotatedObject
from .examples import Examples, Key, axes_of, identities, keys_of
from .session import Session

_GRAB_SHARE = 0.012  # of the image's width: a drag that begins so near to an end moves it
_LEAST_GRAB_PX = 2.5


class Marking:
    """The marks of one frame after the other. Proposals are nowhere but here until they are accepted.

    :ivar object: the name of the object that is drawn next. :ivar number: the frame.
    :ivar chosen: the example or proposal that keys act on. :ivar drawn: the example whose axes are being drawn.

    Ends of axes can be dragged of an object that was clicked: what begins where another one ends is drawn beside it.
    """

    def __init__(self, session: Session, examples: Examples) -> None:
        self.session, self.examples = session, examples
        self.object, self.number = session.names[0], 0
        self.chosen: AnnotatedObject | None = None
        self.drawn: AnnotatedObject | None = None
        self._clicked: AnnotatedObject | None = None
        self._skipped: set[Key] = set()
        self._proposed: dict[int, list[AnnotatedObject]] = {}

    @property
    def target(self) -> Target:
        """The object that is drawn next."""
        return next(t for t in self.session.setup.targets if t.name == self.object)

    @property
    def proposals(self) -> list[AnnotatedObject]:
        return self._proposed.get(self.number, [])

    @property
    def shown(self) -> list[AnnotatedObject]:
        """All there is in the frame, proposals last."""
        return [*self.examples.of(self.number), *self.proposals]

    def is_proposal(self, annotated: AnnotatedObject | None) -> bool:
        return any(p is annotated for p in self.proposals)

    @property
    def next_key(self) -> Key | None:
        """The marker to draw next; None: the object has all."""
        done = set(self._skipped)
        if self.drawn is not None:
            done |= {key for key, _ in axes_of(self.drawn, self.target.model)}
        return next((k for k in keys_of(self.target.model) if k not in done), None)

    def look_at(self, number: int) -> None:
        """Another frame: what was being drawn is done."""
        self.number, self.chosen = number, None
        self.finish()

    def draw_next(self, name: str) -> None:
        """Another object."""
        self.object = name
        self.finish()

    def finish(self) -> None:
        """The object that is being drawn has all that can be seen of it."""
        self.drawn = None
        self._skipped.clear()

    def skip(self) -> None:
        """The next marker cannot be seen."""
        if self.next_key is not None:
            self._skipped.add(self.next_key)
        if self.next_key is None:
            self.finish()

    def choose(self, place: Array) -> None:
        """The object whose middle is nearest to a click, if it is near; else none."""
        self.chosen, least = None, np.inf
        for o in self.shown:
            points = np.array([*o.points.values()])
            distance = float(np.linalg.norm(points.mean(axis=0) - place))
            reach = self._grab_px() + float(np.linalg.norm(np.ptp(points, axis=0))) / 2
            if distance <= reach and distance < least:
                self.chosen, least = o, distance
        self._clicked = self.chosen

    def drag(self, start: Array, end: Array) -> None:
        """Moves an end of the clicked object's axes that lies at `start`, else draws the next axis."""
        grabbed = self._end_at(start)
        if grabbed is not None:
            owner, name = grabbed
            self._replace(owner, self.examples.moved(owner, name, end))
            return
        key = self.next_key
        assert key is not None  # an object that has all its markers is no longer drawn
        if self.drawn is None:
            self.drawn = self.examples.new(self.number, self.target, key, start, end)
        else:
            self.drawn = self.examples.with_axis(self.drawn, key, start, end)
        self.chosen = self.drawn
        if self.next_key is None:
            self.finish()

    def _grab_px(self) -> float:
        return max(_LEAST_GRAB_PX, _GRAB_SHARE * self.session.stills.image(self.number).shape[1])

    def _end_at(self, place: Array) -> tuple[AnnotatedObject, str] | None:
        chosen = self.chosen
        if chosen is None or chosen is not self._clicked:
            return None
        distances = {name: float(np.linalg.norm(p - place)) for name, p in chosen.points.items()}
        name = min(distances, key=lambda n: distances[n])
        return (chosen, name) if distances[name] <= self._grab_px() else None

    def _replace(self, old: AnnotatedObject, new: AnnotatedObject) -> None:
        self._withdraw(old)
        self.drawn = new if self.drawn is old else self.drawn
        self._clicked = new if self._clicked is old else None
        self.chosen = new

    def propose(self, result: FrameResult) -> int:
        """What the recogniser found and nobody has marked; returns how many."""
        self._proposed[self.number] = self.examples.proposals(self.number, result)
        self.chosen = next(iter(self.proposals), None)
        return len(self.proposals)

    def forget_proposals(self, here: bool = True) -> None:
        """The recogniser has learned: it would propose something else. :param here: in the frame, too, that somebody
        is at work on."""
        self._proposed = {} if here else {self.number: self.proposals}
        self.chosen = self.chosen if any(o is self.chosen for o in self.shown) else None

    def _withdraw(self, proposal: AnnotatedObject) -> None:
        self._proposed[self.number] = [p for p in self.proposals if p is not proposal]

    def accept(self) -> None:
        """The chosen proposal, else the first; the next one is chosen."""
        taken = self.chosen if self.is_proposal(self.chosen) else next(iter(self.proposals), None)
        if taken is not None:
            self._withdraw(taken)
            self.examples.accept(taken)
            self.chosen = next(iter(self.proposals), None)

    def accept_all(self) -> None:
        while self.proposals:
            self.accept()

    def reject(self) -> None:
        """The chosen proposal goes; a chosen example is removed."""
        if self.chosen is None:
            return
        if self.is_proposal(self.chosen):
            self._withdraw(self.chosen)
            self.chosen = next(iter(self.proposals), None)
        else:
            self.examples.remove(self.chosen)
            self.drawn = None if self.drawn is self.chosen else self.drawn
            self.chosen = None

    def identify(self, place: int) -> None:
        """The chosen object is the identity of this place among those of its kind."""
        if self.chosen is not None:
            known = identities(self.examples.target(self.chosen))
            if 0 <= place < len(known):
                self._replace(self.chosen, self.examples.identified(self.chosen, known[place]))

    def nothing_here(self) -> None:
        """:raises ConfigError: something is marked."""
        if self.examples.of(self.number):
            raise ConfigError("objects are marked in this frame; remove them first (x)")
        self.examples.set_empty(self.number)
