"""Stamp and frame of a serialised message that begins with a header, without the rest, which of an image is large."""

from __future__ import annotations

import struct
from typing import NamedTuple

_ENCAPSULATION = 4  # bytes before a message of ROS 2; the second one says in which order bytes are
_SEQ = 4  # bytes of a header's number in ROS 1


class Head(NamedTuple):
    """:param stamp_ns: of the header; where it was never set, the time of recording.
    :param end: where the stamp ends in the message, in bytes.
    """

    stamp_ns: int
    frame_id: str
    end: int


def head_of(data: bytes, log_ns: int, ros1: bool = False) -> Head:
    """Of a message that ends too early, what can be read; who decodes it says what is wrong with it.

    :param data: the message. :param log_ns: when it was recorded.
    """
    start = _SEQ if ros1 else _ENCAPSULATION
    order = "<" if ros1 or data[1:2] != b"\0" else ">"
    end = start + 8
    try:
        sec, nanosec, length = struct.unpack_from(f"{order}{'I' if ros1 else 'i'}II", data, start)
    except struct.error:
        return Head(log_ns, "", end)
    name = data[end + 4 : end + 4 + length].rstrip(b"\0").decode("utf-8", "replace")
    return Head((sec * 10**9 + nanosec) or log_ns, name, end)
