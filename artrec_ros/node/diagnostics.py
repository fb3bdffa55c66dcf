"""What goes on, counted, and told apart: no images, mismatched QoS, unusable images, most of them dropped or lost, no
calibration, nothing found."""

from __future__ import annotations

import threading
from collections import Counter
from dataclasses import astuple, dataclass, field

import numpy as np
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus, KeyValue
from std_msgs.msg import Header

from ..core.blobless import NO_PIXEL
from ..core.plane_sizes import PlaneSizes
from ..core.warm_up import compiling
from .pipeline import FrameReport

_LATEST = 200  # objects that tell how large they look on the scene's plane: it may change while the node runs
OK, WARN, ERROR = DiagnosticStatus.OK, DiagnosticStatus.WARN, DiagnosticStatus.ERROR


@dataclass
class Counters:
    """Since the node began: `processed` + `failed` images were looked at."""

    processed: int = 0
    failed: int = 0
    objects: int = 0
    incomplete: int = 0
    last_error: str = ""
    is_unusable: bool = False  # the last image
    last_image_s: float | None = None
    header_problem: str = ""  # of the last image
    frame_id: str = ""  # of the last image that had one
    reports: list[FrameReport] = field(default_factory=list)  # of the current period


@dataclass(frozen=True)
class NodeState:
    """What is known of inputs and outputs at the moment of a report.

    :param wrong_type: what else than images is published there, and the way out; empty: nothing.
    :param dropped: images that a newer one replaced before they were looked at. :param lost: that never arrived.
    :param calibration: empty: calibrated; else why not. :param doubt: why a calibration may not be the images' own.
    :param unheard: who subscribes to results and gets none, a line each.
    :param shared: who else publishes under the same names, a line each.
    :param busy_s: since when one image is looked at; 0: none is.
    :param getting_ready: share of the code that is compiled, 0 to 1; None: no image waits for it.
    :param fault: why the newest parameters are not in use; empty: they are.
    :param on_plane: metric poses need no calibration: all are on a plane that is given.
    :param active: the node's lifecycle state lets it work.
    """

    topic: str
    publishers: int = 0
    incompatible: str = ""
    dropped: int = 0
    lost: int = 0
    calibration: str = ""
    doubt: str = ""
    unheard: tuple[str, ...] = ()
    shared: tuple[str, ...] = ()
    busy_s: float = 0.0
    active: bool = True
    getting_ready: float | None = None
    fault: str = ""
    on_plane: bool = False
    wrong_type: str = ""


def getting_ready(share: float) -> str:
    """What users read while the node gets ready."""
    return f"getting ready, {share:.0%}" + (f": {compiling()}" if share else "")


@dataclass(frozen=True)
class _Totals:
    """Images since the node began, or, dropped and lost, since it was activated."""

    processed: int = 0
    failed: int = 0
    dropped: int = 0
    lost: int = 0

    def since(self, before: _Totals) -> _Totals:
        """What has come to it; all where counting began anew."""
        new = ((now - then if now >= then else now) for now, then in zip(astuple(self), astuple(before), strict=True))
        return _Totals(*new)


class Diagnostics:
    """Makes a report of what happened since the last one. Times are a steady clock's seconds.

    Images are counted by one thread and reported by another.
    """

    def __init__(self, node_name: str, now_s: float) -> None:
        self.counters = Counters()
        self._lock = threading.Lock()
        self._name = node_name
        self._last_s, self._last = now_s, _Totals()
        self._was_getting_ready = False
        self._active_s = now_s  # since when images are waited for
        self._hardware_id = ""
        self._on_plane = PlaneSizes(_LATEST)

    def image_processed(self, now_s: float, report: FrameReport) -> None:
        with self._lock:
            c = self.counters
            c.processed, c.is_unusable = c.processed + 1, False
            c.objects += report.n_objects
            c.incomplete += bool(report.ended_by)
            c.last_image_s, c.header_problem = now_s, report.header_problem
            c.frame_id = report.frame_id or c.frame_id
            c.reports.append(report)
            self._on_plane.add(report.on_plane)

    def image_failed(self, now_s: float, error: str, frame_id: str = "") -> None:
        with self._lock:
            c = self.counters
            c.failed, c.is_unusable = c.failed + 1, True
            c.last_image_s, c.last_error = now_s, error
            c.frame_id = frame_id or c.frame_id

    def report(self, state: NodeState, no_image_after_s: float, now_s: float, header: Header) -> DiagnosticArray:
        """Four statuses: input, calibration, recognition, output. Their hardware_id is the camera's frame.

        Where no image has told it yet, the topic stands in its place.
        """
        with self._lock:
            c, period = self.counters, max(now_s - self._last_s, 1e-3)
            totals = _Totals(c.processed, c.failed, state.dropped, state.lost)
            new = totals.since(self._last)
            reports, c.reports = c.reports, []
            self._last_s, self._last = now_s, totals
            self._hardware_id = c.frame_id or state.topic
            if not state.active:
                self._active_s = now_s
            silent = not state.busy_s and now_s - max(c.last_image_s or 0.0, self._active_s) > no_image_after_s
            statuses = [
                self._input(state, silent, new, period),
                self._calibration(state),
                self._recognition(state, new, reports, new.processed / period),
                self._output(state),
            ]
            self._was_getting_ready = state.getting_ready is not None
        return DiagnosticArray(header=header, status=statuses)

    def _input(self, state: NodeState, silent: bool, new: _Totals, period_s: float) -> DiagnosticStatus:
        c, looked_at = self.counters, new.processed + new.failed
        values = {
            "topic": state.topic,
            "publishers": state.publishers,
            "rate_hz": f"{looked_at / period_s:.2f}",
            "processed": c.processed,
            "failed": c.failed,
            "dropped": state.dropped,
            "lost": state.lost,
            "last_error": c.last_error,
        }
        if not state.active:
            level, text = OK, "not active: the lifecycle manager has not activated this node"
        elif state.getting_ready is not None:
            level, text = OK, f"{getting_ready(state.getting_ready)}; {state.dropped} image(s) dropped so far"
        elif state.fault and new.dropped and not looked_at:
            level, text = ERROR, f"{new.dropped} image(s) dropped: there is no recogniser"
        elif silent:
            level, text = self._silence(state)
        else:
            level, text = self._flow(state, new, looked_at, period_s)
        return self._status("input", level, text, values)

    def _silence(self, state: NodeState) -> tuple[bytes, str]:
        """Why no image comes."""
        if not state.publishers:
            return WARN, f"no images: nobody publishes {state.topic}"
        if state.wrong_type:
            return ERROR, f"no images: {state.wrong_type}"
        if state.incompatible:
            return ERROR, f"QoS mismatch on {state.topic}: {state.incompatible}"
        c = self.counters
        text = f"no images: {state.publishers} publisher(s) of {state.topic} send none"
        text += " any more" if c.last_image_s is not None else ""
        return WARN, text + (f"; of those that came: {c.last_error}" if c.last_error and not c.processed else "")

    def _flow(self, state: NodeState, new: _Totals, looked_at: int, period_s: float) -> tuple[bytes, str]:
        """What becomes of images that come."""
        count = new.dropped + looked_at
        if new.failed:
            return ERROR, f"{new.failed} image(s) could not be used: {self.counters.last_error}"
        if new.lost > count:
            return WARN, f"{new.lost} of {new.lost + count} images lost on the way"
        if new.dropped > looked_at:
            fast = "they come faster than they are recognised"
            why = "the node was getting ready" if self._was_getting_ready else fast
            return WARN, f"{new.dropped} of {count} images dropped: {why}"
        if self.counters.is_unusable and not looked_at and not state.busy_s:
            return ERROR, f"the last image could not be used: {self.counters.last_error}"
        if self.counters.header_problem:
            return WARN, self.counters.header_problem
        if not looked_at and state.busy_s:
            return OK, f"one image has been looked at for {state.busy_s:.1f} s"
        return OK, f"{looked_at / period_s:.1f} images/s"

    def _calibration(self, state: NodeState) -> DiagnosticStatus:
        if state.on_plane and (sizes := self._on_plane.line()):
            doubt = f"; the calibration is in doubt: {state.doubt}" if state.doubt else ""
            return self._status("calibration", WARN, sizes + doubt, {})
        if state.calibration and state.on_plane:
            return self._status("calibration", OK, f"{state.calibration}; poses are those on scene.plane", {})
        if state.calibration:
            return self._status(
                "calibration", WARN, f"{state.calibration}; no metric poses but those on a scene.plane", {}
            )
        if state.doubt:
            return self._status("calibration", WARN, f"calibrated, in doubt: {state.doubt}", {})
        return self._status("calibration", OK, "calibrated", {})

    def _recognition(
        self, state: NodeState, new: _Totals, reports: list[FrameReport], rate_hz: float
    ) -> DiagnosticStatus:
        objects, cut_off = sum(r.n_objects for r in reports), Counter(limit for r in reports for limit in r.ended_by)
        level, text = OK, f"{objects} object(s) in {len(reports)} image(s)"
        if state.getting_ready is not None:
            level, text = WARN, getting_ready(state.getting_ready)
        elif state.fault:
            level, text = ERROR, state.fault
        elif not reports:
            text = "no image processed"
        elif not objects:
            why = "; ".join(f"{r.object}: {r.reason}" for r in reports[-1].blobless)
            level = WARN if NO_PIXEL in why else OK
            text = f"nothing found in {len(reports)} image(s)" + (f": {why}" if why else "")
        for limit, count in sorted(cut_off.items()):
            level, text = WARN, f"{text}; {limit} ended the search in {count}"
        waiting = float(np.mean([r.waiting for r in reports])) if reports else 0.0
        # objects in them are told late, and what moves on before its turn comes never; without haste they were
        # searched in vain before
        if waiting >= 1 and new.dropped and not self._was_getting_ready:
            text += f"; {waiting:.0f} blob(s) wait for a close look, for which images come too fast"
        c = self.counters
        values: dict[str, object] = {"rate_hz": f"{rate_hz:.2f}", "objects": c.objects, "incomplete": c.incomplete}
        if reports:
            latency, recognition = np.array([(r.latency_ms, r.recognition_ms) for r in reports]).T
            values["latency_median_ms"] = f"{np.median(latency):.2f}"
            values["latency_max_ms"] = f"{latency.max():.2f}"
            values["recognition_median_ms"] = f"{np.median(recognition):.2f}"
            values["blobs_waiting"] = f"{waiting:.1f}"
            values["added_median_ms"] = f"{np.median(latency - recognition):.2f}"
        return self._status("recognition", level, text, values)

    def _output(self, state: NodeState) -> DiagnosticStatus:
        problems = [*(f"shared: {line}" for line in state.shared), *state.unheard]
        if problems:
            return self._status("output", WARN, "; ".join(problems), {})
        return self._status("output", OK, "every subscriber can hear it", {})

    def _status(self, part: str, level: bytes, text: str, values: dict[str, object]) -> DiagnosticStatus:
        pairs = [KeyValue(key=key, value=str(value)) for key, value in values.items()]
        name = f"{self._name}: {part}"
        return DiagnosticStatus(level=level, name=name, message=text, hardware_id=self._hardware_id, values=pairs)
