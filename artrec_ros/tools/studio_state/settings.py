"""Parameters that are tried: each with its range and meaning, the results before and after side by side."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import yaml

from ...core.base.errors import ConfigError, ImageError
from ...core.model.frame_result import FrameResult
from ...io.parameters.parameter_file import Setup
from ...io.parameters.specs import Spec
from ...io.parameters.unread import unread
from ...io.results.journal import Recognised
from ...io.truth.from_coco import load_coco_truth
from ..evaluate import lines
from ..evaluation.comparison import compare
from ..evaluation.result import results_of
from ..evaluation.runs import Run
from ..evaluation.scoring import Options, evaluate_runs
from .examples import ANNOTATIONS_FILE
from .misfits import none_in_common
from .session import Session


class Settings:
    """What differs from the session's parameters, whichever these are by now."""

    def __init__(self, session: Session) -> None:
        self._session = session
        self._changes: dict[str, Any] = {}
        self._tried = (session.setup, session.setup)

    @property
    def tried(self) -> Setup:
        """The set-up with what is tried."""
        base, tried = self._tried
        if base is not self._session.setup:  # something was learned meanwhile
            base = self._session.setup
            tried = base.changed(self._changes) if self._changes else base
            self._tried = base, tried
        return tried

    @property
    def changes(self) -> Mapping[str, Any]:
        """Flat name -> value."""
        return self._changes

    def specs(self) -> dict[str, Spec]:
        """The parameters that may be changed while the recogniser runs, by name; experts' last."""
        setup = self._session.setup
        return {name: s for name, s in setup.specs.items() if s.is_live}

    def value(self, name: str) -> Any:
        """As it is tried."""
        return self._changes.get(name, self._session.setup.value(name))

    def change(self, name: str, value: Any) -> None:
        """Tries another value; that of the session is no change.

        :raises ConfigError: it is not valid; nothing changes then.
        """
        changes = {k: v for k, v in self._changes.items() if k != name}
        if value != self._session.setup.value(name):
            changes[name] = value
        base = self._session.setup
        self._tried = base, base.changed(changes) if changes else base
        self._changes = changes

    def unread(self) -> list[str]:
        """A line for each change that changes nothing: no way in which these frames are recognised reads it."""
        return unread(self.tried, (self._session.stills.camera is not None,), self._changes)

    def reset(self) -> None:
        """Nothing is tried: of the session's parameters as they are now."""
        self._changes, self._tried = {}, (self._session.setup, self._session.setup)

    def save(self) -> None:
        """What is tried becomes the session's, and is written."""
        if self._changes:
            self._session.keep(self._changes)
        self.reset()

    def both(self, number: int) -> tuple[FrameResult, FrameResult]:
        """What is found in a frame before and after."""
        before = self._session.recognise(number, self._session.setup)
        return before, self._session.recognise(number, self.tried)

    def scored(self, told: Callable[[float], None]) -> list[str]:
        """How both do on the frames that are marked by hand: the lines of `artrec evaluate`.

        :raises ArtrecError: no frame is marked by hand.
        """
        path = self._session.folder / ANNOTATIONS_FILE
        if not path.is_file():
            raise ConfigError("no frame is marked: mark all objects of some frames in the tab Examples")
        truth = load_coco_truth(path)
        numbers = [n for n in range(len(self._session.stills)) if self._key(n, truth.by_name) in truth.frames]
        if not numbers:
            named = [Path(str(key)) for key in truth.frames]
            raise ConfigError(none_in_common(str(path), named, self._session.stills))
        setups = {"before": self._session.setup, "after": self.tried} if self._changes else {"now": self._session.setup}
        runs = []
        for i, (name, setup) in enumerate(setups.items()):
            records = []
            for j, n in enumerate(numbers):
                records.append(self._recognised(n, setup).record())
                told((i + (j + 1) / len(numbers)) / len(setups))
            runs.append(Run.of(name, self._session.folder / name, setup, records))
        evaluations = evaluate_runs(runs, truth, Options(camera=self._session.stills.camera))
        return list(lines(results_of(evaluations), [compare(evaluations[0], other) for other in evaluations[1:]]))

    def _key(self, number: int, by_name: bool) -> int | str:
        stills = self._session.stills
        return stills.name(number) if by_name else stills.stamps_ns[number]

    def _recognised(self, number: int, setup: Setup) -> Recognised:
        stills = self._session.stills
        try:
            result = self._session.recognise(number, setup)
        except ImageError as error:
            return Recognised(stills.stamps_ns[number], stills.name(number), error=str(error))
        frame_id = stills.camera.frame_id if stills.camera else ""
        return Recognised(stills.stamps_ns[number], stills.name(number), result, frame_id)


def read_list(text: str) -> list[Any]:
    """What a person writes for a list: 1, 2, 3. :raises ConfigError: it is none."""
    try:
        values = yaml.safe_load(f"[{text.strip().strip('[]')}]")
    except yaml.YAMLError:
        raise ConfigError(f"'{text}' is no list of values, such as 1, 2, 3") from None
    return list(values)
