"""What came of a search: a parameter file, and a report of before and after on the frames that were held out."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from ...io.base.whole_files import write_whole
from ...io.parameters.parameter_file import Setup
from ..evaluation import table
from ..evaluation.comparison import compare
from ..evaluation.result import Result, changes_to_dict, results_of
from ..evaluation.scoring import Evaluation
from ..replaying.summary import versions
from .goal import Goal, measures
from .material import Split
from .parameter_text import tuned_text
from .search import Tried, to_dict

FORMAT = "artrec_tuning/1"
REPORT_FILE, PARAMETERS_FILE = "report.json", "parameters.yaml"


@dataclass(frozen=True)
class Outcome:
    """:param setup: the best parameters found; those that were given where nothing better was.
    :param before, after: given and best parameters on the frames held out."""

    goal: Goal
    split: Split
    tried: Sequence[Tried]
    best: Tried
    importance: Mapping[str, float]
    old: Setup
    setup: Setup
    before: Evaluation
    after: Evaluation

    @property
    def changes(self) -> dict[str, Any]:
        """Flat parameters that are not as they were."""
        new = self.setup.resolved
        return {key: value for key, value in new.items() if self.old.value(key) != value}

    def write(self, folder: Path, files: Sequence[Path]) -> list[Path]:
        """:param files: the given parameter files. :raises OSError: a file cannot be written."""
        report, parameters = folder / REPORT_FILE, folder / PARAMETERS_FILE
        write_whole(parameters, tuned_text(files, self.setup, self.changes, parameters, self._note()))
        write_whole(report, json.dumps(self.to_dict(), indent=2, ensure_ascii=False) + "\n")
        return [parameters, report]

    def _note(self) -> str:
        values = [f"{key}: {value}, was {self.old.value(key)}" for key, value in self.changes.items()]
        return "\n".join([f"Found by artrec tune, for {self.goal}.", *values])

    def _results(self) -> list[Result]:
        return results_of([self.before, self.after])

    def to_dict(self) -> dict[str, Any]:
        """The content of the report."""
        before, after = self._results()
        return {
            "format": FORMAT,
            "objective": self.goal.figure,
            "limits": [str(limit) for limit in self.goal.limits],
            "frames": {"tuned_on": len(self.split.tuned_on), "held_out": len(self.split.held_out)},
            "best": to_dict(self.best),
            "changes": self.changes,
            "held_out": {
                "before": before.to_dict()["all"],
                "after": after.to_dict()["all"],
                "difference": changes_to_dict(compare(self.before, self.after)),
            },
            "importance": dict(self.importance),
            "trials": [to_dict(t) for t in self.tried],
            "versions": versions(),
        }

    def lines(self) -> Iterator[str]:
        """What the user reads on the terminal."""
        before, after = self._results()
        tuned_on, held_out = len(self.split.tuned_on), len(self.split.held_out)
        yield f"{len(self.tried)} trials for {self.goal} on {tuned_on} frames; judged on {held_out} others"
        yield ""
        yield from table.of_comparison(
            ["before", "after"], [before.overall, after.overall], [compare(self.before, self.after)]
        )
        yield ""
        if not self.changes:
            yield "nothing better was found than the parameters that were given"
        for key, value in self.changes.items():
            yield f"{key}: {self.old.value(key)} -> {value}"
        yield from self._importance_lines()
        if not self.goal.keeps_limits(self.best.measured):
            yield "no trial kept the limits; this one comes nearest"
        elif not self.goal.keeps_limits(measures(self.after)):
            yield "the limits were kept on the frames tuned on, but not on those held out"

    def _importance_lines(self) -> Iterator[str]:
        if self.importance:
            yield ""
            yield "which parameters mattered (shares)"
            yield from table.aligned([[f"  {name}", f"{share:.2f}"] for name, share in self.importance.items()])
        else:
            yield "too few trials to tell which parameters mattered"
