"""How the studio's parameters differ from those of a node that runs, and what of it can be set there."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from ...io.parameters.parameter_file import Setup
from ...io.parameters.specs import Spec
from .ros import Remote


@dataclass(frozen=True)
class Difference:
    """:param here: the studio's value. :param there: the node's; None: it has no such parameter."""

    spec: Spec
    here: Any
    there: Any

    @property
    def is_live(self) -> bool:
        """Whether it can be set while the node runs; else it needs a restart."""
        return self.spec.is_live


def differences(setup: Setup, remote: Remote, node: str) -> list[Difference]:
    """Those that can be set first. :raises SourceError: the node does not answer."""
    specs = setup.specs
    there = remote.values(node, list(specs))
    found = [Difference(s, _plain(setup.value(name)), _there(s, there)) for name, s in specs.items()]
    return sorted((d for d in found if d.here != d.there), key=lambda d: not d.is_live)


def _there(spec: Spec, values: Mapping[str, Any]) -> Any:
    """A node has those for experts only where they were given; else they are as they are by default."""
    return _plain(values.get(spec.name, spec.default if spec.is_expert else None))


def _plain(value: Any) -> Any:
    return list(value) if isinstance(value, tuple) else value


def set_on_node(found: list[Difference], remote: Remote, node: str) -> dict[str, str]:
    """Sets those that can be. Returns those that the node refused, each with its reason.

    :raises SourceError: the node does not answer.
    """
    live = [d for d in found if d.is_live]
    return remote.set(node, {d.spec.name: d.here for d in live}, {d.spec.name: d.spec for d in live})
