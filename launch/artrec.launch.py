"""Starts artrec_node: ros2 launch artrec_ros artrec.launch.py image:=/camera/image_raw camera_info:=/camera/camera_info

Two cameras: two_cameras.launch.py includes this file twice, with another `namespace` each.
"""

from pathlib import Path

from launch.actions import DeclareLaunchArgument, OpaqueFunction
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import Node

from launch import LaunchDescription

SHARE = Path(__file__).absolute().parents[1]

BOOLEAN = ("", "true", "false", "True", "False")
AS_FILE = "; left out: as the parameter file says"
ARGUMENTS = (
    ("namespace", "", "namespace of the node and of all that it publishes", None),
    ("image", "image", "image topic; with image_transport compressed, /compressed is added", None),
    ("camera_info", "camera_info", "calibration topic", None),
    (
        "params_file",
        str(SHARE / "config" / "aibo.yaml"),
        "node parameters; relative paths in it start at its folder",
        None,
    ),
    ("image_transport", "", "raw or compressed" + AS_FILE, ("", "raw", "compressed")),
    ("use_sim_time", "", "true: take time from /clock" + AS_FILE, BOOLEAN),
    ("autostart", "", "false: wait for a lifecycle manager" + AS_FILE, BOOLEAN),
    ("log_level", "info", "how much is told", ("debug", "info", "warn", "error", "fatal")),
)


def make_node(context):
    value = {name: LaunchConfiguration(name).perform(context) for name, _, _, _ in ARGUMENTS}
    params_file = Path(value["params_file"]).expanduser().absolute()
    if not params_file.is_file():
        raise FileNotFoundError(f"params_file:={value['params_file']}: there is no such file")
    given = {name: value[name] for name in ("image_transport", "use_sim_time", "autostart") if value[name]}
    own = {name: text.lower() == "true" if text in BOOLEAN else text for name, text in given.items()}
    node = Node(
        package="artrec_ros",
        executable="artrec_node",
        namespace=value["namespace"],
        parameters=[str(params_file), *([own] if own else [])],
        remappings=[("image", value["image"]), ("camera_info", value["camera_info"])],
        arguments=["--ros-args", "--log-level", value["log_level"]],
        output="screen",
    )
    return [node]


def generate_launch_description():
    declared = [
        DeclareLaunchArgument(name, default_value=default, description=text, choices=choices)
        for name, default, text, choices in ARGUMENTS
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=make_node)])
