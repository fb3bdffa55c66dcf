"""Imports point one way: node and tools on top, then io, then core; core needs numpy, cv2, numba and Python alone.

core/compiled/jit.py alone imports numba; core/tracking.py alone scipy, for assignments.
"""

from __future__ import annotations

import ast
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "artrec_ros"
MODULES = sorted(PACKAGE.rglob("*.py"))

# layer -> the layers of this package that it may import
ALLOWED = {
    "": set(),
    "core": {"core"},
    "io": {"io", "core"},
    "simulation": {"simulation", "io", "core"},
    "node": {"node", "io", "core"},
    "tools": {"tools", "simulation", "io", "core"},
}
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


@pytest.mark.parametrize("path", [p for p in MODULES if layer_of(p) == "core"], ids=name_of)
def test_core_needs_numpy_opencv_and_numba_alone(path: Path) -> None:
    foreign = {name[0] for name in imports(path)} - set(sys.stdlib_module_names)
    extra = {"jit.py": {"numba"}, "tracking.py": {"scipy"}}.get(path.name, set())
    assert foreign <= {"numpy", "cv2", "artrec_ros", *extra}


@pytest.mark.parametrize("path", MODULES, ids=name_of)
def test_ros_and_bags_each_have_one_place(path: Path) -> None:
    used = {name[0] for name in imports(path)}
    if layer_of(path) != "node":
        assert not used & ROS
    if "rosbags" in used:
        assert name_of(path) in ("artrec_ros/io/bags.py", "artrec_ros/io/bag_writer.py")


def test_everything_but_the_node_works_without_ros() -> None:
    """In a process where importing anything of ROS fails."""
    names = [".".join(p.with_suffix("").relative_to(ROOT).parts) for p in MODULES if layer_of(p) != "node"]
    names = [n.removesuffix(".__init__") for n in names if not n.endswith("__main__")]
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
