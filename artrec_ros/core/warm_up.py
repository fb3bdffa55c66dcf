"""Compiled code made ready before the first image, so that it is not late."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import cv2
import numpy as np

from .base.config import RecognizerConfig
from .base.deadline import Deadline
from .constraints.constraint_set import ConstraintSet
from .constraints.intervals import Interval
from .constraints.pairs import PairConstraint
from .flat_stage import FlatStage
from .grouping.packing import pack
from .image.blobs import find_blobs
from .image.image_frame import ImageFrame
from .image.label_field import LabelField
from .model.objects import Component, Marker, ObjectModel
from .model.target import Target

_SIDE_PX = 24


@lru_cache(maxsize=1)
def warm_up_flat_stage() -> None:
    """Recognise a square and a disc once in this process: whatever the objects, the compiled code is the same."""
    square = Marker("square", np.array([[0, 0], [1, 0], [1, 1], [0, 1.0]]), np.zeros(2), np.array([1.0, 0]))
    angle = np.linspace(0, 2 * np.pi, 32, endpoint=False)
    disc = Marker("disc", np.stack([np.cos(angle), np.sin(angle)], axis=1) / 2, np.zeros(2), np.array([1.0, 0]), 0.5)
    model = ObjectModel("warm_up", (Component("base", (square,), required=True), Component("spot", (disc,))))
    box = {"distance_m": Interval(1.0, 3.0)}
    constraints = ConstraintSet(model.name, 0.95, (PairConstraint(("base", "square"), ("spot", "disc"), 9, box, box),))
    labels = np.zeros((3 * _SIDE_PX, 5 * _SIDE_PX), np.uint8)
    labels[_SIDE_PX : 2 * _SIDE_PX, _SIDE_PX : 2 * _SIDE_PX] = 1
    cv2.circle(labels, (7 * _SIDE_PX // 2, 3 * _SIDE_PX // 2), _SIDE_PX // 2, 1, cv2.FILLED)
    config = RecognizerConfig(max_slant_deg=10.0)
    frame, blobs = ImageFrame(LabelField(labels)), find_blobs(labels, {1}, config)
    for profile in ("default", "paper"):
        target = Target(model.name, model, 1, constraints)
        stage = FlatStage((target,), replace(config, profile=profile), ())
        _, rejected, _ = stage.group(frame, stage.align(frame, blobs))
        list(rejected)  # reasons are worked out when they are looked at
    row = np.abs(np.subtract.outer(np.arange(3), np.arange(3))) < 2  # the middle one of three is in the others' way
    pack(np.array([1.0, 1.5, 1.0]), row, 100, Deadline())
