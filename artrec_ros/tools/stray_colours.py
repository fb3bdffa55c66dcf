"""Reference colours that seem to be learned from what is not of their class: few of its pixels have their hue."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

import cv2
import numpy as np
from numpy.typing import NDArray

from ..core.base.config import ImageConfig
from ..core.image.colour_table import is_grey, lone, named
from ..core.image.segmentation import packed
from ..core.learning.colour_learning import Stray
from .colour_samples import Told
from .taken_regions import taken

_FAR_DEG = 60.0  # of hue: as red is from yellow, yellow from green; light and lenses turn hues by less
_FEW = 0.2  # share of a class' pixels: what is shown by more is meant


def strays(samples: Mapping[str, NDArray[np.uint8]], told: Told, image: ImageConfig) -> tuple[Stray, ...]:
    """Of all classes, in their order.

    :param samples: name -> (n, 3) BGR. :param image: what was learned of them. Images are read once more, those alone
        that show a class with such a reference.
    """
    return tuple(stray for name in image.classes if name in samples for stray in _of_class(name, samples, told, image))


def _of_class(name: str, samples: Mapping[str, NDArray[np.uint8]], told: Told, image: ImageConfig) -> Iterator[Stray]:
    ones = [one for one in lone(image.classes[name]) if one.rgb]
    if len(ones) < 2:
        return
    each = replace(image, classes={str(n): replace(one, label=n) for n, one in enumerate(ones, 1)}, background=())
    labels = named(each, packed(samples[name][None])[0])
    shares = np.bincount(labels, minlength=len(ones) + 1)[1:] / max(len(labels), 1)
    bgr = np.array([one.rgb[::-1] for one in ones], np.float32) / 255
    hue = cv2.cvtColor(bgr[None], cv2.COLOR_BGR2HSV)[0, :, 0]  # degrees
    most = int(np.argmax(shares))
    for n in np.flatnonzero(shares < _FEW).tolist():
        far = abs((hue[n] - hue[most] + 180) % 360 - 180) > _FAR_DEG
        if far and not any(is_grey(bgr[k], ones[k].spread, image.noise) for k in (n, most)):
            where = max(taken(told, each, name, n + 1), key=lambda region: region[1], default=(None, 0.0))[0]
            yield Stray(name, _rgb(ones[n].rgb), _rgb(ones[most].rgb), float(shares[n]), where)


def _rgb(values: tuple[int, ...]) -> tuple[int, int, int]:
    r, g, b = values
    return r, g, b
