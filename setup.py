import os
import sys
from glob import glob
from pathlib import Path

from setuptools import find_packages, setup

PACKAGE = "artrec_ros"
SHARE = Path("share") / PACKAGE
REPORT = ["Jinja2>=3.0", "matplotlib>=3.5"]
CLUSTER = ["distributed>=2023.5"]
TUNE = ["optuna>=3.6"]
STUDIO = ["nicegui>=3.18"]
DOCS = ["mkdocs>=1.6,<2", "mkdocs-material>=9.5"]


def shipped(*folders):
    """data_files entries that keep each folder's tree under share/artrec_ros."""
    found = (Path(f) for folder in folders for f in sorted(glob(f"{folder}/**", recursive=True)))
    files = [f for f in found if f.is_file() and f.parent.name != "__pycache__"]
    folders = sorted({f.parent for f in files})
    return [(str(SHARE / folder), [str(f) for f in files if f.parent == folder]) for folder in folders]


def launchers():
    """What stands in lib/artrec_ros, where `ros2 run` and `ros2 launch` look, for the executables in bin/.

    In wheels alone, which pip makes of everything that it installs: colcon has the executables themselves put there, as
    setup.cfg says.
    """
    if not {"bdist_wheel", "editable_wheel"} & set(sys.argv):
        return []
    return [(f"lib/{PACKAGE}", sorted(glob("resource/lib/*")))]


def sourced_ros():
    """The prefix of a sourced ROS 2 whose rclpy fits this Python, or None."""
    python = f"python{sys.version_info.major}.{sys.version_info.minor}"
    libraries = (f"lib/{python}/site-packages", f"lib/{python}/dist-packages", f"local/lib/{python}/dist-packages")
    for prefix in filter(None, os.environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep)):
        if any((Path(prefix) / library / "rclpy").is_dir() for library in libraries):
            return Path(prefix)
    return None


def ros_requirements():
    """ROS from PyPI, unless one is sourced: that one is then used. ARTREC_WITHOUT_ROS=1 leaves ROS out."""
    if os.environ.get("ARTREC_WITHOUT_ROS") == "1":
        return []
    ros = sourced_ros()
    if ros is None:
        wheels = "sys_platform == 'linux' and platform_machine == 'x86_64' and python_version < '3.14'"
        return [f"ros-jazzy-rclpy[fastrtps]>=7.1.6; {wheels}", f"ros-jazzy-common-interfaces>=5.3.6; {wheels}"]
    # Jazzy's own messages are compiled against Ubuntu's numpy 1.26.
    return [] if ros.is_relative_to(sys.prefix) else ["numpy<2"]


setup(
    name=PACKAGE,
    version="0.1.0",
    description="Recognises articulated objects in images by their coloured markers; ROS 2 node, training and replay.",
    long_description=Path("README.md").read_text(encoding="utf-8") if Path("README.md").is_file() else "",
    long_description_content_type="text/markdown",
    maintainer="artrec_ros maintainers",
    maintainer_email="maintainers@artrec-ros.example",
    license="Apache-2.0",
    python_requires=">=3.10",
    packages=find_packages(include=[PACKAGE, f"{PACKAGE}.*"]),
    package_data={f"{PACKAGE}.tools.evaluation": ["templates/*.j2"]},
    data_files=[
        ("share/ament_index/resource_index/packages", [f"resource/{PACKAGE}"]),
        (str(SHARE), ["package.xml"]),
        *shipped("config", "launch"),
        *launchers(),
    ],
    install_requires=[
        "backports.zstd>=1.0; python_version < '3.14'",
        "lz4>=4.0",
        "numba>=0.59",
        "numpy>=1.24",
        "opencv-python-headless>=4.6",
        "PyYAML>=5.4",
        "rosbags>=0.10.5",
        "scipy>=1.10",
        "tqdm>=4.57",
        *ros_requirements(),
    ],
    extras_require={
        "cluster": CLUSTER,  # 41 MB, Dask and what comes with it: artrec replay --scheduler
        "tune": TUNE,  # 39 MB, most of it SQLAlchemy: artrec tune
        "studio": STUDIO,  # 100 MB, a third of it NiceGUI, else what its web server needs: artrec studio
        "model": ["svgelements>=1.9"],  # 0.8 MB, nothing else comes with it: artrec model reads SVG drawings
        # artrec replay --rerun: 670 MB, nearly all of it the viewer and pyarrow; Python 3.11 or newer.
        "rerun": ["rerun-sdk>=0.41"],
        "docs": DOCS,  # the documentation as a site: scripts/docs
        # The page of artrec evaluate: 102 MB, nearly all of it matplotlib and what comes with it.
        "report": REPORT,
        "test": [
            *REPORT,
            *CLUSTER,
            *TUNE,
            *STUDIO,
            *DOCS,
            "axe-playwright-python>=0.1.4",  # what is hard to read or to reach on a page
            "hypothesis>=6",
            "mypy>=1.8",
            "playwright>=1.40",  # drives the system's chromium
            "pytest>=7.4",
            "pytest-xdist>=3.3",
            "ruff>=0.6",
            "svgelements>=1.9",
            "types-PyYAML",
            "types-tqdm",
        ],  # fmt: skip
    },
    entry_points={
        "console_scripts": [
            "artrec = artrec_ros.tools.main:main",
            "artrec_node = artrec_ros.node.main:main",
        ],
    },
    zip_safe=True,
)
