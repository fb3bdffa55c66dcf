"""What goes on, counted, and told apart: no images, mismatched QoS, unusable images, no calibration, nothing found."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from std_msgs.msg import Header

OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


@dataclass
class Counters:
    """Since the node began: `processed` + `failed` images were received."""

    processed: int = 0
    failed: int = 0
    objects: int = 0
    last_error: str = ""
    last_image_s: float | None = None
    latencies_ms: list[float] = field(default_factory=list)  # of the current period, receive to publish


@dataclass(frozen=True)
class InputState:
    """What is known of the inputs at the moment of a report."""

    topic: str
    publishers: int
    incompatible: str
    dropped: int
    calibration: str  # empty: calibrated; else why not


class Diagnostics:
    """Makes a report of what happened since the last one. Times are a steady clock's seconds."""

    def __init__(self, node_name: str, no_image_after_s: float, now_s: float) -> None:
        self.counters = Counters()
        self._name = node_name
        self._no_image_after_s = no_image_after_s
        self._last_s, self._last = now_s, (0, 0, 0)

    def image_processed(self, now_s: float, latency_ms: float, n_objects: int) -> None:
        c = self.counters
        c.processed += 1
        c.objects += n_objects
        c.last_image_s = now_s
        c.latencies_ms.append(latency_ms)

    def image_failed(self, now_s: float, error: str) -> None:
        c = self.counters
        c.failed += 1
        c.last_image_s, c.last_error = now_s, error

    def report(self, state: InputState, now_s: float, header: Header) -> DiagnosticArray:
        """Three statuses: input, calibration, recognition."""
        c, period = self.counters, max(now_s - self._last_s, 1e-3)
        processed, failed, objects = (
            new - old for new, old in zip((c.processed, c.failed, c.objects), self._last, strict=True)
        )
        latencies, c.latencies_ms = c.latencies_ms, []
        self._last_s, self._last = now_s, (c.processed, c.failed, c.objects)
        statuses = [
            self._input(state, now_s, (processed + failed) / period, failed),
            self._calibration(state),
            self._recognition(processed, objects, processed / period, latencies),
        ]
        return DiagnosticArray(header=header, status=statuses)

    def _input(self, state: InputState, now_s: float, rate_hz: float, failed: int) -> DiagnosticStatus:
        c = self.counters
        silent = c.last_image_s is None or now_s - c.last_image_s > self._no_image_after_s
        if silent and not state.publishers:
            level, text = WARN, f"no images: nobody publishes {state.topic}"
        elif silent and state.incompatible:
            level, text = ERROR, f"QoS mismatch on {state.topic}: {state.incompatible}"
        elif silent:
            level, text = WARN, f"no images: {state.publishers} publisher(s) of {state.topic} send none"
        elif failed:
            level, text = ERROR, f"{failed} image(s) could not be used: {c.last_error}"
        else:
            level, text = OK, f"{rate_hz:.1f} images/s"
        values = {
            "topic": state.topic,
            "publishers": state.publishers,
            "rate_hz": f"{rate_hz:.2f}",
            "processed": c.processed,
            "failed": c.failed,
            "dropped": state.dropped,
            "last_error": c.last_error,
        }
        return self._status("input", level, text, values)

    def _calibration(self, state: InputState) -> DiagnosticStatus:
        if state.calibration:
            return self._status("calibration", WARN, f"{state.calibration}; no metric poses", {})
        return self._status("calibration", OK, "calibrated", {})

    def _recognition(self, processed: int, objects: int, rate_hz: float, latencies: list[float]) -> DiagnosticStatus:
        text = "no image processed" if not processed else f"{objects} object(s) in {processed} image(s)"
        if processed and not objects:
            text = f"nothing found in {processed} image(s)"
        values = {"rate_hz": f"{rate_hz:.2f}", "objects": self.counters.objects}
        if latencies:
            values["latency_median_ms"] = f"{np.median(latencies):.1f}"
            values["latency_max_ms"] = f"{max(latencies):.1f}"
        return self._status("recognition", OK, text, values)

    def _status(self, part: str, level: bytes, text: str, values: dict[str, object]) -> DiagnosticStatus:
        pairs = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
        return DiagnosticStatus(level=level, name=f"{self._name}: {part}", message=text, values=pairs)
