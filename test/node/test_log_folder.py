"""ROS' log has a folder, or one line says how to give it one."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy", reason="no ROS 2 (rclpy) here")

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.node.log_folder import check_log_folder


@pytest.fixture(autouse=True)
def nothing_set(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("ROS_LOG_DIR", "ROS_HOME", "HOME", "RCL_LOGGING_IMPLEMENTATION"):
        monkeypatch.delenv(name, raising=False)


@pytest.mark.parametrize(
    ("variable", "value", "made"),
    [("ROS_LOG_DIR", "a/b", "a/b"), ("ROS_HOME", "a", "a/log"), ("HOME", "a", "a/.ros/log")],
)
def test_a_folder_that_can_be_made_is_made(
    variable: str, value: str, made: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(variable, str(tmp_path / value))
    check_log_folder()
    assert (tmp_path / made).is_dir()


def test_where_there_can_be_none_the_way_out_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ConfigError, match="the folder of ROS' logs: HOME is not set: .* ROS_LOG_DIR"):
        check_log_folder()
    (tmp_path / "file").touch()
    monkeypatch.setenv("HOME", str(tmp_path / "file"))
    with pytest.raises(ConfigError, match="file/.ros/log: Not a directory: .* ROS_LOG_DIR"):
        check_log_folder()
    check_log_folder(["--ros-args", "--disable-external-lib-logs"])


def test_the_node_ends_with_that_line(parameter_file: Path) -> None:
    command = [sys.executable, "-m", "artrec_ros.node.main", "--ros-args", "--params-file", str(parameter_file)]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120, check=False)
    (line,) = done.stderr.splitlines()
    assert done.returncode == 1 and line.startswith("artrec_node: the folder of ROS' logs: HOME is not set")
