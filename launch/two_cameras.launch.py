"""Starts a node for each of two cameras: ros2 launch artrec_ros two_cameras.launch.py

Each has a namespace, and all that it publishes is under it: /left/red/poses, /right/red/poses. By default the images
are expected there too: /left/image, /left/camera_info.
"""

from pathlib import Path

from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration

from launch import LaunchDescription

SHARE = Path(__file__).absolute().parents[1]
CAMERAS = ("left", "right")
SHARED = (
    ("params_file", str(SHARE / "config" / "aibo.yaml"), "node parameters of both"),
    ("image_transport", "", "raw or compressed; left out, as the next two: as the parameter file says"),
    ("use_sim_time", "", "true: take time from /clock"),
    ("autostart", "", "false: wait for a lifecycle manager"),
)
OWN = (
    ("namespace", "{camera}", "namespace of the {camera} camera's node"),
    ("image", "image", "image topic of the {camera} camera, relative to its namespace or absolute"),
    ("camera_info", "camera_info", "calibration topic of the {camera} camera"),
)


def arguments_of(camera):
    """One camera's own arguments: (name here, name in the included file, default, description)."""
    return [(f"{camera}_{name}", name, d.format(camera=camera), text.format(camera=camera)) for name, d, text in OWN]


def include(camera):
    passed = {name: LaunchConfiguration(name) for name, _, _ in SHARED}
    passed |= {name: LaunchConfiguration(here) for here, name, _, _ in arguments_of(camera)}
    source = PythonLaunchDescriptionSource(str(SHARE / "launch" / "artrec.launch.py"))
    return IncludeLaunchDescription(source, launch_arguments=passed.items())


def generate_launch_description():
    arguments = [*SHARED, *((here, d, text) for camera in CAMERAS for here, _, d, text in arguments_of(camera))]
    declared = [DeclareLaunchArgument(name, default_value=d, description=text) for name, d, text in arguments]
    return LaunchDescription([*declared, *(include(camera) for camera in CAMERAS)])
