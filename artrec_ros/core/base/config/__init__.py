"""Every tunable value, once: default, unit, range and meaning. The node's parameters, the YAML
reader and the tools' options derive from these dataclasses; nothing repeats a default."""

from .image import GREATEST_LABEL, ClassConfig, ImageConfig
from .node import NodeConfig
from .params import param, validate
from .recognition import ObjectConfig, RecognizerConfig
from .tracking import TrackingConfig

__all__ = [
    "GREATEST_LABEL",
    "ClassConfig",
    "ImageConfig",
    "NodeConfig",
    "ObjectConfig",
    "RecognizerConfig",
    "TrackingConfig",
    "param",
    "validate",
]
