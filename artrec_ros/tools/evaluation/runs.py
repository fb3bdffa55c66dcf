"""A replay's results as evaluation needs them; half-written ones as far as they go."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any

from ...core.base.errors import ArtrecError, SourceError
from ...core.model.objects import ObjectModel
from ...io.base.shared_files import resolve_path
from ...io.objects.object_reader import load_object
from ...io.parameters.parameter_file import Setup
from ...io.parameters.sections import read_flat
from ...io.results.results import DETECTIONS_FILE, SUMMARY_FILE, FrameRecord, read_results
from ...io.results.summary_file import LookedFor, read_summary
from ..replaying.names import FRAMES_FOLDER, PARAMETERS_FILE, overlay_name


@dataclass(frozen=True)
class Run:
    """The results of one replay.

    :param name: tells it from the other runs. :param records: of every frame, in order.
    :param models: of the objects whose files are still where they were.
    :param summary: what summary.json says; empty for a replay that never ended.
    :param notes: what the user should know. :param problem: why `models` is not whole.
    """

    name: str
    folder: Path
    records: tuple[FrameRecord, ...]
    objects: Mapping[str, LookedFor]
    models: Mapping[str, ObjectModel]
    parameters: Mapping[str, Any] = field(default_factory=dict)
    summary: Mapping[str, Any] = field(default_factory=dict)
    notes: tuple[str, ...] = ()
    problem: str = ""

    @classmethod
    def of(cls, name: str, folder: Path, setup: Setup, records: Iterable[FrameRecord]) -> Run:
        """Of what was recognised with a set-up just now."""
        looked_for = {t.name: LookedFor(t.label, t.model.required.name) for t in setup.targets}
        models = {t.name: t.model for t in setup.targets}
        return cls(name, folder, tuple(records), looked_for, models, setup.resolved)

    @cached_property
    def frame_id(self) -> str:
        """The frame to which poses refer, '' where there are none."""
        return next((r.frame_id for r in self.records if r.frame_id), "")

    def picture(self, index: int) -> Path:
        """The overlay of a frame, by its place among the records."""
        record = self.records[index]
        return self.folder / FRAMES_FOLDER / overlay_name(index, record.frame, record.stamp_ns)


def load_runs(folders: Sequence[Path]) -> list[Run]:
    """The runs in these folders. :raises SourceError: naming what cannot be read, or a folder that is given twice."""
    if len({folder.resolve() for folder in folders}) < len(folders):
        raise SourceError("the same folder is given twice; two runs or more can be compared, one alone scored")
    return [load_run(folder, name) for folder, name in zip(folders, run_names(folders), strict=True)]


def run_names(folders: Sequence[Path]) -> list[str]:
    """The shortest ends of their paths that tell the folders apart."""
    parts = [folder.resolve().parts for folder in folders]
    length = 1
    while len({p[-length:] for p in parts}) < len(parts):
        length += 1
    return ["/".join(p[-length:]) for p in parts]


def load_run(folder: Path, name: str = "") -> Run:
    """:raises SourceError: no results there, or they cannot be read."""
    records, notes = _read_records(folder / DETECTIONS_FILE)
    flat, problem = _read_parameters(folder / PARAMETERS_FILE)
    models = {}
    for object_name in flat.get("objects", []):
        try:
            path = resolve_path(str(flat.get(f"{object_name}.object_file")), folder)
            models[object_name] = load_object(path)
        except ArtrecError as error:
            problem = problem or f"object '{object_name}': {error}"
    summary, objects = _read_summary(folder / SUMMARY_FILE, flat, models)
    if not summary:
        notes.append(f"{folder / SUMMARY_FILE} is missing: the replay did not end; scored is what it wrote")
    elif summary.get("interrupted"):
        notes.append(f"{folder}: the replay was interrupted; scored is what it wrote")
    if problem:
        notes.append(f"{problem}: what needs the object files is left out")
    return Run(
        name or folder.resolve().name, folder, tuple(records), objects, models, flat, summary, tuple(notes), problem
    )


def _read_records(path: Path) -> tuple[list[FrameRecord], list[str]]:
    records: list[FrameRecord] = []
    try:
        for record in read_results(path):
            records.append(record)
    except SourceError:
        if not _is_cut_off(path, len(records)):
            raise
        return records, [f"{path}: line {len(records) + 1}, the last, is cut off: {len(records)} frames are scored"]
    return records, []


def _is_cut_off(path: Path, whole_lines: int) -> bool:
    """Whether all lines but the last are whole, and the last never got its end."""
    try:
        content = path.read_bytes()
    except OSError:
        return False
    return not content.endswith(b"\n") and content.count(b"\n") == whole_lines


def _read_parameters(path: Path) -> tuple[dict[str, Any], str]:
    """Flat parameters, and why there are none."""
    try:
        return read_flat(path), ""
    except ArtrecError as error:
        return {}, str(error)


def _read_summary(
    path: Path, flat: Mapping[str, Any], models: Mapping[str, ObjectModel]
) -> tuple[dict[str, Any], dict[str, LookedFor]]:
    """The summary and the objects; parameters tell them without a summary, as of a replay that was killed."""
    if path.exists():
        summary = read_summary(path)
        return {**summary}, summary["looked_for"]
    if not models or set(models) != set(flat["objects"]):
        raise SourceError(f"{path}: there is no such file; is this a folder of `artrec replay`?")
    return {}, {n: LookedFor(int(flat[f"{n}.label"]), m.required.name) for n, m in models.items()}
