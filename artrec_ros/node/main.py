"""The executable `artrec_node`."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from typing import TYPE_CHECKING

from ..core.base.errors import ArtrecError, ConfigError
from .stopping import Stop

if TYPE_CHECKING:
    from rclpy.executors import Executor

    from .node import RecognizerNode

_HELP = """Recognises articulated objects in images: subscribes image and camera_info, publishes <object>/poses etc.

example: artrec_node --ros-args --params-file config/aibo.yaml -r image:=/camera/segmentation
"""

MISSING = "ROS 2 is missing ({}); source one, or install artrec_ros with pip"
_SWITCH_S = 1e-4  # an image that comes in must not wait 5 ms, Python's default, for the thread that recognises
_MOST_FAULTS = 100  # in a row


def main(argv: Sequence[str] | None = None) -> int:
    """Run the node until SIGINT or SIGTERM.

    :param argv: arguments without the program's name; ROS' own begin with --ros-args.
    :return: exit code: 0 stopped, 1 failed; 2 wrong usage, for which argparse exits.
    """
    stop = Stop()  # before anything that takes time: the other imports are below for that
    return _run(list(sys.argv[1:] if argv is None else argv), stop)


def _run(arguments: list[str], stop: Stop) -> int:
    try:
        import rclpy.executors
        import rclpy.signals  # noqa: F401
    except ImportError as error:
        return _failed(MISSING.format(error), 1)
    from ..io.base.working_folder import check_working_folder

    try:
        check_working_folder()
        own = _not_ros(arguments)
    except (ArtrecError, RuntimeError) as error:
        return _failed(str(error), 2)
    _refuse_others(own)
    return _serve(arguments, stop)


def _serve(arguments: list[str], stop: Stop) -> int:
    import rclpy
    from rclpy.executors import ExternalShutdownException, SingleThreadedExecutor
    from rclpy.signals import SignalHandlerOptions, install_signal_handlers

    sys.setswitchinterval(_SWITCH_S)
    from ..io.images.decoding import silence_opencv
    from .log_folder import check_log_folder
    from .node import RecognizerNode

    silence_opencv()
    node: RecognizerNode | None = None
    begun = False

    def take_down() -> None:
        if node is not None:
            node.destroy_node()
        rclpy.try_shutdown()

    stop.begin(take_down)
    try:
        check_log_folder(arguments)
        # rclpy's own handlers shut it down beneath whatever goes on, and so wait until that is no more than spinning
        rclpy.init(args=["artrec_node", *arguments], signal_handler_options=SignalHandlerOptions.NO)
        begun = True
        node = RecognizerNode(arguments)
        node.autostart()
        executor = SingleThreadedExecutor(context=node.context)
        executor.add_node(node)
        install_signal_handlers(SignalHandlerOptions.ALL)
        stop.spin()
        _spin(executor, node)
    except ExternalShutdownException:
        return 0
    except Exception as error:
        if stop.asked or (begun and not rclpy.ok()):  # a signal shut rclpy down beneath what was going on
            return 0
        if not isinstance(error, (ArtrecError, RuntimeError)):  # which rclpy raises for bad arguments and files
            raise
        return _failed(str(error), 1)
    finally:
        stop.end()
    return 0


def _failed(reason: str, code: int) -> int:
    print(f"artrec_node: {_one_line(reason)}", file=sys.stderr)
    return code


def _not_ros(arguments: list[str]) -> list[str]:
    """Arguments that are not ROS' own. :raises ArtrecError, RuntimeError: its own are none, or name no file."""
    from rclpy.impl.implementation_singleton import rclpy_implementation
    from rclpy.utilities import remove_ros_args

    from ..io.base.yaml_files import check_size
    from ..io.parameters.sections import MOST_BYTES
    from .parameters import parameter_files

    for file in parameter_files(arguments):
        check_size(file, MOST_BYTES)  # ROS speaks of its parser's source, or is at a large file for minutes
    try:
        return list(remove_ros_args(["artrec_node", *arguments])[1:])
    except rclpy_implementation.UnknownROSArgsError as error:
        raise ConfigError(f"--ros-args: ROS knows no {error}; it knows -r, -p, --params-file, --log-level") from None


def _refuse_others(arguments: list[str]) -> None:
    """Arguments that are not ROS' own: there is --help, and no other."""
    import argparse

    parser = argparse.ArgumentParser("artrec_node", description=_HELP, formatter_class=argparse.RawTextHelpFormatter)
    parser.parse_args(arguments)


def _spin(executor: Executor, node: RecognizerNode) -> None:
    """As rclpy.spin, which a fault in a callback ends: rclpy's own services raise at requests they do not expect.

    :raises Exception: a fault that nothing but faults follow.
    """
    from rclpy.executors import ExternalShutdownException

    faults = 0
    while node.context.ok():
        try:
            executor.spin_once()
            faults = 0
        except ExternalShutdownException:
            raise
        except Exception as error:
            faults += 1
            if faults > _MOST_FAULTS or not node.context.ok():
                raise
            node.get_logger().error(f"a callback failed: {_one_line(str(error))!r}", throttle_duration_sec=5.0)


def _one_line(text: str) -> str:
    return " ".join(text.split())


if __name__ == "__main__":
    sys.exit(main())
