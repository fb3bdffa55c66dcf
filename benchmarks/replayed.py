"""What the scoring scripts are given: a folder of camera frames, and a replay of it."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any


def folder_and_objects(description: str) -> tuple[Path, dict[str, list[dict[str, Any]]]]:
    """The arguments `folder` and `detections`: the folder, and each image's objects by file name."""
    parser = argparse.ArgumentParser(description=description, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=Path)
    parser.add_argument("detections", type=Path)
    args = parser.parse_args()
    lines = [json.loads(line) for line in args.detections.read_text(encoding="utf-8").splitlines()]
    return args.folder, {Path(line["frame"]).name: line.get("objects", []) for line in lines}
