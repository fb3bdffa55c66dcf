"""The failed frames of a replay that was evaluated, and which frames of this sitting they are."""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

from ...core.base.errors import ConfigError
from ...io.results.results import DETECTIONS_FILE
from ..evaluate import METRICS_FILE, evaluate
from ..evaluation.failures import failed_frames
from ..evaluation.gallery import Card, cards
from .stills import Stills

_PICTURES = 60  # as on the page of artrec evaluate


@dataclass(frozen=True)
class Shown:
    """A failed frame. :param number: the frame of this sitting; None: it has none such."""

    card: Card
    number: int | None

    @property
    def key(self) -> str:
        """The frame's name, or its stamp."""
        return str(self.card.failed.frame.key)

    @property
    def reasons(self) -> list[str]:
        """A line for each failure."""
        return [f"{f.kind} {f.name}: {f.reason}" for f in self.card.failed.failures]


def truth_of(folder: Path) -> Path:
    """The truth that a replay was scored by. :raises ConfigError: it was not scored yet, or its truth is gone."""
    path = folder / METRICS_FILE
    if not (folder / DETECTIONS_FILE).is_file():
        raise ConfigError(f"{folder}: no folder of artrec replay: {DETECTIONS_FILE} is not there")
    try:
        told = Path(json.loads(path.read_text(encoding="utf-8"))["truth"])
    except (OSError, ValueError, KeyError, TypeError):
        raise ConfigError(f"{path}: no scores there; name the truth, or run artrec evaluate {folder} first") from None
    if not told.exists():
        raise ConfigError(f"{path}: its truth {told} is not there; name it")
    return told


def load_failures(folder: Path, truth: Path | None, stills: Stills) -> list[Shown]:
    """The failed frames as on the page of `artrec evaluate`: those with a picture first.

    :param truth: None: that which the folder was scored by. :raises ArtrecError: the folder holds no replay, ...
    """
    (result,), _ = evaluate([folder], truth or truth_of(folder))
    evaluation = result.evaluation
    found = cards([evaluation], [failed_frames(evaluation)], _PICTURES)
    return [Shown(card, _number(card, stills)) for card in found]


def _number(card: Card, stills: Stills) -> int | None:
    record, key = card.failed.frame.record, card.failed.frame.key
    if isinstance(key, str):
        return stills.number(Path(key))
    stamp = record.stamp_ns if record is not None else key
    return stills.stamps_ns.index(stamp) if stamp in stills.stamps_ns else None
