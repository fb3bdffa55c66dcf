"""`artrec model` as users call it, and objects that it looks at."""

import argparse
from pathlib import Path

from artrec_ros.core.design.ambiguity import find_ambiguities
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.tools import model
from artrec_ros.tools.inspecting.model_report import advice

OBJECTS = Path(__file__).parents[2] / "config" / "objects"

QUADRUPED = OBJECTS / "quadruped.yaml"

TOY = """
format: artrec_object/1
name: toy
markers:
  bar: {rectangle: {width: 0.1, height: 0.02}}
  flag:
    outline: [[-0.05, -0.02], [0.05, -0.02], [0.05, 0.0], [-0.01, 0.0], [-0.01, 0.03], [-0.05, 0.03]]
    axis: [[0, 0], [1, 0]]
components:
  base: {required: true, markers: {bar: {pose: {xyz: [0, 0, 0]}}}, body: {boxes: [{size: [0.2, 0.2, 0.1]}]}}
  arm: {label: 5, markers: {flag: {pose: {}}}, body: {label: 5, boxes: [{xyz: [0, 0, -1], size: [1, 1, 1]}]}}
  lid: {markers: {bar: {pose: {xyz: [1, 0, 0]}}}}
"""


def run(*arguments):
    parser = argparse.ArgumentParser()
    model.add_parser(parser.add_subparsers())
    args = parser.parse_args(["model", *map(str, arguments)])
    return args.run(args)


def advice_on(folder, text, camera=None, distance_m=None, labels=None):
    """What is said of an object file of this text."""
    (path := folder / "object.yaml").write_text(text)
    return advice(find_ambiguities(load_object(path, labels or {})), camera, distance_m)


ONE_MARKER = """
format: artrec_object/1
name: sign
markers: {plate: {outline: [[0, 0], [0.1, 0], [0, 0.1]], axis: [[0, 0], [0.1, 0]]}}
components: {plate: {required: true, markers: {plate: {pose: {xyz: [0, 0, 0]}}}}}
"""
