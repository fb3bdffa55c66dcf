"""One run of a tuning: frames are recognised under the given parameters, then under those that are tried."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...core.base.errors import SourceError
from ...io.parameters.parameter_file import Setup
from ...io.results.journal import Journal, Recognised
from ...io.sources.frames import Source
from ...io.truth.records import Truth
from ..evaluation.scoring import Evaluation, Options
from ..replaying.engines import Engine
from ..replaying.work import Order
from .goal import measures
from .material import material_of, pieces_of, recognise, split
from .search import Measured, Search, Tried
from .space import Dimension, changed

BEFORE_FILE = "before.jsonl"


@dataclasses.dataclass(frozen=True)
class HoldOut:
    """Which frames are held out: a share, in blocks of so many, drawn with a seed."""

    share: float
    block: int
    seed: int


class Session:
    """Recognises all frames once with the given parameters; then it can measure others.

    :ivar setup: the given parameters. :ivar split: which frames are tuned on, and which are held out.
    """

    def __init__(
        self,
        folder: Path,
        engine: Engine,
        order: Order,
        sources: Sequence[tuple[str, Source]],
        note: Callable[[str], None],
    ) -> None:
        self._folder, self._engine, self._order, self._note = folder, engine, order, note
        self._pieces, self._names = pieces_of(sources), [name for name, _ in sources]
        self._stopped = False
        self.setup = order.setup

    def stop(self) -> None:
        """End soon; may be called by a signal's handler."""
        self._stopped = True
        self._engine.stop()

    def begin(self, truths: Sequence[Truth], options: Options, hold_out: HoldOut) -> bool:
        """All frames with the given parameters; an earlier run's are not done again.

        :return: whether it came to an end.
        :raises ArtrecError: truth and frames have nothing in common, or cannot be split.
        """
        numbers = {p.first + i for p in self._pieces for i in range(p.part.count)}
        if not numbers:
            raise SourceError(f"{', '.join(self._names)}: there is no frame to tune on")
        with Journal(self._folder / BEFORE_FILE) as journal:
            before = dict(journal.frames())
            if journal.lost:
                self._note(journal.lost)

            def take(number: int, frame: Recognised) -> None:
                before[number] = journal.append(number, frame)

            recognise(self._engine, self._order, self._pieces, numbers - set(before), take, self._note)
        if self._stopped:
            return False
        self._before = before
        self._material = material_of(self._pieces, before, truths, options)
        self.split = split(self._material.numbers, hold_out.share, hold_out.block, hold_out.seed)
        return True

    def before(self, numbers: Sequence[int]) -> Evaluation:
        """The given parameters on these frames."""
        seen = {n: self._before[n] for n in numbers}
        return self._material.evaluated(self.setup, seen, numbers, "before")

    def after(self, setup: Setup, numbers: Sequence[int]) -> Evaluation | None:
        """Other parameters on these frames; None: it was interrupted."""
        seen: dict[int, Recognised] = {}
        order = dataclasses.replace(self._order, setup=setup)
        recognise(self._engine, order, self._pieces, set(numbers), seen.__setitem__, self._note)
        return None if self._stopped else self._material.evaluated(setup, seen, numbers, "after")

    def search(
        self, search: Search, space: tuple[Dimension, ...], trials: int, tell: Callable[[Tried | None], None]
    ) -> bool:
        """Tries values until there are so many trials. :param tell: called after each with the best so far.

        :return: whether it came to an end.
        """

        def measure(values: Mapping[str, Any]) -> Measured | None:
            evaluation = self.after(changed(self.setup, space, values), self.split.tuned_on)
            return None if evaluation is None else measures(evaluation)

        while len(search.tried) < trials:
            if self._stopped or not search.next(measure):
                return False
            tell(search.best)
        return True
