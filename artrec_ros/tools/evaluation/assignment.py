"""Which frame and which objects of the truth belong to which of a run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...core.base.errors import SourceError
from ...core.model.identities import identities_of
from ...io.base.yaml_files import nearest
from ...io.images.folders import without_suffix
from ...io.results.results import FrameRecord
from ...io.truth.records import FrameKey, TrueObject, Truth
from .runs import Run


@dataclass(frozen=True)
class Choice:
    """Which objects of a truth go by a run's object name: those of a name, or of a class label.

    :param identified: their names where these say besides which one of several like objects it is: yellow_gr.
    """

    name: str | None = None
    label: int | None = None
    identified: frozenset[str] = frozenset()

    def of(self, objects: Sequence[TrueObject]) -> list[TrueObject]:
        if self.name is not None:
            return [o for o in objects if o.name == self.name or o.name in self.identified]
        return [o for o in objects if o.label == self.label]


def choose_objects(truth: Truth, run: Run, names: Mapping[str, str] | None = None) -> dict[str, Choice]:
    """The truth's objects of each of the run's names: by `names`, else by name, else by class label.

    :param names: the run's name -> the truth's name or label; only these are scored.
    :raises SourceError: names that one of the two does not have, or nothing in common.
    """
    there = Counter(o.name for o in truth.objects() if o.name is not None)
    labels = Counter(o.label for o in truth.objects() if o.label is not None)
    if names is not None:
        return {name: _named(name, wanted, run, there, labels) for name, wanted in names.items()}
    identified = {name: _identified(name, run) & there.keys() for name in run.objects}
    if any(name in run.objects for name in there) or any(identified.values()):
        return {name: Choice(name, identified=identified[name]) for name in run.objects}
    if any(o.label in labels for o in run.objects.values()) or not (there or labels):
        return {name: Choice(label=o.label) for name, o in run.objects.items()}
    known = [f"'{n}'" for n in there] or [f"label {n}" for n in labels]
    looked_for = ", ".join(f"'{n}' (label {o.label})" for n, o in run.objects.items())
    raise SourceError(
        f"{truth.source}: holds objects {', '.join(known)}; {run.folder} looked for {looked_for}; say which is which "
        f"with --names {next(iter(run.objects), 'NAME')}={next(iter(there or labels))}"
    )


def _identified(name: str, run: Run) -> frozenset[str]:
    """What a run's object is called where that says which one it is: yellow_gr."""
    model = run.models.get(name)
    called = {f"{name}_{identity.name}" for identity in identities_of(model)} if model is not None else set()
    return frozenset(called - run.objects.keys())


def _named(name: str, wanted: str, run: Run, there: Mapping[str, int], labels: Mapping[int, int]) -> Choice:
    if name not in run.objects:
        raise SourceError(f"--names: '{name}' is no object of this replay{nearest(name, run.objects)}")
    if wanted in there:
        return Choice(name=wanted)
    if wanted.isdecimal() and (int(wanted) in labels or not (there or labels)):
        return Choice(label=int(wanted))
    raise SourceError(
        f"--names: {name}={wanted}: the truth has no objects '{wanted}'"
        f"{nearest(wanted, [*there, *(str(label) for label in labels)])}"
    )


def strangers(truth: Truth, choices: Mapping[str, Choice]) -> dict[str, int]:
    """How many objects of the truth belong to none of the choices, by name or label."""
    left: Counter[str] = Counter()
    for objects in truth.frames.values():
        taken = {id(o) for choice in choices.values() for o in choice.of(objects)}
        left.update(o.name or f"label {o.label}" for o in objects if id(o) not in taken)
    return dict(left)


def match_frames(truth: Truth, run: Run, max_gap_ns: int = 0) -> dict[FrameKey, int]:
    """The place among the run's records of each frame of the truth that has a result.

    :param max_gap_ns: how far the stamps of one frame may lie apart.
    :raises SourceError: if there is none; it says how far off the two are.
    """
    own = [_key(record, truth.by_name) for record in run.records]
    places = {key: i for i, key in enumerate(own)}
    found = {key: places[_called(key, places)] for key in truth.frames if _called(key, places) in places}
    if max_gap_ns and not truth.by_name:
        found = _nearest_frames(list(truth.frames), own, max_gap_ns)
    if not found:
        raise SourceError(_nothing_in_common(truth, run, own))
    return found


def _called(key: FrameKey, places: Mapping[FrameKey, int]) -> FrameKey:
    """What results call the frame: those of a video name it without the suffix of the picture that was marked."""
    return without_suffix(key) if isinstance(key, str) and key not in places else key


def repeated_frames(truth: Truth, run: Run) -> int:
    """Results whose frame cannot be told from a later one's."""
    return len(run.records) - len({_key(record, truth.by_name) for record in run.records})


def _key(record: FrameRecord, by_name: bool) -> FrameKey:
    return Path(record.frame).name if by_name else record.stamp_ns


def _nearest_frames(wanted: Sequence[FrameKey], own: Sequence[FrameKey], max_gap_ns: int) -> dict[FrameKey, int]:
    """For each stamp the nearest result within the gap; a result serves one stamp, the nearest to it."""
    known, results = np.array(wanted, np.int64), np.array(own, np.int64)
    order = np.argsort(results, kind="stable")
    order = order[np.append(np.diff(results[order]) > 0, True)]  # of one stamp the last one counts
    neighbours = _neighbours(known, results[order])
    gaps = np.abs(results[order][neighbours] - known)
    found: dict[FrameKey, int] = {}
    used: set[int] = set()
    for i in np.argsort(gaps, kind="stable"):
        place = int(order[neighbours[i]])
        if gaps[i] <= max_gap_ns and place not in used:
            used.add(place)
            found[wanted[i]] = place
    return {key: found[key] for key in wanted if key in found}


def _neighbours(values: np.ndarray, among: np.ndarray) -> np.ndarray:
    """For each value the index of the nearest in a sorted array."""
    right = np.clip(np.searchsorted(among, values), 1, max(len(among) - 1, 1))
    right = np.minimum(right, len(among) - 1)
    left = np.maximum(right - 1, 0)
    return np.where(np.abs(among[left] - values) <= np.abs(among[right] - values), left, right)


def _is_of_video(record: FrameRecord) -> bool:
    """Of a folder frames bear the suffix of an image, of a bag the name of a topic."""
    return without_suffix(record.frame) == record.frame


def _nothing_in_common(truth: Truth, run: Run, own: Sequence[FrameKey]) -> str:
    if not own:
        return f"{run.folder}: the results hold no frame, the truth {len(truth.frames)}"
    first, video = next(iter(truth.frames)), _is_of_video(run.records[0])
    if truth.by_name:
        way_out = "annotated images go by file name: replay their folder"
        if video:
            way_out = "pictures of a video go by its name and the frame's number, from 0: name them so, with a suffix"
        return (
            f"no image of the truth ({len(truth.frames)}, such as '{first}') is one of the results' frames "
            f"({len(own)}, such as '{own[0]}'); {way_out}"
        )
    known, results = np.sort(np.array(list(truth.frames), np.int64)), np.sort(np.array(own, np.int64))
    gap_s = np.abs(results[_neighbours(known, results)] - known).min() / 1e9
    way_out = "--max-gap allows for some"
    if video:
        way_out += (
            "; stamps of a video are its own times, from 0: replay the bag, or evaluate by annotated pictures named "
            f"like its frames ({Path(run.records[0].frame).name}.png)"
        )
    elif results[0] == 0:
        way_out = "images of a folder are numbered from 0: replay the bag, or evaluate by annotations of the folder"
    return (
        f"no stamp of the truth ({len(known)} frames from {known[0]}) is one of the results' ({len(results)} frames "
        f"from {results[0]}); the nearest two are {gap_s:.6g} s apart; {way_out}"
    )
