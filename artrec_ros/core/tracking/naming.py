"""What tracks are called: their numbers, and which one of several like objects each is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from ..base.config import SightingsConfig
from .matching import assign
from .names import Numbers, identified, remembered, same_by_name
from .tracks import Tracks

_SAME = 0.5  # probability from which a newcomer is an object that is lost
_NAMED = 0.5  # probability from which an object that is not seen keeps its identity from others


def found_again(
    tracks: Tracks, here: set[int], told: Sequence[int], config: SightingsConfig
) -> tuple[Tracks, set[int]]:
    """Who is told of for the first time, and has the name of an object that is not seen where it should be, is this
    object, where a name occurs but once: it bounced, was carried, or was out of sight for long; in another scene, too.

    :param here: rows of all that are seen. :param told: of those that are told of.
    :return: the tracks, and the rows whose ids and names others have now.
    """
    ids, fits = list(tracks.ids), list(tracks.identities)
    new = [row for row in told if ids[row] is None]
    lost = [row for row in range(len(tracks)) if row not in here and ids[row] is not None]
    if not new or not lost:
        return tracks, set()
    known = tracks.are_told & np.isin(np.arange(len(tracks)), list(here))
    there = tracks.existence.probability
    named_by_now = identified(tracks.names, fits, known, there, config.misnamed)
    same = same_by_name(tracks.names, named_by_now, there, new, lost)
    found = {new[n]: lost[k] for n, k in assign(_SAME - same).items()}
    for row, before in found.items():
        ids[row], ids[before] = ids[before], None
        fits[row], fits[before] = remembered(fits[row], fits[before], config.identity_memory), None
    return replace(tracks, ids=tuple(ids), identities=tuple(fits)), set(found.values())


def with_names(
    tracks: Tracks, told: Sequence[int], numbers: Numbers, in_doubt: bool, config: SightingsConfig
) -> Tracks:
    """The same with numbers for those that are told of, and which one each is.

    :param told: rows. :param numbers: that are given so far; the new ones are noted there.
    :param in_doubt: whether those count, too, that are not seen but likely to be there.
    """
    ids = list(tracks.ids)
    numbers.meet(tracks.names[row] for row in told)
    for row in told:
        number = ids[row]
        if number is None:
            ids[row] = numbers.new(tracks.names[row])
        else:
            numbers.keep(tracks.names[row], number)
    there = tracks.existence.probability
    likely = (there >= _NAMED) & in_doubt
    likely[list(told)] = True
    identities = identified(tracks.names, tracks.identities, likely, there, config.misnamed)
    return replace(tracks, ids=tuple(ids), identities=identities)
