"""One image on its way through the node: message, pixels, calibration, recognition, messages."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from std_msgs.msg import Header

from ..core.base import kernel_cache
from ..core.base.errors import one_line
from ..core.base.patience import Patience
from ..core.drawing import class_picture, draw_result
from ..core.geometry.camera import Camera
from ..core.image.first_look import FirstLook
from ..core.memory.memory import Memory
from ..core.model.found import Detection
from ..core.model.frame_result import FrameResult, Rejection
from ..core.recognizer import Recognizer, check_targets
from ..core.tracking.tracker import Tracker
from ..io.bags.topics import decode_message
from ..io.parameters.parameter_file import Setup
from . import conversions
from .calibration import Calibrations
from .publishers import Publishers
from .worker import LiveQueue

_MOST_SHOWN = 12  # of a list in the log


@dataclass(frozen=True)
class FrameReport:
    """What became of an image.

    :param latency_ms: from its reception until its results were published, by the system clock.
    :param recognition_ms: the recogniser's and the tracker's part of it; the rest is what the node adds.
    :param ended_by: the limits that ended the search early, by the parameters' names.
    :param header_problem: what the image's header lacks; empty: nothing.
    :param frame_id: of the image's header. :param waiting: blobs that wait their turn to be searched again.
    :param on_plane: what was found on the scene's plane.
    :param blobless: why no blob was left to look at, where that is so; worked out when it is looked at.
    """

    n_objects: int
    latency_ms: float
    recognition_ms: float
    ended_by: tuple[str, ...]
    header_problem: str
    frame_id: str = ""
    waiting: int = 0
    blobless: Sequence[Rejection] = ()
    on_plane: Sequence[Detection] = ()


class Ahead(NamedTuple):
    """What a recogniser sees of an image at first sight, while the one before is recognised."""

    recognizer: Recognizer
    look: FirstLook


class Pipeline:
    """Processes images, one at a time, whoever calls. Parameters may change between two of them.

    A thread builds the recogniser. An image that comes before it is there waits for it.

    :ivar dropped: images for which none could be built.
    :ivar problem: why the newest parameters are not in use, a line; empty: they are, or will be soon.
    :param on_fault: called, in another thread, with a line when a recogniser could not be built; and, once, as soon as
        it is known that what is compiled for it cannot be kept, or that nothing is compiled.
    :param on_use: the same with a line when changed parameters hold: whoever changed them was answered before.
    :param is_late: whether a newer image waits already, or soon will; None: none ever does.
    :param on_answer: called when what an image shows is about to be published.
    """

    def __init__(
        self,
        setup: Setup,
        calibrations: Calibrations,
        publishers: Publishers,
        on_fault: Callable[[str], None] = lambda line: None,
        on_use: Callable[[str], None] = lambda line: None,
        is_late: Callable[[], bool] | None = None,
        on_answer: Callable[[], None] = lambda: None,
    ) -> None:
        self._calibrations, self._publishers = calibrations, publishers
        self._on_fault, self._on_use, self._on_answer = on_fault, on_use, on_answer
        self._names, self._classes = [t.name for t in setup.targets], setup.image.named_labels
        self._tracker = Tracker(setup.tracking, setup.targets, setup.recognizer)
        self._one_at_a_time, self._publishing = threading.Lock(), threading.Lock()
        self._patience = Patience(is_late)
        self._memory: tuple[Recognizer, Memory | None] | None = None  # whose it is, and what the last image left
        self._withdrawn = 0  # counts
        self._news = threading.Condition()  # of the recogniser, or that nobody waits for it any more
        check_targets(setup.targets)
        self.dropped, self.problem = 0, ""
        self._share: float | None = None
        self._is_warned = False
        self._current: tuple[Setup, Recognizer] | None = None
        self._builder = LiveQueue(self._build, "new parameters")
        self._builder.offer(setup)

    @property
    def getting_ready(self) -> float | None:
        """The share done of what is compiled at the moment, or 0 while the first recogniser is built; None: nothing."""
        return self._share if self._share is not None else 0.0 if not (self.is_ready or self.problem) else None

    @property
    def is_ready(self) -> bool:
        """Whether there is a recogniser, and no image waits for what is compiled."""
        return self._current is not None and self._share is None

    def _told(self, share: float) -> None:
        self._share = share
        self._warn(kernel_cache.problem())

    def _warn(self, problem: str) -> None:
        if problem and not self._is_warned:
            self._is_warned = True
            self._on_fault(problem)

    def change(self, setup: Setup) -> None:
        """Recognise with these parameters soon: at once where the recogniser stays, else when another one is built.

        Returns at once. Building takes up to seconds; images are answered meanwhile.
        """
        self._builder.offer(setup)

    def withdraw(self) -> None:
        """Publish nothing of what is under way, nor of what waits for it. Returns before that ends."""
        with self._publishing:
            self._withdrawn += 1
        with self._news:
            self._news.notify_all()

    def close(self) -> None:
        """Publish nothing of what is under way, and forget changed parameters."""
        self._builder.close()
        self.withdraw()

    def _build(self, setup: Setup) -> None:
        current, recognizer = self._current or (None, None)
        what = (setup.image, setup.recognizer, setup.targets)
        self.problem = ""
        try:
            if recognizer is None or current is None or what != (current.image, current.recognizer, current.targets):
                self._warn(kernel_cache.switched_off())
                recognizer = setup.build(told=self._told)
                if self._share is not None:
                    self._warn(kernel_cache.problem())
        except Exception as error:  # parameters are checked before: a fault of this package
            fault = "the recogniser could not be built" if current is None else "the parameters are not in use"
            self.problem = f"{fault}: {one_line(error)}; change a parameter or configure the node anew"
            self._on_fault(self.problem)
        else:
            self._current = setup, recognizer
            if current is not None and (changes := _changes(current, setup)):
                self._on_use(f"in use from now on: {changes}")
        finally:
            self._share = None
            with self._news:
                self._news.notify_all()

    def look(self, msg: Any) -> Ahead | None:
        """What can be known of an image before the one before it is answered, for `process`; any thread may ask.

        :raises ArtrecError: the image cannot be used.
        """
        if self._current is None:
            return None
        _, recognizer = self._current
        return Ahead(recognizer, recognizer.look(decode_message(msg)))

    def process(self, msg: Any, received_ns: int, ahead: Ahead | None = None) -> FrameReport | None:
        """Recognise and publish, once there is a recogniser. None: withdrawn meanwhile, or there will be none.

        :param ahead: what `look` made of the message.
        :raises ArtrecError: the image cannot be used.
        """
        withdrawn = self._withdrawn
        with self._news:
            self._news.wait_for(lambda: self._current or self.problem or withdrawn != self._withdrawn)
        if self._current is None:
            self.dropped += withdrawn == self._withdrawn
            return None
        with self._one_at_a_time:
            return self._process(msg, received_ns, ahead, withdrawn) if withdrawn == self._withdrawn else None

    def _process(self, msg: Any, received_ns: int, ahead: Ahead | None, withdrawn: int) -> FrameReport | None:
        assert self._current is not None  # it stays when it is there
        setup, recognizer = self._current
        look = ahead.look if ahead is not None and ahead.recognizer is recognizer else None
        image = decode_message(msg) if look is None else look.image
        size = (int(image.shape[1]), int(image.shape[0]))
        stamp_ns = conversions.stamp_ns(msg.header)
        self._calibrations.meet(msg.header)
        camera = self._calibrations.camera_for(stamp_ns, size, setup.image.rectified, msg.header.frame_id)
        try:
            recognizer.get_ready(camera is not None, self._told)  # calibration may be missing
        finally:
            self._share = None
        began = time.perf_counter()
        memory = self._memory[1] if self._memory and self._memory[0] is recognizer else None
        result, memory = recognizer.follow(look or image, camera, stamp_ns, memory, self._patience)
        self._memory = recognizer, memory
        self._tracker.configure(setup.tracking, setup.recognizer)
        frame_id = (msg.header.frame_id or camera.frame_id) if camera else ""
        result = self._tracker.update(stamp_ns, result, frame_id)
        recognition_ms = (time.perf_counter() - began + (look.took_s if look else 0.0)) * 1e3
        self._on_answer()
        with self._publishing:  # publishers stay until this is done
            if withdrawn != self._withdrawn:
                return None
            self._publishers.publish(result.detections, msg.header, setup.node.marker_lifetime_s)
            latency_ms = (time.time_ns() - received_ns) * 1e-6
            self._publish_pictures(image, result, camera, msg.header)
        problem, n_objects, header_frame = _header_problem(msg.header), len(result.detections), msg.header.frame_id
        times = latency_ms, recognition_ms
        blobless = result.rejected if result.blobless else ()
        on_plane = tuple(d for d in result.detections if d.plane_scale is not None)
        return FrameReport(
            n_objects, *times, result.ended_by, problem, header_frame, result.waiting, blobless, on_plane
        )

    def _publish_pictures(self, image: Any, result: FrameResult, camera: Camera | None, header: Header) -> None:
        """Those that somebody subscribes to."""
        if self._publishers.overlay_is_wanted:
            picture = draw_result(image, result, self._names, camera)
            self._publishers.publish_overlay(conversions.image_to_msg(picture, header))
        if result.labels is not None and self._publishers.labels_are_wanted:
            picture = class_picture(result.labels, self._classes)
            self._publishers.publish_labels(conversions.image_to_msg(picture, header))


def _changes(before: Setup, now: Setup) -> str:
    keys = [key for key in {**before.resolved, **now.resolved} if before.value(key) != now.value(key)]
    return ", ".join(f"{key} {_shown(now.value(key))}" for key in keys)


def _shown(value: Any) -> str:
    if not isinstance(value, list) or len(value) <= _MOST_SHOWN:
        return str(value)
    first = ", ".join(map(str, value[:_MOST_SHOWN]))
    return f"[{first}, ...] ({len(value)} of them)"


def _header_problem(header: Header) -> str:
    if not header.frame_id:
        return "images bear no frame_id: RViz and tf cannot place what is found"
    if not conversions.stamp_ns(header):
        return "images bear no stamp: results cannot be told apart by time"
    return ""
