"""The other side of the node: a process that runs it, and a peer on the same graph that talks to it."""

from __future__ import annotations

import array
import os
import re
import signal
import subprocess
import sys
import time
from collections import defaultdict
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import rclpy
import toy
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rcl_interfaces.srv import GetParameters, SetParametersAtomically
from rclpy.duration import Duration
from rclpy.executors import SingleThreadedExecutor
from rclpy.parameter import Parameter
from rclpy.qos import QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CameraInfo, Image

WAIT_S = 120.0  # far longer than anything takes, on a machine that is busy with other work too
ROOT = Path(__file__).resolve().parents[2]
STARTED = "looking for toy"
PER_IMAGE = ("toy/poses", "toy/robots", "toy/joint_states")
_RUN = "import sys; from artrec_ros.node.main import main; sys.exit(main())"


def ros(parameter_file: Path, *more: str) -> list[str]:
    """Command line arguments."""
    return ["--ros-args", "--params-file", str(parameter_file), *more]


class NodeProcess:
    """`artrec_node` with these arguments, as a process."""

    def __init__(self, *arguments: str, log: Path, program: str = _RUN) -> None:
        self._log = log
        path = os.pathsep.join([str(ROOT), *filter(None, [os.environ.get("PYTHONPATH")])])
        with log.open("wb") as out:
            self._process = subprocess.Popen(
                [sys.executable, "-c", program, *arguments],
                stdout=out,
                stderr=out,
                env={**os.environ, "PYTHONPATH": path},
            )

    def __enter__(self) -> NodeProcess:
        return self

    def __exit__(self, *_: Any) -> None:
        if self.running:
            self._process.kill()
            self._process.wait()
        print(self.output)  # pytest shows it where a test failed

    @property
    def running(self) -> bool:
        return self._process.poll() is None

    @property
    def output(self) -> str:
        return self._log.read_text()

    def told_s(self, text: str) -> list[float]:
        """When the log said so."""
        stamps = re.findall(rf"^\[[A-Z]+\] \[([0-9.]+)\] .*{re.escape(text)}", self.output, re.MULTILINE)
        return [float(s) for s in stamps]

    def wait(self) -> int:
        return self._process.wait(WAIT_S)

    def stop(self, number: signal.Signals) -> int:
        self._process.send_signal(number)
        return self.wait()

    def wait_for_output(self, text: str) -> None:
        wait_until(lambda: text in self.output or not self.running)
        assert text in self.output, self.output


def wait_until(condition: Callable[[], Any], step: Callable[[], Any] = lambda: time.sleep(0.02)) -> Any:
    """The first true value of `condition`; its last one when time is up."""
    end = time.monotonic() + WAIT_S
    while not (value := condition()) and time.monotonic() < end:
        step()
    return value


class Peer:
    """Publishes images and calibrations, and keeps what it hears."""

    def __init__(
        self, image_topic: str = "image", namespace: str = "", *, reliable: bool = True, image_type: Any = Image
    ) -> None:
        self._context = rclpy.Context()
        self._context.init()
        self.node = rclpy.create_node("peer", namespace=namespace, context=self._context)
        self._executor = SingleThreadedExecutor(context=self._context)
        self._executor.add_node(self.node)
        self._policy = ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT
        qos = QoSProfile(depth=1, reliability=self._policy)
        self._images = self.node.create_publisher(image_type, image_topic, qos)
        self._infos = self.node.create_publisher(CameraInfo, "camera_info", 1)
        self._statuses: list[DiagnosticStatus] = []
        self.node.create_subscription(
            DiagnosticArray, "/diagnostics", lambda msg: self._statuses.extend(msg.status), 10
        )
        self.heard: dict[str, list[Any]] = defaultdict(list)
        self._stamp_s, self.sent = 1_700_000_000, 0

    def __enter__(self) -> Peer:
        return self

    def __exit__(self, *_: Any) -> None:
        self._executor.shutdown()
        self.node.destroy_node()
        self._context.try_shutdown()

    def forget(self) -> None:
        """Pass over all that was heard so far."""
        self._statuses.clear()
        for messages in self.heard.values():
            messages.clear()

    def listen(self, topic: str, message_type: Any) -> Any:
        return self.node.create_subscription(message_type, topic, self.heard[topic].append, 10)

    def spin_until(self, condition: Callable[[], Any]) -> Any:
        return wait_until(condition, lambda: self._executor.spin_once(timeout_sec=0.05))

    def connect(self, image: Any, first_stamp_s: int = 1_700_000_000) -> int:
        """Wait until the node asks for images as reliably as they are sent, and answers one wherever it is listened to.

        :param image: is sent again and again meanwhile: each side matches the other in its own time.
        :return: the stamp of an image that was answered.
        """
        assert self.spin_until(self._same_reliability)
        assert self.spin_until(lambda: all(self.node.count_publishers(s.topic_name) for s in self.node.subscriptions))
        self.forget()
        last_s = 0.0

        def answered() -> bool:
            nonlocal last_s
            if time.monotonic() > last_s + 0.2:
                self.send(image)
                last_s = time.monotonic()
            return all(self.heard[topic] for topic in PER_IMAGE if topic in self.heard)

        assert "toy/poses" in self.heard, "listen there before"
        self._stamp_s = max(self._stamp_s, first_stamp_s) if self.sent else first_stamp_s
        assert self.spin_until(answered)
        return int(self.heard["toy/poses"][-1].header.stamp.sec)

    def _same_reliability(self) -> bool:
        return self._reliabilities(self._images) == [self._policy]

    def _reliabilities(self, publisher: Any) -> list[ReliabilityPolicy]:
        found = self.node.get_subscriptions_info_by_topic(publisher.topic_name)
        return [s.qos_profile.reliability for s in found]

    def send_camera(self, matrix: np.ndarray) -> None:
        """A calibration, that has arrived when this returns: it holds for the next image."""

        def is_heard_surely() -> bool:
            reliable = self._reliabilities(self._infos) == [ReliabilityPolicy.RELIABLE]
            return reliable and self._infos.get_subscription_count() == 1

        assert self.spin_until(is_heard_surely)
        self._infos.publish(toy.camera_info(matrix))
        assert self._infos.wait_for_all_acked(Duration(seconds=WAIT_S))

    def send(self, msg: Any, stamp_s: int | None = None) -> int:
        """Publish an image with a stamp of its own, or the one given; returns that stamp's seconds."""
        self._stamp_s += 1
        self.sent += 1
        sec = self._stamp_s if stamp_s is None else stamp_s
        msg.header.stamp.sec, msg.header.stamp.nanosec, msg.header.frame_id = sec, 250, "eye"
        self._images.publish(msg)
        return sec

    def send_serialized(self, data: bytes) -> None:
        """Publish bytes in place of an image."""
        self._images.publish(data)

    def answer(self, topic: str, stamp_s: int) -> Any:
        """The message of a topic that bears an image's stamp."""

        def find() -> Any:
            return next((m for m in self.heard[topic] if m.header.stamp.sec == stamp_s), None)

        self.spin_until(find)
        found = find()
        assert found is not None, f"no {topic} for the image of {stamp_s} s"
        return found

    def diagnose(self, part: str, text: str, sending: Any = None) -> DiagnosticStatus:
        """The next status of a part of the node whose message holds `text`; what came before it is passed over.

        :param sending: an image to send again and again until then, so that a whole period holds no other.
        """
        skipped: list[str] = []
        last_s = 0.0

        def find() -> DiagnosticStatus | None:
            nonlocal last_s
            if sending is not None and time.monotonic() > last_s + 0.2:
                self.send(sending)
                last_s = time.monotonic()
            while self._statuses:
                status = self._statuses.pop(0)
                if status.name.endswith(f": {part}"):
                    if text in status.message:
                        return status
                    skipped.append(status.message)
            return None

        found = self.spin_until(find)
        assert found, f"no '{text}' among {sorted(set(skipped))}"
        return found

    def set_parameters(self, **values: Any) -> Any:
        """The node's answer to one atomic change; __ in a name stands for a dot."""
        request = SetParametersAtomically.Request()
        names = {name.replace("__", "."): value for name, value in values.items()}
        request.parameters = [Parameter(name, value=value).to_parameter_msg() for name, value in names.items()]
        return self.call(SetParametersAtomically, "set_parameters_atomically", request).result

    def get_parameter(self, name: str) -> Any:
        answer = self.call(GetParameters, "get_parameters", GetParameters.Request(names=[name]))
        return rclpy.parameter.parameter_value_to_python(answer.values[0])

    def call(self, service: Any, name: str, request: Any) -> Any:
        """The node's answer to a request of one of its services."""
        client = self.node.create_client(service, f"artrec_node/{name}")
        assert self.spin_until(client.service_is_ready)
        future = client.call_async(request)
        assert self.spin_until(future.done)
        self.node.destroy_client(client)
        return future.result()


def label_image(pixels: np.ndarray) -> Image:
    """A mono8 message of class numbers."""
    height, width = pixels.shape
    return Image(height=height, width=width, step=width, encoding="mono8", data=array.array("B", pixels.tobytes()))
