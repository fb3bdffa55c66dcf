"""Every tunable value, once: default, unit, range and meaning. The node's parameters, the YAML
reader and the tools' options derive from these dataclasses; nothing repeats a default."""

from .alignment import AlignmentConfig
from .blobs import BlobsConfig
from .constraints import ConstraintsConfig
from .covariance import CovarianceConfig
from .fit import FitConfig
from .grouping import GroupingConfig
from .guesses import GuessesConfig
from .image import GREATEST_LABEL, ClassConfig, ImageConfig
from .node import NodeConfig
from .paper import PaperConfig
from .params import PATHS, param, room, rooms_of, validate, with_values
from .recognition import ObjectConfig, RecognizerConfig
from .search import SearchConfig
from .tracking import TrackingConfig
from .verdict import VerdictConfig
from .votes import VotesConfig

__all__ = [
    "GREATEST_LABEL",
    "PATHS",
    "AlignmentConfig",
    "BlobsConfig",
    "ClassConfig",
    "ConstraintsConfig",
    "CovarianceConfig",
    "FitConfig",
    "GroupingConfig",
    "GuessesConfig",
    "ImageConfig",
    "NodeConfig",
    "ObjectConfig",
    "PaperConfig",
    "RecognizerConfig",
    "SearchConfig",
    "TrackingConfig",
    "VerdictConfig",
    "VotesConfig",
    "param",
    "room",
    "rooms_of",
    "validate",
    "with_values",
]
