"""The loop of a replay: parts go out to workers; frames come back, are noted, put in order, written, drawn."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence

from ...io.results.journal import Journal, Recognised
from ...io.results.results import FrameRecord
from ...io.sources.frames import Source
from .engines import Done, Engine, Job
from .joining import Join, Piece, with_known
from .pictures import Pictures
from .work import Drawn, Seen, work

PART_FRAMES = 16
_LOOK_AHEAD = 256  # pieces that wait: several sources go on side by side, and not all is held in memory


class Running:
    """A replay at work.

    :param order: a packed `work.Order`. :param sources: with their names.
    :param known: frames of an earlier run, by number.
    :param record: called with each frame's source, by number, and its record, in order.
    :param note: called with lines for the user.
    :param chained: what a frame tells is handed on to the next one: a source's parts follow one another.
    """

    def __init__(
        self,
        order: bytes,
        sources: Sequence[tuple[str, Source]],
        engine: Engine,
        journal: Journal,
        known: Mapping[int, Recognised],
        join: Join,
        pictures: Pictures,
        record: Callable[[int, FrameRecord], None],
        note: Callable[[str], None],
        chained: bool,
    ) -> None:
        self._order, self._sources, self._engine = order, sources, engine
        self._journal, self._known, self._join, self._pictures = journal, known, join, pictures
        self._record, self._note = record, note
        self._chained = chained
        self._held: list[Piece] = []  # that wait for what the piece before them hands on
        self._unfinished: deque[Piece] = deque()  # in order, until their pictures are through
        self._drawn: dict[Piece, dict[int, Drawn]] = {}
        self._through: set[Piece] = set()
        self._to_draw: deque[Piece] = deque()
        self._stopped = False

    def stop(self) -> None:
        """End soon, with whole results; may be called by a signal's handler."""
        self._stopped = True
        self._engine.stop()

    def run(self) -> None:
        """:raises OSError: results cannot be written; what is written is whole."""
        pieces = self._pieces()
        while True:
            while self._engine.free and not self._stopped and (job := self._next_job(pieces)) is not None:
                self._engine.submit(job)
            if not self._engine.busy:
                return
            for done in self._engine.wait():
                self._take(done)

    def _pieces(self) -> Iterator[Piece]:
        first = 0
        for number, (_, source) in enumerate(self._sources):
            before = None
            for part in source.parts(PART_FRAMES):
                piece = with_known(Piece(number, first, part, before), self._known)
                yield piece
                first += part.count
                before = piece if self._chained else None

    def _next_job(self, pieces: Iterator[Piece]) -> Job | None:
        """Drawing goes first: what waits for it is held in memory."""
        while True:
            if self._to_draw:
                job = self._drawing(self._to_draw.popleft())
                if job is not None:
                    return job
                continue
            piece = self._next_piece(pieces)
            if piece is None:
                return None
            piece.begin()
            missing = piece.missing
            if missing:
                return self._job(piece, "recognise", missing, piece.memory)
            self._go_on()

    def _next_piece(self, pieces: Iterator[Piece]) -> Piece | None:
        """The first one that need not wait for another; None: there is none at the moment."""
        for piece in self._held:
            if piece.is_ready:
                self._held.remove(piece)
                return piece
        while len(self._held) < _LOOK_AHEAD and (new := next(pieces, None)) is not None:
            self._join.expect(new)
            self._unfinished.append(new)
            if new.is_ready:
                return new
            self._held.append(new)
        return None

    def _job(self, piece: Piece, task: str, *content: object) -> Job:
        name, part = self._sources[piece.source][0], piece.part
        told = f"{name}, frames {part.first} to {part.first + part.count - 1}"
        return Job(told, (task, piece), work, (self._order, task, piece.source, part, *content))

    def _drawing(self, piece: Piece) -> Job | None:
        wanted = [self._pictures.wanted(piece.first + i, i, frame) for i, frame in enumerate(piece.joined)]
        self._drawn[piece] = {}
        if not any(wanted):
            self._finish(piece)
            return None
        return self._job(piece, "draw", [w for w in wanted if w is not None])

    def _take(self, done: Done) -> None:
        task, piece = done.job.tag
        for item in done.items:
            if task == "recognise":
                self._take_seen(piece, item)
            else:
                self._drawn[piece][item.place] = item
        if task == "recognise":
            self._go_on()
        elif done.last:
            self._finish(piece)

    def _take_seen(self, piece: Piece, seen: Seen) -> None:
        for note in seen.notes:
            self._note(note)
        piece.add(seen.place, self._journal.append(piece.first + seen.place, seen.frame))

    def _go_on(self) -> None:
        for piece, _, frame in self._join.ready():
            self._record(piece.source, frame.record())
            if piece.is_joined:
                self._to_draw.append(piece)

    def _finish(self, piece: Piece) -> None:
        """A piece is drawn: what was waiting for it can be written."""
        self._through.add(piece)
        while self._unfinished and self._unfinished[0] in self._through:
            head = self._unfinished.popleft()
            self._through.remove(head)
            drawn = self._drawn.pop(head)
            for place, frame in enumerate(head.joined):
                self._pictures.add(head.first + place, head.source, frame, drawn.get(place))
