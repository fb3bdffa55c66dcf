"""What reference colours make of samples that are known: what they are worth, and what each is taken for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from ..base.config import ImageConfig
from ..image.colour_table import named, shares
from ..image.segmentation import packed

Samples = Mapping[str, NDArray[np.uint8]]
"""Name -> (n, 3) BGR; names that are no class are background."""


def worth(counted: Samples, image: ImageConfig) -> float:
    """Mean logarithm of the shares whose label is right: of each class, and of each background. What lies beside
    markers is little of an image, but what is lost there are outlines, which labels make, whatever colours share."""
    told = _each(counted, named(image, _codes(counted)))
    own = {name: cls.label for name, cls in image.classes.items()}
    right = [np.mean(labels == own.get(name, 0)) for name, labels in told.items()]
    return float(np.mean(np.log(np.maximum(right, 1e-3))))


def confusion(samples: Samples, image: ImageConfig) -> dict[str, dict[str, float]]:
    """As of `colour_learning.Learned`."""
    names = {cls.label: name for name, cls in image.classes.items()} | {0: "unknown"}
    shared = {names[label]: _each(samples, share) for label, share in shares(image, _codes(samples)).items()}
    return {name: {other: float(of[name].mean()) for other, of in shared.items() if of[name].any()} for name in samples}


def speaks(name: str, shares: Mapping[str, float], votes: Sequence[float]) -> bool:
    """Whether what is told of a class' samples speaks for its objects by half of what it should, or more.

    :param shares: as of `confusion`. :param votes: as of `VotesConfig`.
    """
    own, unknown, other = votes
    right, rest = shares.get(name, 0.0), shares.get("unknown", 0.0)
    return own * right + unknown * rest + other * (1 - right - rest) >= own / 2


def _codes(samples: Samples) -> NDArray[np.uint16]:
    """(n,) the 16-bit colours of all samples."""
    return packed(np.concatenate([*samples.values()])[None])[0]


def _each(samples: Samples, told: NDArray) -> dict[str, NDArray]:
    """What is told (n,) of all samples, by name."""
    ends = np.cumsum([len(colours) for colours in samples.values()])[:-1]
    return dict(zip(samples, np.split(told, ends), strict=True))
