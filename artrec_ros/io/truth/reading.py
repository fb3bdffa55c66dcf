"""Truth of any kind, told by the file: a bag, truth.jsonl, or a COCO keypoint file."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from ...core.base.errors import SourceError
from ..bags.metadata import BAG_SUFFIXES, is_storage
from .from_bags import load_pose_truth
from .from_coco import load_coco_truth
from .records import Truth, load_truth

_KINDS = f"a bag (a folder, {', '.join(BAG_SUFFIXES)}), truth.jsonl, or a COCO keypoint file (.json)"


def read_truth(path: Path, topics: Sequence[str] = ()) -> Truth:
    """:param topics: of a bag, the PoseArray topics to take. :raises ArtrecError: naming what cannot be read."""
    if path.is_dir() or is_storage(path):
        return load_pose_truth(path, topics)
    if topics:
        raise SourceError(f"{path}: is no bag: it has no topics to choose from")
    if path.suffix == ".jsonl":
        return Truth(dict(load_truth(path).items()), str(path))
    if path.suffix == ".json":
        return load_coco_truth(path)
    raise SourceError(f"{path}: truth is read from {_KINDS}")
