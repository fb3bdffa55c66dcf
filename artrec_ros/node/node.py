"""The node: images in; poses, joints, markers, an overlay and diagnostics out. Wiring only."""

from __future__ import annotations

import time
import traceback
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import cv2
from rclpy.clock import Clock, ClockType
from rclpy.lifecycle import LifecycleNode, LifecycleState, TransitionCallbackReturn
from std_msgs.msg import Header

from ..core.base.errors import ArtrecError, ConfigError, one_line
from ..core.ways import all_on_plane
from ..io.messages import node_topics as topics
from ..io.parameters.parameter_file import Setup
from .calibration import Calibrations
from .conversions import message_class
from .diagnostics import Counters, Diagnostics, NodeState, getting_ready
from .inputs import Inputs
from .parameters import LiveParameters, initial_setup
from .pipeline import Ahead, FrameReport, Pipeline
from .publishers import Publishers
from .tf import transform_sender
from .transitions import survive_wrong_transitions

_FOLLOW_PERIOD_S = 0.25
_REPORT_PERIOD_S = 1.0


class RecognizerNode(LifecycleNode):
    """Recognises the objects that its parameters name in every image that it receives.

    A lifecycle node: configuring reads the files and makes the publishers, activating subscribes. Diagnostics come in
    every state. Several can share a process and an executor: each receives in the executor's thread and recognises
    in one of its own.

    :param arguments: the command line's: they tell where the parameter file is.
    :param ros: of rclpy's Node, such as namespace or cli_args.
    :raises ConfigError: the parameters, or files that they name, are not valid.
    """

    def __init__(self, arguments: Sequence[str] = (), name: str = "artrec_node", **ros: Any) -> None:
        super().__init__(name, **ros)
        survive_wrong_transitions(self)
        self._calibrations = Calibrations()
        self._outputs: Publishers | None = None
        self._pipeline: Pipeline | None = None
        self._inputs: Inputs | None = None
        self._problem = ""
        self._waited = False  # at the last report, for what was built and compiled
        self._live = LiveParameters(
            self, initial_setup(self, arguments), self._use, self._images_there, lambda: self._calibrations.camera
        )
        self._diagnostics = Diagnostics(self.get_fully_qualified_name(), time.monotonic())
        of = topics.DIAGNOSTICS
        self._diagnostics_out = self.create_publisher(message_class(of.type), of.name, of.depth)
        steady = Clock(clock_type=ClockType.STEADY_TIME)  # a stopped simulation is something to report
        self.create_timer(_FOLLOW_PERIOD_S, self._follow_publishers, clock=steady)
        self.create_timer(_REPORT_PERIOD_S, self._report, clock=steady)

    def autostart(self) -> None:
        """Configure and activate, unless the parameter `autostart` leaves that to a lifecycle manager.

        :raises ConfigError: the parameters do not fit together.
        """
        if not self._live.setup.node.autostart:
            self.get_logger().info("waiting for a lifecycle manager to configure and activate")
        elif self.trigger_configure() != TransitionCallbackReturn.SUCCESS:
            raise ConfigError(self._problem or "internal error: configuring failed")
        else:
            self.trigger_activate()

    def on_configure(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Read the files and make the publishers."""
        try:
            setup = self._live.read_again()
            tf = transform_sender(self) if setup.node.publish_tf else None
            self._outputs = Publishers(self, setup.targets, tf)
            log = self.get_logger()
            says = log.error, log.info
            asks = self._is_late, self._answered
            self._pipeline = Pipeline(setup, self._calibrations, self._outputs, *says, *asks)
            for line in setup.lacks():
                self.get_logger().warning(line)
        except ArtrecError as error:
            self._problem = one_line(error)
            self.get_logger().error(self._problem)
            self._release()
            return TransitionCallbackReturn.FAILURE
        return super().on_configure(state)

    def on_activate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Subscribe; refused where the recogniser could not be built."""
        pipeline, setup = self._pipeline, self._live.setup
        assert pipeline is not None  # it was configured
        if pipeline.problem:
            self.get_logger().error(pipeline.problem)
            return TransitionCallbackReturn.FAILURE
        self._inputs = Inputs(
            self, setup.node, self.take_camera_info, lambda image: self.take_image(*image), pipeline.look
        )
        names = ", ".join(t.name for t in setup.targets)
        self.get_logger().info(f"looking for {names} in {self._inputs.image.topic}")
        return super().on_activate(state)

    def on_deactivate(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Subscribe to nothing, and show no more markers."""
        self._stop()
        if self._outputs is not None:
            self._outputs.clear()
        return super().on_deactivate(state)

    def on_cleanup(self, state: LifecycleState) -> TransitionCallbackReturn:
        """Give up publishers and models."""
        self._release()
        return super().on_cleanup(state)

    def on_shutdown(self, state: LifecycleState) -> TransitionCallbackReturn:
        """The same, from any state."""
        self._release()
        return super().on_shutdown(state)

    def destroy_node(self) -> None:
        """Also ends the thread that recognises."""
        self._release()
        super().destroy_node()
        self._state_machine.destroy_when_not_in_use()  # rclpy 7.1 forgets it, and with it the node stays in the graph

    def _stop(self) -> None:
        if self._inputs is not None:
            self._inputs.end()  # else the next image would come after what is withdrawn
        if self._pipeline is not None:
            self._pipeline.withdraw()
        if self._inputs is not None:
            self._inputs.close()
            self._inputs = None

    def _release(self) -> None:
        self._stop()
        if self._pipeline is not None:
            self._pipeline.close()
        if self._outputs is not None:
            self._outputs.close()
        self._pipeline = self._outputs = None

    def _use(self, setup: Setup) -> None:
        """Parameters were changed."""
        if self._pipeline is not None:
            self._pipeline.change(setup)

    def take_camera_info(self, msg: Any) -> None:
        """From now on it may hold for images."""
        self._calibrations.receive(msg)

    def take_image(self, msg: Any, received_ns: int, ahead: Ahead | None = None) -> None:
        """Recognise and publish, in the thread of images; whatever the image is like. :param ahead: see `Pipeline`."""
        pipeline = self._pipeline
        try:
            report = pipeline.process(msg, received_ns, ahead) if pipeline is not None else None
        except (ArtrecError, cv2.error) as error:
            self._skip(one_line(error), msg.header.frame_id)
        except Exception as error:  # a fault of this package: it costs one image, not the node
            if self.context.ok():  # else it is the end: nothing can be published any more
                self._skip(one_line(error), msg.header.frame_id)
                self.get_logger().error(traceback.format_exc(), throttle_duration_sec=30.0)
        else:
            if report is not None:
                self.account(report)

    def _is_late(self) -> bool:
        """Whether a newer image waits while one is looked at, or soon will."""
        inputs = self._inputs
        return inputs is not None and inputs.is_late

    def _answered(self) -> None:
        if (inputs := self._inputs) is not None:
            inputs.answered()

    @property
    def is_ready(self) -> bool:
        """Whether images are recognised, and do not wait for what is built and compiled."""
        return self._pipeline is not None and self._pipeline.is_ready

    @property
    def counters(self) -> Counters:
        """What was counted since the node began."""
        return self._diagnostics.counters

    def account(self, report: FrameReport) -> None:
        """Count an image whose results were published."""
        self._diagnostics.image_processed(time.monotonic(), report)
        if self._calibrations.problem and not self._on_plane:
            self.get_logger().warning(f"metric poses are withheld: {self._uncalibrated}", throttle_duration_sec=10.0)
        elif doubt := self._calibrations.doubt:
            self.get_logger().warning(doubt, throttle_duration_sec=10.0)

    def _images_there(self) -> tuple[bool, ...]:
        """Calibrated ones, or not, as far as is known."""
        return (True, False) if self._calibrations.problem else (True,)

    @property
    def _uncalibrated(self) -> str:
        """Why there is no calibration; empty: there is one."""
        problem, inputs = self._calibrations.problem, self._inputs
        return problem if inputs is None else inputs.uncalibrated(problem)

    @property
    def _on_plane(self) -> bool:
        """Whether metric poses need no calibration."""
        return all_on_plane(self._live.setup.targets, self._live.setup.recognizer)

    def _skip(self, reason: str, frame_id: str) -> None:
        self._diagnostics.image_failed(time.monotonic(), reason, frame_id)
        self.get_logger().warning(f"image skipped: {reason}", throttle_duration_sec=5.0)

    def _follow_publishers(self) -> None:
        if self._inputs is not None:
            self._inputs.follow()

    def _report(self) -> None:
        state, header = self._state(), Header(stamp=self.get_clock().now().to_msg())
        if state.getting_ready is not None:
            self.get_logger().info(getting_ready(state.getting_ready), throttle_duration_sec=10.0)
        elif self._waited and self.is_ready:
            self.get_logger().info("ready")
        self._waited = state.getting_ready is not None
        silence_s = self._live.setup.node.no_image_after_s
        self._diagnostics_out.publish(self._diagnostics.report(state, silence_s, time.monotonic(), header))

    def _state(self) -> NodeState:
        problem, inputs = self._uncalibrated, self._inputs
        outputs = self._outputs
        unheard, shared = (tuple(outputs.unheard()), tuple(outputs.shared())) if outputs is not None else ((), ())
        if shared:
            self.get_logger().warning(
                f"{'; '.join(shared)}; give each node a namespace of its own: -r __ns:=/NAME",
                throttle_duration_sec=60.0,
            )
        pipeline = self._pipeline
        early = pipeline.dropped if pipeline is not None else 0
        state = NodeState(
            topic="",
            dropped=early,
            calibration=problem,
            doubt=self._calibrations.doubt,
            unheard=unheard,
            shared=shared,
            active=False,
            getting_ready=pipeline.getting_ready if pipeline is not None else None,
            fault=pipeline.problem if pipeline is not None else "",
            on_plane=self._on_plane,
        )
        if inputs is None:
            return state
        image = inputs.image
        return replace(
            state,
            topic=image.topic,
            publishers=image.publishers,
            incompatible=image.incompatible,
            wrong_type=inputs.wrong_type,
            dropped=inputs.dropped + early,
            lost=image.lost,
            busy_s=inputs.busy_s,
            active=True,
        )
