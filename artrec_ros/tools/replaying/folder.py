"""The folder of a replay: begun, gone on with, finished."""

from __future__ import annotations

import dataclasses
import json
import shutil
from collections.abc import Callable, Mapping, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from ...core.base.errors import ArtrecError, SourceError
from ...io.base.whole_files import LineFile, held, make_folder, why_unwritable, write_whole
from ...io.results.journal import JOURNAL_FILE, Journal, Recognised
from ...io.results.results import DETECTIONS_FILE, SUMMARY_FILE, VIDEO_FILE, FrameRecord, read_results
from ...io.results.summary_file import read_summary
from .names import FRAMES_FOLDER, PARAMETERS_FILE
from .pictures import UNFINISHED
from .plan import PLAN_FILE, check_plan, write_plan
from .summary import Summary

_FILES = (DETECTIONS_FILE, SUMMARY_FILE, PARAMETERS_FILE, VIDEO_FILE, JOURNAL_FILE)  # the plan goes last


class ReplayFolder:
    """A context manager; one process at a time holds it.

    :ivar known: what an earlier run recognised, by the frame's number.
    :ivar finished: there is nothing left to do. :ivar check: raises SourceError where the folder is gone.
    :ivar lost: why some of what an earlier run recognised is recognised again, a line for the user; empty: none is.
    """

    def __init__(self, path: Path, plan: Mapping[str, Any], parameters: str, overwrite: bool) -> None:
        """:raises SourceError: it holds other results, another process is at it, or it cannot be written."""
        self.path, self._several = path, len(plan["sources"]) > 1
        self._stack = ExitStack()
        try:
            make_folder(path / FRAMES_FOLDER)
            self.check = self._stack.enter_context(held(path))
            if overwrite:
                clear(path)
            begun = any((path / name).exists() for name in (PLAN_FILE, DETECTIONS_FILE))
            if begun:
                check_plan(path / PLAN_FILE, plan)
            else:
                _check_free(path, parameters)
                write_whole(path / PARAMETERS_FILE, parameters)
                write_plan(path / PLAN_FILE, plan)
            self.finished = begun and not (path / JOURNAL_FILE).exists() and (path / SUMMARY_FILE).exists()
            self.known: dict[int, Recognised] = {}
            self.lost = ""
            if not self.finished:
                self._open()
        except OSError as error:
            self._stack.close()
            raise SourceError(f"{path}: cannot be written: {why_unwritable(path, error)}") from error
        except BaseException:
            self._stack.close()
            raise

    def __enter__(self) -> ReplayFolder:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def _open(self) -> None:
        self.journal = self._stack.enter_context(Journal(self.path / JOURNAL_FILE))
        self.known, self.lost = dict(self.journal.frames()), self.journal.lost
        self._detections = self._stack.enter_context(LineFile(self.path / DETECTIONS_FILE))
        self._there = self._detections.count  # of an earlier run: what would be written again is the same
        self._count = 0

    def write(self, source: int, record: FrameRecord) -> None:
        """The next frame. :raises OSError: it cannot be written; earlier ones stay whole. :raises SourceError: gone."""
        self.check()
        self._count += 1
        if self._count > self._there:
            record = dataclasses.replace(record, source=source) if self._several else record
            self._detections.append(record.to_json())

    def finish(self, summary: Mapping[str, Any], done: bool) -> None:
        """:param done: nothing is left to do; what an interrupted replay would go on from goes."""
        self.check()
        write_whole(self.path / SUMMARY_FILE, json.dumps(summary, indent=2, ensure_ascii=False) + "\n")
        if done:
            (self.path / JOURNAL_FILE).unlink()

    def summary(self) -> Summary:
        """Of a finished replay. :raises ArtrecError: it cannot be read; naming the way out."""
        try:
            summary = Summary(problems=list(read_summary(self.path / SUMMARY_FILE)["problems"]))
            for record in read_results(self.path / DETECTIONS_FILE):
                summary.add(record)
        except ArtrecError as error:
            raise SourceError(f"{error}; --overwrite replays again") from error
        return summary


def _check_free(folder: Path, parameters: str) -> None:
    """Whether no file of somebody else's would be written over; the parameters may be of a replay that went no farther.

    :raises SourceError: one would.
    """
    there = [folder / name for name in _FILES if (folder / name).exists()]
    there = [p for p in there if p.name != PARAMETERS_FILE or p.read_text(errors="replace") != parameters]
    there += sorted(folder.glob("bag_[0-9]*"))
    if there:
        raise SourceError(
            f"{folder}: holds {there[0].name}, which is of no replay that could go on; choose another folder, or "
            "--overwrite"
        )


def places(folder: Path) -> list[Path]:
    """Files and folders in which a replay writes, or which it clears."""
    names = (*_FILES, PLAN_FILE, FRAMES_FOLDER, UNFINISHED)
    return [*(folder / name for name in names), *folder.glob("bag_[0-9]*")]


def clear(folder: Path) -> None:
    """Removes what a replay writes, and nothing else."""
    for name in (*_FILES, PLAN_FILE):
        (folder / name).unlink(missing_ok=True)
    for picture in (folder / FRAMES_FOLDER).glob("[0-9]*.png"):
        picture.unlink()
    for bag in (folder / UNFINISHED, *folder.glob("bag_[0-9]*")):
        shutil.rmtree(bag, ignore_errors=True)


def counted(
    summaries: Sequence[Summary], folder: ReplayFolder, with_timing: bool, progress: Callable[[], object]
) -> Callable[[int, FrameRecord], None]:
    """What takes each record: into the folder and its summaries, the first of all, the others of each source."""

    def take(source: int, record: FrameRecord) -> None:
        record = record if with_timing else dataclasses.replace(record, timing_ms={})
        folder.write(source, record)
        summaries[0].add(record)
        summaries[1 + source].add(record)
        progress()

    return take
