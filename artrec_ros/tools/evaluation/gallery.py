"""Pictures of failed frames, small enough to be mailed: overlays of the replay, failures marked."""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from .failures import FALSE, MISSED, FailedFrame, Failure
from .scoring import Evaluation

MOST_CARDS = 500
_WIDEST_PX = 1280  # narrower overlays stay as they are: enlarged, they are sharp
_WEBP_QUALITY = 55
_COLOURS = {MISSED: (60, 60, 255), FALSE: (255, 80, 255)}  # BGR
_OTHER = (0, 190, 255)


@dataclass(frozen=True)
class Card:
    """A failed frame of one run.

    :param run: the run's place. :param picture: data URI, '' where there is no overlay.
    """

    run: int
    failed: FailedFrame
    picture: str


def cards(evaluations: Sequence[Evaluation], failed: Sequence[Sequence[FailedFrame]], most: int) -> list[Card]:
    """Failed frames, those with a picture first, in the truth's order, runs beside each other: those of each in which
    most failed, up to a limit.

    :param most: how many pictures of each run, again where most failed.
    """
    found = []
    for number, (evaluation, frames) in enumerate(zip(evaluations, failed, strict=True)):
        ranked = sorted(frames, key=lambda f: -len(f.failures))
        drawn: dict[int, str] = {}
        for i, f in enumerate(ranked):
            if len(drawn) == most:
                break
            if shown := picture(evaluation, f):  # frames without an overlay use up none of the pictures
                drawn[i] = shown
        first = [*drawn, *(i for i in range(len(ranked)) if i not in drawn)][:MOST_CARDS]
        found += [Card(number, ranked[i], drawn.get(i, "")) for i in first]
    order = {frame.key: i for i, frame in enumerate(evaluations[0].frames)}
    return sorted(found, key=lambda card: (not card.picture, order[card.failed.frame.key], card.run))


def picture(evaluation: Evaluation, failed: FailedFrame) -> str:
    """The replay's overlay, failures marked, as a data URI; '' where the replay wrote none."""
    record = failed.frame.record
    if failed.frame.index is None or record is None:
        return ""
    overlay = _read(evaluation.run.picture(failed.frame.index))
    if overlay is None:
        return ""
    scale = min(1.0, _WIDEST_PX / overlay.shape[1])
    small = cv2.resize(overlay, None, fx=scale, fy=scale, interpolation=cv2.INTER_AREA)
    for failure in failed.failures if record.size else ():
        _mark(small, failure, small.shape[0] / record.size[1] if record.size else 1.0)
    encoded = cv2.imencode(".webp", small, [cv2.IMWRITE_WEBP_QUALITY, _WEBP_QUALITY])[1]
    return "data:image/webp;base64," + base64.b64encode(encoded.tobytes()).decode("ascii")


def _read(path: Path) -> Any:
    """The picture, None where there is none; OpenCV would complain on the terminal."""
    return cv2.imread(str(path), cv2.IMREAD_COLOR) if path.is_file() else None


def _mark(image: Any, failure: Failure, zoom: float) -> None:
    """A ring about the failure, in the colour of its kind. :param zoom: the image's pixels a pixel of the frame."""
    if failure.place is None or not np.isfinite(failure.place).all():
        return
    at = np.clip((failure.place + 0.5) * zoom - 0.5, -1e4, 1e4)
    centre, radius = (int(at[0]), int(at[1])), int(np.clip(1.2 * failure.radius_px * zoom, 10, 1e3))
    for colour, width in (((20, 20, 20), 4), (_COLOURS.get(failure.kind, _OTHER), 2)):
        cv2.circle(image, centre, radius, colour, width, cv2.LINE_AA)
