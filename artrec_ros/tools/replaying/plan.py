"""What a replay or a search is: the same sources, parameters and options give the same results, so it can go on."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from ... import __version__
from ...core.base.errors import SourceError
from ...io.base.whole_files import write_whole
from ...io.parameters.parameter_file import Setup

PLAN_FILE = "replay.json"
_FORMAT = "artrec_replay/1"


def plan_of(setup: Setup, sources: Sequence[Path], options: Mapping[str, Any]) -> dict[str, Any]:
    """As plain values; of files what they are, however their paths are spelled.

    :param options: all that results depend on besides.
    """
    paths = [path.resolve() for path in sources]
    files = {key: str(Path(str(setup.resolved[key])).resolve()) for key in _file_keys(setup)}
    return {
        "format": _FORMAT,
        "version": __version__,
        "options": dict(options),
        "sources": [str(path) for path in paths],
        "contents": {str(path): _state(path) for path in paths},
        "parameters": {**setup.resolved, **files},
        "files": {path: digest(Path(path).read_bytes()) for path in sorted(set(files.values()))},
    }


def write_plan(path: Path, plan: Mapping[str, Any]) -> None:
    write_whole(path, json.dumps(plan, indent=1) + "\n")


def check_plan(path: Path, plan: Mapping[str, Any]) -> None:
    """Whether what was begun in a folder is this. :raises SourceError: it is not; it says what differs."""
    folder = path.parent
    try:
        begun = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        begun = None
    way_out = "choose another folder, or --overwrite"
    if not isinstance(begun, dict) or begun.get("format") != _FORMAT:
        raise SourceError(f"{folder}: holds results already; {way_out}")
    difference = next(_differences(begun, json.loads(json.dumps(plan))), None)
    if difference:
        raise SourceError(f"{folder}: holds other results: {difference}; {way_out}")


def _differences(before: Mapping[str, Any], now: Mapping[str, Any]) -> Iterator[str]:
    for group, new in now.items():
        old = before.get(group)
        if not isinstance(new, dict) or not isinstance(old, dict):
            if old != new:
                yield f"its {group} was {_shown(old)}, not {_shown(new)}"
            continue
        for key in sorted({*old, *new}):
            if old.get(key) != new.get(key) and group == "options":
                yield _option(key, old.get(key), new.get(key))
            elif old.get(key) != new.get(key):
                was = f"was {_shown(old.get(key))}, not {_shown(new.get(key))}"
                yield f"{key} {'has changed since' if group in ('contents', 'files') else was}"


_OPTIONS = {
    "camera": "--camera-info",
    "start_offset_s": "--start-offset",
    "playback_duration_s": "--playback-duration",
    "rate_hz": "--rate",
    "video": "--no-video",
    "limits": "--limit",
    "timing": "--no-timing",
    "image_kind": "image.kind",
    "rectified": "image.rectified",
}  # that are called otherwise than in a plan


def _option(key: str, old: Any, new: Any) -> str:
    name = _OPTIONS.get(key, f"--{key.replace('_', '-')}")
    if isinstance(old, bool) or isinstance(new, bool):
        return f"{name} was {'' if bool(old) != name.startswith('--no-') else 'not '}given"
    if key in ("camera", "search", "truth"):  # whose content is kept
        return f"{name} was another one"
    words = {"None": "all", "0": "none"} if key == "images" else {"None": "not given", "": "not given"}
    was, now = (words.get(text, text) for text in map(_shown, (old, new)))
    return f"{name} was {was}, now {now}"


def _shown(value: Any) -> str:
    text = ", ".join(map(str, value)) if isinstance(value, list) else str(value)
    return text if len(text) <= 80 else text[:77] + "..."


def _file_keys(setup: Setup) -> list[str]:
    """The parameters that name object and constraint files."""
    keys = [f"{t.name}.{kind}" for t in setup.targets for kind in ("object_file", "constraint_file")]
    return [key for key in keys if setup.resolved.get(key)]


def _state(path: Path) -> str:
    """Changes when a file is added, removed or written to."""
    files = sorted(p for p in path.rglob("*") if p.is_file()) if path.is_dir() else [path]
    states = [(str(f.relative_to(path.parent)), f.stat().st_size, f.stat().st_mtime_ns) for f in files]
    return digest(json.dumps(states).encode())


def digest(data: bytes) -> str:
    """Tells contents apart."""
    return hashlib.sha256(data).hexdigest()[:16]
