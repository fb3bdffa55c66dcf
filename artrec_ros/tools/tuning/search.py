"""The search: Optuna proposes values, knowing all that was tried before. Kept in a database, so it can go on."""

from __future__ import annotations

import dataclasses
import errno
import json
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...core.base.errors import ArtrecError, ConfigError, SourceError
from .goal import Goal
from .space import Dimension, distributions, suggested_of, values_of

try:
    import optuna
    from sqlalchemy.exc import SQLAlchemyError
except ImportError as error:
    raise ArtrecError(f"artrec tune: {error}; pip install artrec_ros[tune]") from error

STUDY_FILE = "study.db"
_STARTUP = 10  # trials at random before the sampler begins to learn from them
_UNREADABLE = (SQLAlchemyError, optuna.exceptions.OptunaError, LookupError, ValueError, TypeError, RuntimeError)
_FOR_IMPORTANCE = 20  # trials from which on it can be told which parameters mattered

Measured = Mapping[str, float | None]


@dataclass(frozen=True)
class Tried:
    """One trial. :param problem: why the values could not be used; then nothing was measured."""

    number: int
    values: Mapping[str, Any]
    measured: Measured
    worth: float
    problem: str = ""


@contextmanager
def _database() -> Iterator[None]:
    """A database that cannot be written is a file that cannot."""
    try:
        yield
    except optuna.exceptions.StorageInternalError as error:
        raise OSError(errno.EIO, f"{STUDY_FILE}: {error.__cause__ or error}".splitlines()[0]) from error


class Search:
    """A study in a folder. What is proposed depends on the seed and on what was tried before, and on nothing else:
    an interrupted search goes on as if it had not been."""

    def __init__(self, folder: Path, space: tuple[Dimension, ...], goal: Goal, seed: int) -> None:
        """:raises SourceError: what is kept there cannot be used. :raises OSError: the folder cannot be written."""
        optuna.logging.set_verbosity(optuna.logging.ERROR)
        self._space, self._goal, self._seed = space, goal, seed
        self._distributions = distributions(space)
        try:
            self._study = self._opened(f"sqlite:///{(folder / STUDY_FILE).absolute()}")
            list(self._tried())  # what cannot be read is found now
        except _UNREADABLE as error:
            cause = error.__cause__ or error
            reason = str(getattr(cause, "orig", None) or cause).partition("\n")[0]
            way_out = "put a copy of it back, or begin anew with --overwrite"
            raise SourceError(f"{folder / STUDY_FILE}: cannot be used: {reason}; {way_out}") from error

    def _opened(self, storage: str) -> optuna.Study:
        study = optuna.create_study(storage=storage, study_name="tune", direction="maximize", load_if_exists=True)
        for trial in study.get_trials(states=[optuna.trial.TrialState.RUNNING]):  # of a run that was killed
            study.tell(trial.number, state=optuna.trial.TrialState.FAIL)
        return study

    @property
    def tried(self) -> list[Tried]:
        """All trials that came to an end, in order."""
        return list(self._tried())

    def _tried(self) -> Iterator[Tried]:
        states = [optuna.trial.TrialState.COMPLETE, optuna.trial.TrialState.PRUNED]
        for number, trial in enumerate(self._study.get_trials(deepcopy=False, states=states)):
            attributes = trial.user_attrs
            measured = json.loads(attributes.get("measured", "{}"))
            worth = float("-inf") if trial.value is None else trial.value
            yield Tried(number, values_of(self._space, trial.params), measured, worth, attributes.get("problem", ""))

    @property
    def best(self) -> Tried | None:
        """The first of the best."""
        done = [t for t in self.tried if not t.problem]
        return max(done, key=lambda t: t.worth, default=None)

    def begin(self, parameters: Mapping[str, Any], measured: Measured) -> bool:
        """Count the given parameters as the first trial; false where they lie outside the space."""
        suggested = suggested_of(self._space, parameters)
        if suggested is not None and not self.tried:
            self._study.add_trial(
                optuna.trial.create_trial(
                    value=self._goal.worth(measured), params=suggested, distributions=self._distributions,
                    user_attrs={"measured": json.dumps(measured)},
                )
            )  # fmt: skip
        return suggested is not None

    def next(self, measure: Callable[[Mapping[str, Any]], Measured | None]) -> bool:
        """One more trial. :param measure: of values by name; None: it was interrupted, and the trial does not count.

        :return: whether it came to an end.
        """
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
            seed = 1_000_003 * self._seed + len(self.tried)
            self._study.sampler = optuna.samplers.TPESampler(seed=seed % 2**32, n_startup_trials=_STARTUP)
        with _database():
            trial = self._study.ask(self._distributions)
        problem, measured = "", None
        try:
            measured = measure(values_of(self._space, trial.params))
        except ConfigError as error:
            problem = str(error)
        with _database():
            if problem:
                trial.set_user_attr("problem", problem)
                self._study.tell(trial, state=optuna.trial.TrialState.PRUNED)
            elif measured is None:
                self._study.tell(trial, state=optuna.trial.TrialState.FAIL)
            else:
                trial.set_user_attr("measured", json.dumps(measured))
                self._study.tell(trial, self._goal.worth(measured))
        return bool(problem) or measured is not None

    def importance(self) -> dict[str, float]:
        """Each parameter's share in what made the best tenth of the trials the best; empty: too few to tell.

        PED-ANOVA (Watanabe, Bansal and Hutter 2023).
        """
        done = [t for t in self.tried if not t.problem]
        if len(done) < _FOR_IMPORTANCE or len({t.worth for t in done}) < 2 or len(self._space) < 2:
            return {}
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            evaluator = optuna.importance.PedAnovaImportanceEvaluator()
            found = optuna.importance.get_param_importances(self._study, evaluator=evaluator)
        return {name: round(float(share), 4) for name, share in found.items()}


def to_dict(tried: Tried) -> dict[str, Any]:
    """A trial, for the report; `problem` only where there is one."""
    content = dataclasses.asdict(tried)
    return content if tried.problem else {k: v for k, v in content.items() if k != "problem"}
