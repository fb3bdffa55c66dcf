"""What `artrec replay` counts and tells at the end."""

from __future__ import annotations

import math
import platform
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
import scipy

from ... import __version__
from ...core.drawing import but_for_numbers
from ...core.geometry.scene import times_the_scale
from ...core.plane_sizes import PlaneSizes
from ...io.results.results import DETECTIONS_FILE, FrameRecord

_NAMED = 3  # frames of one error
_FEW = 3  # that are turned down say nothing yet
_PROBABLE = 0.5  # what was turned down for its scale alone was likelier there than not
_OFF_SHARE = 0.1  # of objects, so many turned down for it are no chance


@dataclass
class Summary:
    """What a replay counted; grows frame by frame."""

    frames: int = 0
    objects: Counter[str] = field(default_factory=Counter)
    frames_without_objects: int = 0
    frames_cut_short: Counter[str] = field(default_factory=Counter)  # by the limit that did it
    errors: Counter[str] = field(default_factory=Counter)
    unusable: dict[str, dict[str, None]] = field(default_factory=dict)  # error -> names of frames, in order
    waiting: int = 0
    total_ms: list[float] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)
    interrupted: bool = False
    why_none: Counter[str] = field(default_factory=Counter)  # of frames without objects, but for numbers
    reasons: dict[str, str] = field(default_factory=dict)  # the first one that was so
    on_plane: PlaneSizes = field(default_factory=PlaneSizes)
    off_scale: list[float] = field(default_factory=list)  # how many times the plane's scale what was refused for it had

    def add(self, record: FrameRecord) -> None:
        """Count one more frame."""
        self.frames += 1
        if record.error is not None:
            self.errors[record.error] += 1
            self.unusable.setdefault(record.error, {})[record.frame] = None
            return
        self.objects.update(d.object for d in record.detections)
        self.on_plane.add(record.detections)
        self.frames_without_objects += not record.detections
        self.frames_cut_short.update(record.ended_by)
        self.waiting += record.waiting
        off = (times_the_scale(r.reason) for r in record.rejected if r.score >= _PROBABLE)
        self.off_scale += [times for times in off if times is not None]
        if record.rejected and not record.detections:
            likeliest = max(record.rejected, key=lambda r: r.score)
            kind = but_for_numbers(likeliest)
            self.why_none[kind] += 1
            self.reasons.setdefault(kind, f"{likeliest.object}: {likeliest.reason}")
        if "total" in record.timing_ms:
            self.total_ms.append(record.timing_ms["total"])

    @property
    def unusable_only(self) -> bool:
        """Whether there were frames, and none of them could be used."""
        return 0 < self.frames == self.errors.total()

    def to_dict(self) -> dict[str, Any]:
        return {
            "frames": self.frames,
            "frames_with_error": self.errors.total(),
            "errors": dict(self.errors.most_common(20)),
            "frames_without_objects": self.frames_without_objects,
            "frames_cut_short_by": dict(sorted(self.frames_cut_short.items())),
            "blobs_waiting": self.waiting,
            "objects": dict(sorted(self.objects.items())),
            "total_ms": self._times(),
            "problems": self.problems,
            "interrupted": self.interrupted,
            "versions": versions(),
        }

    def _times(self) -> dict[str, float] | None:
        """None: no frame was timed."""
        if not self.total_ms:
            return None
        times = np.array(self.total_ms)
        return {
            "mean": round(float(times.mean()), 3),
            "median": round(float(np.median(times)), 3),
            "p95": round(float(np.percentile(times, 95)), 3),
            "max": round(float(times.max()), 3),
        }

    def lines(self) -> Iterator[str]:
        """What the user is told at the end."""
        if self.unusable_only:
            yield f"frames {self.frames}, no image could be used, so nothing was looked for"
            return
        found = ", ".join(f"{n} {name}" for name, n in sorted(self.objects.items())) or "none"
        yield f"frames {self.frames}, objects found: {found}; frames without any: {self.frames_without_objects}"
        for kind, count in self.why_none.most_common(1):
            where = f"in {count} of these" if count > 1 else "in one of these"
            yield f"why not, most often ({where}; all reasons: {DETECTIONS_FILE}): {self.reasons[kind]}"
        yield from self._of_the_plane()
        if (sizes := self.on_plane.line()) is not None:
            yield sizes
        if (t := self._times()) is not None:
            yield f"ms per frame: median {t['median']:.1f}, 95 % within {t['p95']:.1f}, longest {t['max']:.1f}"
        for limit, count in sorted(self.frames_cut_short.items()):
            yield f"{count} frame(s) were cut short by {limit}"

    def _of_the_plane(self) -> Iterator[str]:
        """That much was turned down for its scale alone, where it is off alike."""
        n, told = len(self.off_scale), self.objects.total()
        if n < _FEW or n < _OFF_SHARE * (n + told):
            return
        low, middle, high = np.percentile(self.off_scale, [25, 50, 75])
        most = float(np.percentile(np.exp(np.abs(np.log(self.off_scale))), 90)) - 1
        yield (
            f"{n} candidates beside {told} objects were turned down for nothing but their scale: {middle:.2f} times "
            f"that of scene.plane (half of them {low:.2f} to {high:.2f}). Where these are objects, the plane's points, "
            "or lengths or outlines of the object file, are off; else they are other things. "
            f"scene.plane.scale_tolerance {math.ceil(20 * most - 1e-6) / 20:.2f} would keep nine in ten"
        )

    def failures(self) -> Iterator[str]:
        """What went wrong, for stderr: frames and sources that could not be used."""
        for error, count in self.errors.most_common(5):
            names = [name for name in self.unusable[error] if not name.startswith("/")]  # files, not a bag's topic
            shown = f" ({', '.join(names[:_NAMED])}{', ...' if len(names) > _NAMED else ''})" if names else ""
            yield f"{count} frame(s) could not be used: {error}{shown}"
        if len(self.errors) > 5:
            yield f"and {len(self.errors) - 5} more kinds of errors, see {DETECTIONS_FILE}"
        yield from self.problems


def versions() -> dict[str, str]:
    """Of what results depend on."""
    return {
        "artrec_ros": __version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "opencv": cv2.__version__,
        "scipy": scipy.__version__,
        "platform": platform.platform(),
    }
