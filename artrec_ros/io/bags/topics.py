"""Which topics of a bag hold the images and their calibration, and what their messages say."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from typing import Any

from ...core.base.errors import ImageError, SourceError, UnreadableError
from ...core.geometry.camera import Camera
from ..images.cameras import camera_from_info
from ..images.decoding import Image, decode_compressed, decode_image
from .reader import Bag, Topic

IMAGE_TYPES = ("sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage")
INFO_TYPE = "sensor_msgs/msg/CameraInfo"

Report = Callable[[str], None]
"""Called with one line for whatever the user should know but that stops nothing."""


def camera_info_topic(image_topic: str) -> str:
    """The calibration's topic beside an image topic, as image_transport has it."""
    base = re.sub(r"/compressed$", "", image_topic)
    namespace, slash, _ = base.rpartition("/")
    return f"{namespace}{slash}camera_info"


def decode_message(content: Any) -> Image:
    """The pixels of an Image or CompressedImage message of any client library. :raises ImageError: if unfit."""
    c = content
    if hasattr(c, "format"):
        return decode_compressed(c.format, c.data)
    return decode_image(c.encoding, c.height, c.width, c.step, bool(c.is_bigendian), c.data)


def camera_of(info: Any, rectified: bool = False) -> Camera:
    """The camera of a CameraInfo message, whose fields ROS 1 spells in capitals.

    :param rectified: the images beside it are: P holds for them.
    :raises ConfigError: if it is unfit.
    """
    K, D, P = (info.k, info.d, info.p) if hasattr(info, "k") else (info.K, info.D, info.P)
    roi = info.roi
    return camera_from_info(
        info.width, info.height, K, D, info.distortion_model, info.header.frame_id,
        (info.binning_x, info.binning_y), (roi.x_offset, roi.y_offset, roi.width, roi.height),
        P if rectified else None,
    )  # fmt: skip


def choose_topic(bag: Bag, topic: str | None, image_kind: str | None, report: Report) -> str:
    """The image topic: the one that is named, else the only one, else the only one that fits the image kind.

    :raises SourceError: if that tells none; it lists what there is.
    """
    images = [t for t in bag.topics.values() if t.msgtype in IMAGE_TYPES]
    if topic is not None:
        if topic not in bag.topics:
            raise SourceError(f"{bag.path}: no topic '{topic}'. {listed(bag, images)}")
        if topic not in [t.name for t in images]:
            msgtype = bag.topics[topic].msgtype
            raise SourceError(f"{bag.path}: '{topic}' is {msgtype}, no image. {listed(bag, images)}")
        return topic
    if not images:
        raise UnreadableError(f"{'; '.join(bag.problems) or bag.path}: no image topic. {listed(bag, images)}")
    images += [t for t in bag.lost if t.msgtype in IMAGE_TYPES]
    if len(images) == 1:
        return images[0].name
    fitting = [t.name for t in images if _fits(bag, t, image_kind)]
    if len(fitting) != 1:
        found = "; ".join(bag.problems) or bag.path
        raise SourceError(f"{found}: several image topics, choose one with --topic. {listed(bag, images)}")
    kind = f"image.kind '{image_kind}'"
    report(f"{bag.path}: topic {fitting[0]}: of {len(images)} image topics the only one that fits {kind}")
    return fitting[0]


def choose_info_topic(bag: Bag, topic: str | None, image_topic: str) -> tuple[str, bool]:
    """The calibration's topic, the one that is named, else the one beside the images', and whether it is there.

    :raises SourceError: the one that is named is not, or holds something else.
    """
    name = topic or camera_info_topic(image_topic)
    found = bag.topics.get(name)
    if topic and found is None:
        raise SourceError(f"{bag.path}: no topic '{topic}'. {listed(bag)}")
    if topic and found is not None and found.msgtype != INFO_TYPE:
        raise SourceError(f"{bag.path}: '{topic}' is {found.msgtype}, no calibration ({INFO_TYPE}). {listed(bag)}")
    return name, found is not None and found.msgtype == INFO_TYPE


def _fits(bag: Bag, topic: Topic, kind: str | None) -> bool:
    """Whether the first image of a topic has the channels that this kind of image has, or may have: those of a damaged
    file cannot be read, and another topic is not taken in silence for theirs."""
    message = next(bag.messages([topic.name]), None)
    if message is None or kind is None:
        return kind is not None and topic.count > 0
    try:
        return decode_message(bag.parse(message)).ndim == (2 if kind == "labels" else 3)
    except ImageError:
        return False


def listed(bag: Bag, images: Sequence[Topic] = ()) -> str:
    """What there is: the image topics, or else all topics, the first few."""
    topics = sorted(images or bag.topics.values())
    if not topics:
        return "It holds no topics"
    names = ", ".join(f"{t.name} ({t.msgtype}, {t.count})" for t in topics[:8])
    more = f" and {len(topics) - 8} more" if len(topics) > 8 else ""
    return f"{'Image topics' if images else 'Topics'}: {names}{more}"
