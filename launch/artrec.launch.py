"""Starts artrec_node: ros2 launch artrec_ros artrec.launch.py image:=/camera/image_raw camera_info:=/camera/camera_info

Two cameras: two_cameras.launch.py includes this file twice, with another `namespace` each.
"""

from pathlib import Path

from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchDescription

SHARE = Path(__file__).absolute().parents[1]

ARGUMENTS = (
    ("namespace", "", "namespace of the node and of all that it publishes"),
    ("image", "image", "image topic; with image_transport compressed, /compressed is added"),
    ("camera_info", "camera_info", "calibration topic"),
    ("params_file", str(SHARE / "config" / "aibo.yaml"), "node parameters; relative paths in it start at its folder"),
    ("image_transport", "raw", "raw or compressed"),
    ("use_sim_time", "false", "take time from /clock"),
    ("autostart", "true", "false: wait for a lifecycle manager"),
    ("log_level", "info", "debug, info, warn, error or fatal"),
)


def make_node(context):
    value = {name: LaunchConfiguration(name).perform(context) for name, _, _ in ARGUMENTS}
    params_file = Path(value["params_file"]).expanduser().absolute()
    own = {
        "config_dir": str(params_file.parent),
        "image_transport": value["image_transport"],
        "use_sim_time": value["use_sim_time"].lower() == "true",
        "autostart": value["autostart"].lower() == "true",
    }
    node = Node(
        package="artrec_ros",
        executable="artrec_node",
        namespace=value["namespace"],
        parameters=[str(params_file), own],
        remappings=[("image", value["image"]), ("camera_info", value["camera_info"])],
        arguments=["--ros-args", "--log-level", value["log_level"]],
        output="screen",
    )
    return [node]


def generate_launch_description():
    declared = [DeclareLaunchArgument(name, default_value=d, description=text) for name, d, text in ARGUMENTS]
    return LaunchDescription([*declared, OpaqueFunction(function=make_node)])
