"""Lifecycle transitions that the node's state does not allow."""

from __future__ import annotations

from typing import Any

from rclpy.lifecycle import LifecycleNode

_SHOWN = 60  # letters of a text of unknown length


def survive_wrong_transitions(node: LifecycleNode) -> None:
    """Answer a transition that the node's state does not allow with a refusal, and tell which ones it does.

    rclpy 7.1 raises in the service's callback, and that ends the executor's spin.
    """
    service = node._service_change_state
    answer = service.callback

    def answer_or_refuse(request: Any, response: Any) -> Any:
        try:
            return answer(request, response)
        except RuntimeError:
            asked, machine = request.transition, node._state_machine
            possible = ", ".join(label for _, label, *_ in machine.available_transitions) or "none"
            node.get_logger().warning(
                f"transition {asked.label[:_SHOWN]!r} ({asked.id}) refused: the node is "
                f"{machine.current_state[1]}; possible: {possible}"
            )
            response.success = False
            return response

    service.callback = answer_or_refuse
