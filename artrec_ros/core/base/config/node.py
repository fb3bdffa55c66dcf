"""What only the node needs."""

from __future__ import annotations

from dataclasses import dataclass

from .params import param, validate


@dataclass(frozen=True)
class NodeConfig:
    """What only the node needs. Other readers of the same parameter file accept these keys and pass over them."""

    image_transport: str = param("raw", "subscribe image (raw), or image/compressed", choices=("raw", "compressed"))
    qos_reliability: str = param(
        "auto",
        "of the image subscription; auto: what the publishers offer",
        choices=("auto", "reliable", "best_effort"),
    )
    queue_size: int = param(
        3,
        "images that may wait for one that takes long, as long as recognition keeps up with the camera on average; "
        "else, and with 1, the newest only",
        low=1,
        high=100,
    )
    config_dir: str = param("", "folder that relative paths start from; empty: the parameter file's own")
    autostart: bool = param(True, "configure and activate at once; false: wait for a lifecycle manager")
    publish_tf: bool = param(False, "send each object's frame to tf, where tf2_ros is installed")
    marker_lifetime_s: float = param(
        5.0, "RViz removes a marker that was not renewed for so long; 0: never", unit="s", low=0, high=3600
    )
    no_image_after_s: float = param(
        2.0, "diagnostics complain when no image has come for so long", unit="s", low=0.1, high=3600
    )

    def __post_init__(self) -> None:
        validate(self)
