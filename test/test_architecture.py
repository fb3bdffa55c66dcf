"""Imports point one way: node and tools on top, then simulation, io, core; within core each room knows only lower ones.

core needs numpy, cv2 and Python alone, but for the compiler (base/jit.py) and scipy (assignment in
tracking and verdict, optimisation in learning and of what looks the same).
"""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "artrec_ros"
MODULES = sorted(PACKAGE.rglob("*.py"))
CORE = [p for p in MODULES if p.is_relative_to(PACKAGE / "core")]

# layer -> the layers of this package that it may import
ALLOWED = {
    "": set(),
    "core": {"core"},
    "io": {"io", "core"},
    "simulation": {"simulation", "io", "core"},
    "node": {"node", "io", "core"},
    "tools": {"tools", "simulation", "io", "core"},
}
# rooms of core, the lowest first: each may import those before it; learning and design stand beside the recogniser
ROOMS = (
    "base", "geometry", "model", "image", "alignment", "constraints", "grouping", "pose", "verdict", "memory",
    "tracking",
)  # fmt: skip
OFFLINE = ("learning", "design")
IO_ROOMS = (
    "base", "images", "messages", "bags", "sources", "results", "objects", "learned", "parameters", "truth",
    "inventory",
)  # fmt: skip
TOP = "(top)"  # the recogniser and its stages, warming up, drawing
ROS = {
    "rclpy", "rcl_interfaces", "diagnostic_msgs", "geometry_msgs", "rosgraph_msgs", "sensor_msgs", "std_msgs",
    "tf2_ros", "visualization_msgs",
}  # fmt: skip


def name_of(path: Path) -> str:
    return path.relative_to(ROOT).as_posix()


def layer_of(path: Path) -> str:
    parts = path.relative_to(PACKAGE).parts
    return parts[0] if len(parts) > 1 else ""


def imports(path: Path) -> Iterator[tuple[str, ...]]:
    """Absolute dotted names of all that a module imports, wherever in it, as tuples."""
    own = list(path.relative_to(ROOT).parts[:-1])
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (tuple(alias.name.split(".")) for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = own[: len(own) - node.level + 1] if node.level else []
            module = [*base, *(node.module.split(".") if node.module else [])]
            yield from (tuple([*module, alias.name]) for alias in node.names)


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_imports_point_one_way(path: Path) -> None:
    layer = layer_of(path)
    assert layer in ALLOWED, f"a new layer: say here what '{layer}' may import"
    used = {name[1] for name in imports(path) if name[0] == "artrec_ros" and (PACKAGE / name[1]).is_dir()}
    assert used <= ALLOWED[layer], f"{layer} imports {sorted(used - ALLOWED[layer])}"


def room_of(parts: tuple[str, ...]) -> str:
    """The room of a module of core, from its path or dotted name below core."""
    return parts[0] if parts and parts[0] in (*ROOMS, *OFFLINE) else TOP


def may_know(room: str) -> set[str]:
    below = {*ROOMS[: ROOMS.index(room) + 1]} if room in ROOMS else {*ROOMS}
    return {*below, *OFFLINE, TOP} if room == TOP else {*below, room}


@pytest.mark.parametrize("path", CORE, ids=name_of)
def test_rooms_know_only_lower_ones(path: Path) -> None:
    room = room_of(path.relative_to(PACKAGE / "core").parts)
    used = {room_of(name[2:]) for name in imports(path) if name[:2] == ("artrec_ros", "core") and len(name) > 2}
    assert used <= may_know(room), f"{room} imports {sorted(used - may_know(room))}"
    if room == TOP:
        assert not used & set(OFFLINE), "what learns is not needed to recognise"


@pytest.mark.parametrize("path", [p for p in MODULES if layer_of(p) == "io"], ids=name_of)
def test_rooms_of_files_know_only_lower_ones(path: Path) -> None:
    room, *inside = path.relative_to(PACKAGE / "io").parts
    assert inside or room == "__init__.py", "every file of io has a room"
    used = {name[2] for name in imports(path) if name[:2] == ("artrec_ros", "io") and len(name) > 2}
    assert not inside or used <= {*IO_ROOMS[: IO_ROOMS.index(room) + 1]}, f"{room} imports {sorted(used)}"


@pytest.mark.parametrize(("layer", "rooms"), [("core", {*ROOMS, *OFFLINE}), ("io", {*IO_ROOMS})])
def test_every_room_says_what_it_is_for(layer: str, rooms: set[str]) -> None:
    folders = {p.parent.name for p in MODULES if p.parent.parent == PACKAGE / layer}
    assert folders == rooms, "a new room: say here which ones it may know"
    for room in folders:
        said = ast.get_docstring(ast.parse((PACKAGE / layer / room / "__init__.py").read_text(encoding="utf-8")))
        assert said and len(said.splitlines()) == 1


@pytest.mark.parametrize("path", CORE, ids=name_of)
def test_core_needs_numpy_opencv_and_numba_alone(path: Path) -> None:
    foreign = {name[0] for name in imports(path)} - set(sys.stdlib_module_names)
    extra = {"jit.py": {"numba"}, "kernel_cache.py": {"llvmlite", "numba"}}
    fits = "view_fit.py", "marked_views.py", "outline_mending.py"
    extra |= dict.fromkeys((*fits, "matching.py", "identity.py", "same_turns.py"), {"scipy"})
    assert foreign <= {"numpy", "cv2", "artrec_ros", *extra.get(path.name, set())}


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_ros_and_bags_each_have_one_place(path: Path) -> None:
    used = {name[0] for name in imports(path)}
    if layer_of(path) != "node":
        assert not used & ROS
    if "rosbags" in used:
        assert name_of(path) in ("artrec_ros/io/bags/reader.py", "artrec_ros/io/bags/writer.py")


def test_files_of_tests_have_names_of_their_own() -> None:
    """Where a folder is no package pytest imports its files by their bare names: two of one name stop the whole run."""
    loose = [p.name for p in (ROOT / "test").rglob("test_*.py") if not (p.parent / "__init__.py").exists()]
    assert sorted(loose) == sorted(set(loose))


def test_everything_but_the_node_works_without_ros() -> None:
    """In a process where importing anything of ROS fails."""
    names = [".".join(p.with_suffix("").relative_to(ROOT).parts) for p in MODULES if layer_of(p) != "node"]
    names = [n.removesuffix(".__init__") for n in names if not n.endswith("__main__")]
    if find_spec("nicegui") is None:  # an extra, which these pages alone need
        names = [n for n in names if not n.startswith("artrec_ros.tools.studio_pages.")]
    assert "artrec_ros.core.recognizer" in names and "artrec_ros.tools.main" in names
    program = f"""
import importlib, sys

class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] in {ROS!r}:
            raise ModuleNotFoundError("no ROS here: " + name, name=name)

sys.meta_path.insert(0, Blocked())
sys.path.insert(0, {str(ROOT)!r})
for name in {names!r}:
    importlib.import_module(name)
from artrec_ros.node.main import main
print("exit code without ROS:", main([]))
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    assert "exit code without ROS: 1" in done.stdout
    assert "ROS 2 is missing" in done.stderr and len(done.stderr.splitlines()) == 1, done.stderr
