"""One mistake put into what is otherwise a good file."""

import copy
from typing import Any


def changed(content: Any, place: str, value: Any) -> Any:
    """A copy with the value at a place like "pairs/0/first" changed; None takes it away."""
    content = copy.deepcopy(content)
    *groups, key = [int(part) if part.isdigit() else part for part in place.split("/")]
    inner = content
    for group in groups:
        inner = inner[group]
    if value is None:
        del inner[key]
    else:
        inner[key] = value
    return content
