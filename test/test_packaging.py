"""What is shipped, where it is found, and that the files which describe the package agree."""

from __future__ import annotations

import ast
import importlib.util
import json
import os
import re
import runpy
import shutil
import subprocess
import sys
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import pytest
import yaml

import artrec_ros
from artrec_ros.core.base.config import NodeConfig
from artrec_ros.core.base.errors import ConfigError
from artrec_ros.io.base.shared_files import resolve_path, share_directory
from artrec_ros.io.messages.node_topics import OUTPUTS

ROOT = Path(__file__).resolve().parents[1]


@pytest.fixture
def described(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    return described_by_setup(monkeypatch)


def described_by_setup(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    """What setup.py gives to setuptools.setup."""
    setuptools = pytest.importorskip("setuptools")
    given: dict[str, Any] = {}
    monkeypatch.setattr(setuptools, "setup", lambda **keywords: given.update(keywords))
    monkeypatch.chdir(ROOT)
    runpy.run_path("setup.py")
    return given


def test_versions_licences_and_names_agree(described: dict[str, Any]) -> None:
    manifest = ET.parse(ROOT / "package.xml").getroot()
    assert manifest.get("format") == "3"
    assert manifest.findtext("name") == described["name"] == "artrec_ros"
    assert manifest.findtext("version") == described["version"] == artrec_ros.__version__
    assert manifest.findtext("license") == described["license"] == "Apache-2.0"
    assert "Apache License" in (ROOT / "LICENSE").read_text()
    assert manifest.findtext("export/build_type") == "ament_python"
    changes = re.findall(r"^(\S+).*\n---", (ROOT / "CHANGELOG.rst").read_text(), re.MULTILINE)
    assert changes[0] in ("Forthcoming", artrec_ros.__version__)


def test_every_file_that_users_need_is_shipped_once(described: dict[str, Any]) -> None:
    targets = [f"{folder}/{Path(f).name}" for folder, files in described["data_files"] for f in files]
    assert len(targets) == len(set(targets))
    shipped = {f"share/artrec_ros/{p.relative_to(ROOT)}" for d in ("config", "launch") for p in _files(ROOT / d)}
    assert len(shipped) > 5
    assert set(targets) - shipped == {
        "share/ament_index/resource_index/packages/artrec_ros",
        "share/artrec_ros/package.xml",
    }
    assert shipped <= set(targets)


def _files(folder: Path) -> list[Path]:
    return [p for p in folder.rglob("*") if p.is_file() and "__pycache__" not in p.parts]


@pytest.mark.parametrize(("command", "there"), [("bdist_wheel", True), ("editable_wheel", True), ("install", False)])
def test_what_pip_installs_is_found_where_ros2_looks_for_executables(
    command: str, there: bool, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """In lib/artrec_ros, where colcon has the executables put by setup.cfg and pip by launchers."""
    monkeypatch.setattr(sys, "argv", ["setup.py", command])
    described = described_by_setup(monkeypatch)
    files = dict(described["data_files"]).get("lib/artrec_ros", [])
    executables = {s.partition("=")[0].strip() for s in described["entry_points"]["console_scripts"]}
    assert {Path(f).name for f in files} == (executables if there else set())
    prefix = tmp_path / "a prefix"
    for folder in ("bin", "lib/artrec_ros"):
        (prefix / folder).mkdir(parents=True)
    for file in files:
        name = Path(file).name
        shutil.copy(ROOT / file, prefix / "lib/artrec_ros")  # with its mode, as wheels keep it
        (prefix / "bin" / name).write_text(f"#!/bin/sh\nprintf '{name}:%s;' \"$@\"\nexit 3\n")
        (prefix / "bin" / name).chmod(0o755)
        done = subprocess.run(
            [prefix / "lib/artrec_ros" / name, "a b", "--ros-args"], capture_output=True, text=True, timeout=60
        )
        assert (done.returncode, done.stdout) == (3, f"{name}:a b;{name}:--ros-args;")


def test_all_packages_are_listed(described: dict[str, Any]) -> None:
    folders = {p.parent.relative_to(ROOT).as_posix().replace("/", ".") for p in (ROOT / "artrec_ros").rglob("*.py")}
    assert set(described["packages"]) == folders


def test_executables_exist(described: dict[str, Any]) -> None:
    scripts = dict(re.split(r"\s*=\s*", s) for s in described["entry_points"]["console_scripts"])
    assert set(scripts) == {"artrec", "artrec_node"}
    for target in scripts.values():
        module, _, function = target.partition(":")
        tree = ast.parse((ROOT / (module.replace(".", "/") + ".py")).read_text())
        assert function in [n.name for n in tree.body if isinstance(n, ast.FunctionDef)]


def test_ros_comes_from_pypi_unless_one_that_fits_is_sourced(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def ros() -> list[str]:
        return [r for r in described_by_setup(monkeypatch)["install_requires"] if r.startswith(("ros-", "numpy<"))]

    monkeypatch.delenv("ARTREC_WITHOUT_ROS", raising=False)
    monkeypatch.delenv("AMENT_PREFIX_PATH", raising=False)
    assert [r.split(">")[0] for r in ros()] == ["ros-jazzy-rclpy[fastrtps]", "ros-jazzy-common-interfaces"]
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    (tmp_path / "lib" / "python2.7" / "site-packages" / "rclpy").mkdir(parents=True)
    assert len(ros()) == 2, "one for another Python does not fit"
    version = f"python{sys.version_info.major}.{sys.version_info.minor}"
    (tmp_path / "lib" / version / "site-packages" / "rclpy").mkdir(parents=True)
    assert ros() == ["numpy<2"]
    monkeypatch.delenv("AMENT_PREFIX_PATH")
    monkeypatch.setenv("ARTREC_WITHOUT_ROS", "1")
    assert ros() == []


def test_shared_files_are_found_in_the_source_tree() -> None:
    assert resolve_path("package://artrec_ros/config/aibo.yaml", Path()).read_text()


@pytest.mark.parametrize("layout", ["lib/python3.12/site-packages", "local/lib/python3.12/dist-packages", "."])
def test_shared_files_are_found_in_an_installed_prefix(layout: str, tmp_path: Path) -> None:
    """pip and colcon put modules and share/ under one prefix."""
    packages = tmp_path / layout / "artrec_ros"
    for module in ("io/base/shared_files.py", "core/base/errors.py"):
        (packages / module).parent.mkdir(parents=True)
        (packages / module).write_text((ROOT / "artrec_ros" / module).read_text())
    share = tmp_path / "share" / "artrec_ros"
    share.mkdir(parents=True)
    program = "from artrec_ros.io.base.shared_files import share_directory; print(share_directory())"
    environment = {**os.environ, "PYTHONPATH": str(packages.parent), "AMENT_PREFIX_PATH": ""}
    done = subprocess.run(
        [sys.executable, "-c", program], env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=60
    )
    assert done.stdout.strip() == str(share), done.stderr


def test_paths_are_absolute_relative_or_of_a_package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert resolve_path("a/b.yaml", tmp_path) == tmp_path / "a" / "b.yaml"
    assert resolve_path("/a/b.yaml", tmp_path) == Path("/a/b.yaml")
    (tmp_path / "share" / "other").mkdir(parents=True)
    monkeypatch.setenv("AMENT_PREFIX_PATH", str(tmp_path))
    assert resolve_path("package://other/x.yaml", Path()) == tmp_path / "share" / "other" / "x.yaml"
    with pytest.raises(ConfigError, match="package://nowhere.*AMENT_PREFIX_PATH"):
        share_directory("nowhere")


def launch_file() -> tuple[list[tuple[str, ...]], set[str]]:
    """The launch file's arguments and the parameters that it sets where they are given, without running it."""
    tree = ast.parse((ROOT / "launch" / "artrec.launch.py").read_text())
    assigned = {n.targets[0].id: n.value for n in ast.walk(tree) if isinstance(n, ast.Assign)}
    arguments = [tuple(ast.unparse(e) for e in row.elts) for row in assigned["ARGUMENTS"].elts]
    return arguments, set(ast.literal_eval(assigned["given"].generators[0].iter))


def test_the_launch_file_knows_the_usual_arguments_and_the_nodes_parameters() -> None:
    arguments, own = launch_file()
    assert {"namespace", "image", "camera_info", "params_file", "image_transport"} <= {
        ast.literal_eval(name) for name, _, _, _ in arguments
    }
    assert all(len(description) > 8 for _, _, description, _ in arguments)
    assert own <= {*NodeConfig.__dataclass_fields__, "use_sim_time"}
    assert {default for name, default, _, _ in arguments if ast.literal_eval(name) in own} == {"''"}


needs_launch = pytest.mark.skipif(
    importlib.util.find_spec("launch_ros") is None, reason="launch and launch_ros are not installed (not on PyPI)"
)


def test_the_launch_files_agree_on_their_arguments() -> None:
    """Without launch: what the file for two cameras passes on, the one for one camera declares."""
    names = {ast.literal_eval(row[0]) for row in launch_file()[0]}
    tree = ast.parse((ROOT / "launch" / "two_cameras.launch.py").read_text())
    assigned = {n.targets[0].id: n.value for n in tree.body if isinstance(n, ast.Assign)}
    passed = [ast.literal_eval(row.elts[0]) for table in ("SHARED", "OWN") for row in assigned[table].elts]
    assert len(passed) == len(set(passed)) and set(passed) <= names


@needs_launch
def test_the_launch_file_makes_a_node() -> None:
    from launch import LaunchContext

    module = runpy.run_path(str(ROOT / "launch" / "artrec.launch.py"))
    context = LaunchContext()
    for action in module["generate_launch_description"]().entities:
        action.execute(context)
    (node,) = module["make_node"](context)
    assert node.node_package == "artrec_ros" and node.node_executable == "artrec_node"


@needs_launch
def test_two_cameras_have_a_node_each() -> None:
    from launch.actions import IncludeLaunchDescription

    from launch import LaunchContext

    module = runpy.run_path(str(ROOT / "launch" / "two_cameras.launch.py"))
    context = LaunchContext()
    included = []
    for action in module["generate_launch_description"]().entities:
        if isinstance(action, IncludeLaunchDescription):
            included.append({k: v.perform(context) for k, v in action.launch_arguments})
        else:
            action.execute(context)
    assert [values["namespace"] for values in included] == ["left", "right"]
    assert all(values["image"] == "image" and values["autostart"] == "" for values in included)


def test_the_views_shipped_show_topics_that_there_are() -> None:
    known = {"/" + t.of("red").lstrip("/") for t in OUTPUTS}
    folder = ROOT / "config" / "visualization"
    rviz = yaml.safe_load((folder / "artrec.rviz").read_text())["Visualization Manager"]["Displays"]
    shown = {d["Topic"]["Value"] for d in rviz if "Topic" in d}
    assert len(shown) >= 4 and shown <= known
    panels = json.loads((folder / "foxglove.json").read_text())["configById"]
    shown = set(panels["3D!artrec"]["topics"]) | {panels["Image!artrec"]["imageMode"]["imageTopic"]}
    assert shown <= known and panels["Plot!artrec"]["paths"][0]["value"].partition(".")[0] in known


def test_the_dds_profile_holds_several_large_images() -> None:
    tree = ET.parse(ROOT / "config" / "dds" / "large_images.xml")
    names = {"p": "http://www.eprosima.com/XMLSchemas/fastRTPS_Profiles"}
    size = int(tree.findtext(".//p:segment_size", namespaces=names) or 0)
    assert size > 4 * 1280 * 720 * 3
    made = [e.text for e in tree.findall(".//p:transport_descriptor/p:transport_id", names)]
    used = [e.text for e in tree.findall(".//p:userTransports/p:transport_id", names)]
    assert made == used and len(made) == 2
