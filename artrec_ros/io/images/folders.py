"""Folders of images: what of them is read, and what is not."""

from __future__ import annotations

from collections import Counter
from pathlib import Path

from .decoding import IMAGE_SUFFIXES

_BESIDE = (".json", ".jsonl", ".yaml", ".yml", ".xml", ".csv", ".txt", ".md")  # what tells of images, not shows them

LOSSY = "JPEG blurs class numbers: edges bear those of other classes; save label images as PNG"


def is_lossy(path: Path) -> bool:
    """Whether a file's pixels are not quite those that were saved."""
    return path.suffix.lower() in (".jpg", ".jpeg")


def without_suffix(name: str) -> str:
    """What a picture and the frame that it shows have in common: a file's name without the suffix of a picture. Frames
    of videos are called so: they have none, and may hold points."""
    path = Path(name)
    return path.stem if path.suffix.lower() in IMAGE_SUFFIXES else path.name


def images_of(folder: Path) -> list[Path]:
    """Its image files, sorted by name."""
    return sorted(p for p in folder.iterdir() if p.suffix.lower() in IMAGE_SUFFIXES)


def passed_over(folder: Path) -> str:
    """How many files of which other kinds lie in it, such as '3 .gif, 1 .tif': they may be meant as images."""
    known = (*IMAGE_SUFFIXES, *_BESIDE)
    others = [p for p in folder.iterdir() if p.suffix.lower() not in known and p.name[0] != "." and p.is_file()]
    kinds = Counter(p.suffix.lower() or "without suffix" for p in others)
    return ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
