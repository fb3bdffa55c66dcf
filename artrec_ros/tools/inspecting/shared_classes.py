"""What `artrec model` and `artrec inspect` say of required components that much else may be taken for."""

from __future__ import annotations

from collections.abc import Iterator

from ...core.model.objects import ObjectModel
from .structure import shortened

_WAY_OUT = "a class of its own that no other component has leaves less to be taken for it"


def shared_classes(model: ObjectModel, label: int = 0) -> Iterator[str]:
    """A line where the required component may be of several classes, or others may be of its own.

    :param label: of components without one of their own; 0: not known.
    """
    required = model.required
    if required.classes:
        listed = "" if model.identities else ", and a list of the 'identities' that exist leaves fewer combinations"
        yield (
            f"the required component '{required.name}' may be of {len(required.classes)} classes: what is of any of "
            f"them may be one, and objects are told less surely; {_WAY_OUT}{listed}"
        )
        return
    own = set(required.labels(label))
    sharing = [c.name for c in model.components if own & set(c.classes.values())]
    if sharing:
        yield (
            f"{shortened(sharing)} may be of the class of the required component '{required.name}': where much is of "
            f"it, some is taken for the object; {_WAY_OUT}"
        )
