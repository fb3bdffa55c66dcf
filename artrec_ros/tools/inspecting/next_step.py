"""What is not there yet because a later step makes it: no problem, but what to do next."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Sequence
from pathlib import Path

from ...io.inventory.contents import Item, Supplement
from ...io.learned.annotations import Annotations
from ...io.parameters.parameter_file import Setup


def next_steps(items: Sequence[Item], images: Path | None = None) -> Iterator[str]:
    """The command that learns the colours of each parameter file that has classes and as yet no colours.

    :param images: where annotated images lie; None: beside each file.
    """
    marked = [str(i.path) for i in items if isinstance(i.content, Annotations)] or ["COCO.json"]
    more = [str(i.path) for i in items if isinstance(i.content, Supplement)]
    for item in items:
        if isinstance(item.content, Setup) and item.content.image.is_uncoloured:
            files = [word for path in (str(item.path), *more) for word in ("--params-file", path)]
            where = [] if images is None else ["--images", str(images)]
            command = ["artrec", "learn-colours", "--annotations", *marked, *files, *where, "-o", "colours.yaml"]
            classes = ", ".join(item.content.image.classes)
            yield (
                f"{item.path} has no colours yet for {classes}: {shlex.join(command)} learns them by marked images "
                "(docs/colours.md); give colours.yaml as a further --params-file from then on"
            )
