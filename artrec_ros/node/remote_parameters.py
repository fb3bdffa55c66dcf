"""Parameters of recogniser nodes that run elsewhere: which nodes there are, what they have, and setting them."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

from rcl_interfaces.msg import ParameterType
from rcl_interfaces.srv import GetParameters, ListParameters, SetParameters
from rclpy.parameter import parameter_value_to_python

from ..core.base.errors import SourceError
from ..io.parameters.specs import Spec
from .graph import Graph
from .parameters import to_parameter

_KNOWN_BY = ("objects", "image.kind", "recognizer.profile")  # what no other node has
_GET, _LIST, _SET = "/get_parameters", "/list_parameters", "/set_parameters"
_GET_TYPE = "rcl_interfaces/srv/GetParameters"
_PATIENCE_S = 5.0
_KNOWN_S, _DISCOVERED_S = 1.0, 5.0  # age of a graph in which others are mostly known, and surely
_TURN_S = 0.2


class RemoteParameters:
    """Asks and sets through a graph; each call waits for answers."""

    def __init__(self, graph: Graph) -> None:
        self._graph = graph

    def nodes(self) -> list[str]:
        """Full names of the recogniser nodes: those with its parameters, whatever they are called. Waits for them where
        the graph is so young that it may not know of them yet."""
        time.sleep(max(0.0, _KNOWN_S - self._graph.age_s))
        while not (found := self._known_nodes()) and self._graph.age_s < _DISCOVERED_S:
            time.sleep(_TURN_S)
        return found

    def _known_nodes(self) -> list[str]:
        services = self._graph.node.get_service_names_and_types()
        names = [name.removesuffix(_GET) for name, types in services if _GET_TYPE in types and name.endswith(_GET)]
        request = GetParameters.Request(names=list(_KNOWN_BY))
        answers = self._graph.answers([(GetParameters, name + _GET, request) for name in names], _PATIENCE_S)
        return sorted(
            name
            for name, answer in zip(names, answers, strict=True)
            if answer is not None
            and len(answer.values) == len(_KNOWN_BY)  # of names that it lacks rclpy tells none
            and all(v.type != ParameterType.PARAMETER_NOT_SET for v in answer.values)
        )

    def values(self, node: str, names: Sequence[str]) -> dict[str, Any]:
        """What a node has of these; a parameter that it does not have is left out. :raises SourceError: no answer."""
        there = set(self._one(ListParameters, node, _LIST, ListParameters.Request()).result.names)
        names = [name for name in names if name in there]
        answer = self._one(GetParameters, node, _GET, GetParameters.Request(names=names))
        values = {name: parameter_value_to_python(v) for name, v in zip(names, answer.values, strict=False)}
        return {name: _plain(value) for name, value in values.items() if value is not None}

    def set(self, node: str, values: Mapping[str, Any], specs: Mapping[str, Spec]) -> dict[str, str]:
        """Sets parameters, each for itself, and those refused once more when others were taken: two that must fit
        together may fit only then. Returns those refused, with the node's reason.

        :raises SourceError: the node does not answer.
        """
        left, refused = dict(values), dict.fromkeys(values, "")
        while left:
            parameters = [to_parameter(specs[name], value).to_parameter_msg() for name, value in left.items()]
            answer = self._one(SetParameters, node, _SET, SetParameters.Request(parameters=parameters))
            results = dict(zip(left, answer.results, strict=False))
            refused = {name: r.reason or "no reason given" for name, r in results.items() if not r.successful}
            if len(refused) == len(left):
                break
            left = {name: left[name] for name in refused}
        return refused if left else {}

    def _one(self, kind: type, node: str, service: str, request: Any) -> Any:
        (answer,) = self._graph.answers([(kind, node + service, request)], _PATIENCE_S)
        if answer is None:
            raise SourceError(f"node {node} does not answer within {_PATIENCE_S:g} s; it may have ended")
        return answer


def _plain(value: Any) -> Any:
    """Arrays as lists."""
    return value if isinstance(value, (str, bool, int, float)) else list(value)
