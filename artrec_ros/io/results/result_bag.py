"""A bag of a source's images with all that the node would have said of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from ...core.base.errors import ImageError
from ...core.model.target import Target
from ..bags.recovery import RawMessage
from ..bags.writer import BagWriter
from ..base.yaml_files import read_bytes
from ..images.headers import grey_bits_of, orientation_of, transport_format
from ..messages import node_topics
from ..messages.detection_messages import Message, header, object_frames
from ..messages.marker_messages import MarkerScene
from ..messages.object_messages import OBJECT_MAKERS
from ..sources.bag_source import BagSource
from ..sources.frames import Frame, Source
from ..sources.opening import FolderSource
from .journal import Recognised


class ResultBag:
    """A bag that is being written; a context manager.

    A bag's images and calibrations are copied as they are, those of a folder go to the node's input topics: PNG and
    JPEG as they are to image/compressed. Results have the node's topics, the overlay is compressed. Objects' frames are
    on /tf whether the node would send them or not: it is what viewers draw poses by. Messages are recorded when their
    image was: in a folder, at its stamp.
    """

    def __init__(self, path: Path, storage: str, source: Source, targets: Sequence[Target]) -> None:
        """:raises SourceError: `path` exists."""
        self._writer = BagWriter(path, storage, packed=storage == "mcap")
        self._copies = _copies(source)
        self._names = [t.name for t in targets]
        self._scene = MarkerScene(targets)

    def __enter__(self) -> ResultBag:
        self._writer.__enter__()
        return self

    def __exit__(self, *raised: object) -> None:
        self._writer.__exit__(*raised)

    def add(self, frame: Recognised, picture: NDArray[np.uint8]) -> None:
        """The source's next frame and its overlay. :raises OSError: the bag cannot be written."""
        log_ns, frame_id = next(self._copies)(self._writer)
        if frame.result is None:
            return
        detections = frame.result.detections
        header_of = partial(header, frame.stamp_ns)
        for name in self._names:
            own = [d for d in detections if d.object == name]
            for topic, make in OBJECT_MAKERS.items():
                for message in make(own, frame_id, header_of):
                    self._writer.write(f"/{topic.of(name)}", log_ns, message)
        if frames := object_frames(detections, frame_id, header_of):
            self._writer.write(node_topics.TF.name, log_ns, Message(node_topics.TF.type, {"transforms": frames}))
        markers = self._scene.update(detections, frame_id, header_of)
        if markers.fields["markers"]:
            self._writer.write(f"/{node_topics.MARKERS.name}", log_ns, markers)
        self._writer.write_jpeg(f"/{node_topics.OVERLAY.name}/compressed", log_ns, frame_id, picture)


Copy = Callable[[BagWriter], tuple[int, str]]
"""Writes an image and what comes before it, at the end behind it, too; tells when it was recorded, and its frame_id."""


def _copies(source: Source) -> Iterator[Copy]:
    """A copy for each frame of a source, in order."""
    if isinstance(source, BagSource):
        image: list[RawMessage] = []  # with what comes before it
        waiting: list[RawMessage] = []
        for message in source.messages():
            waiting.append(message)
            if message.topic == source.topic:
                if image:
                    yield partial(_copy_messages, source, image)
                image, waiting = waiting, []
        if image:  # what comes behind the last one may be its calibration
            yield partial(_copy_messages, source, image + waiting)
    elif isinstance(source, FolderSource):
        for frame, (_, path) in zip(source, source.files, strict=True):
            yield partial(_copy_frame, frame, path)
    else:
        for frame in source:
            yield partial(_copy_frame, frame, None)


def _copy_messages(source: BagSource, waiting: Sequence[RawMessage], writer: BagWriter) -> tuple[int, str]:
    log_ns, frame_id = 0, ""
    for message in waiting:
        is_image = message.topic == source.topic
        log_ns = message.log_ns if is_image else log_ns
        try:
            writer.write_raw(message.topic, message.log_ns, message.msgtype, source.bag.cdr(message))
            frame_id = source.bag.parse(message).header.frame_id if is_image or not frame_id else frame_id
        except ImageError:  # the replay has told of it
            continue
    return log_ns, frame_id


def _copy_frame(frame: Frame, path: Path | None, writer: BagWriter) -> tuple[int, str]:
    """:param path: the image's file, whose bytes are copied; None: it has none of its own."""
    frame_id = frame.camera.frame_id if frame.camera else ""
    if frame.camera is not None:
        writer.write_camera(f"/{node_topics.CAMERA_INFO.name}", frame.stamp_ns, frame.camera)
    if frame.image is None:  # the replay has told why
        return frame.stamp_ns, frame_id
    data = read_bytes(path) if path is not None else b""
    # nobody turns a message's image, and whoever decodes grey of few bits spreads it
    as_it_is = orientation_of(data) == 1 and grey_bits_of(data) >= 8
    image_format = transport_format(data) if as_it_is else None
    if image_format is None:
        writer.write_image(f"/{node_topics.IMAGE.name}", frame.stamp_ns, frame_id, frame.image)
    else:
        writer.write_encoded(f"/{node_topics.COMPRESSED.name}", frame.stamp_ns, frame_id, image_format, data)
    return frame.stamp_ns, frame_id
