"""A lamp of two flat markers, to tune on: found in the image plane, in a millisecond or two."""

from __future__ import annotations

from pathlib import Path

OBJECT = """
format: artrec_object/1
name: lamp
markers:
  house:
    outline: [[-0.04, -0.03], [0.04, -0.03], [0.04, 0.01], [0.0, 0.03], [-0.04, 0.03]]
    axis: [[-0.04, 0.0], [0.04, 0.0]]
components:
  foot: {required: true, markers: {house: {pose: {xyz: [0, 0, 0]}}}}
"""
PARAMETERS = """\
# a lamp on a bench
/**:
  ros__parameters:
    objects: [lamp]
    lamp:
      object_file: lamp.yaml   # beside this file
      label: 2
    image: {kind: labels}
    recognizer:
      whole_object: false
      min_match: 0.8         # share of the outline
"""


def write_lamp(folder: Path) -> Path:
    """The parameter file, with its object file beside it."""
    (folder / "lamp.yaml").write_text(OBJECT)
    (folder / "params.yaml").write_text(PARAMETERS)
    return folder / "params.yaml"
