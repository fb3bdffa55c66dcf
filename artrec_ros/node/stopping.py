"""Being asked to stop, by SIGINT or SIGTERM, at any moment of the executable's life."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable

_ASKED_BY = (signal.SIGINT, signal.SIGTERM)
_GRACE_S = 1.0  # that a callback may take to its end
_REPEATED_S = 2.0  # ^C under `ros2 launch` reaches a node twice: from the terminal and from launch
_TAKE_DOWN_S = 3.0


class Stop:
    """Ends the process, with exit code 0, when it gets SIGINT or SIGTERM.

    While the node spins, rclpy ends that, and all else follows in order. But the node may be busy with imports, or a
    minute of compilation. An exception raised there by a signal comes out anywhere, as in destructors and C callbacks,
    which print and forget it. So a thread waits for signals, and where the main thread does not end by itself, the
    thread takes down what there is and ends the process.

    SIGINT is listened to even where it was inherited as ignored, as by what a shell starts in the background:
    `ros2 launch` stops its nodes with it.

    :ivar asked: a signal has come.
    """

    def __init__(self) -> None:
        self.asked = False
        self._take_down: Callable[[], object] | None = None
        self._grace_s = 0.0
        self._is_ending, self._taking_down = threading.Event(), threading.Lock()
        if threading.current_thread() is not threading.main_thread():  # which alone may listen
            return
        signals, wake = os.pipe()
        os.set_blocking(wake, False)
        threading.Thread(target=self._wait, args=(signals,), name="signals", daemon=True).start()
        signal.set_wakeup_fd(wake, warn_on_full_buffer=False)
        for number in _ASKED_BY:
            signal.signal(number, lambda number, frame: None)  # the thread does what there is to do

    def begin(self, take_down: Callable[[], object]) -> None:
        """From now on there is something to take down; until now a signal ends the process on the spot."""
        self._take_down = take_down

    def spin(self) -> None:
        """From now on the main thread ends by itself when rclpy is shut down, which rclpy does at signals."""
        self._grace_s = _GRACE_S

    def end(self) -> None:
        """Take down what there is, once."""
        self._is_ending.set()
        with self._taking_down:
            take_down, self._take_down = self._take_down, _nothing
            if take_down is not None:
                take_down()

    def _wait(self, signals: int) -> None:
        asked_s = 0.0
        while number := os.read(signals, 1):
            if number[0] not in _ASKED_BY or (self.asked and time.monotonic() < asked_s + _REPEATED_S):
                continue
            if self._take_down is None or self.asked:
                os._exit(0)
            self.asked, asked_s = True, time.monotonic()
            sys.unraisablehook = lambda _: None  # what breaks in destructors by this is of no interest
            threading.Thread(target=self._see_to_it, name="end", daemon=True).start()

    def _see_to_it(self) -> None:
        if self._is_ending.wait(self._grace_s):
            return
        thread = threading.Thread(target=self.end, name="take down", daemon=True)
        thread.start()  # in a thread of its own: the main thread may hold what it needs
        thread.join(_TAKE_DOWN_S)
        os._exit(0)


def _nothing() -> None:
    """What is left to take down when that was done."""
