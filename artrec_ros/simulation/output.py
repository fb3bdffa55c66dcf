"""Writes simulated frames to a folder: a bag, its truth, and annotated images."""

from __future__ import annotations

import json
import shutil
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from ..core.base.errors import SourceError
from ..core.model.target import Target
from ..io.bags.writer import BagWriter
from ..io.base.whole_files import held, make_folder
from ..io.images.cameras import camera_yaml
from ..io.images.writing import save_picture
from ..io.messages.detection_messages import Message, header
from .records import CocoBuilder, truth_record
from .sensor import palette
from .simulator import SimulatedFrame

UNFINISHED = ".unfinished"  # stands in a folder until all its frames are written
LABEL_TOPIC, COLOUR_TOPIC, CAMERA_TOPIC = (
    "/camera/segmentation",
    "/camera/image_color/compressed",
    "/camera/camera_info",
)


def write_frames(
    frames: Iterable[SimulatedFrame],
    targets: Sequence[Target],
    folder: Path,
    storage: str = "mcap",
    colour: bool = False,
) -> None:
    """Writes bag/, truth.jsonl, images/ (labels), preview/ (the same in colours one can see), annotations.json and
    camera.yaml.

    :param folder: is made; may exist if it is empty, or if an earlier run was interrupted there: it is begun anew.
    :param colour: the bag and preview/ bear the colour images, too.
    :raises SourceError: the folder holds something else already, another run is writing there, or it cannot be written.
    """
    with _begun(folder):
        _write(frames, targets, folder, storage, colour)


def _write(
    frames: Iterable[SimulatedFrame], targets: Sequence[Target], folder: Path, storage: str, colour: bool
) -> None:
    coco = CocoBuilder.of(targets)
    camera = None
    with ExitStack() as stack:
        bag = stack.enter_context(BagWriter(folder / "bag", storage))
        truth = stack.enter_context((folder / "truth.jsonl").open("w", encoding="utf-8"))
        for frame in frames:
            _write_messages(bag, frame, targets, colour)
            truth.write(json.dumps(truth_record(frame)) + "\n")
            name = f"{frame.index:04d}.png"
            save_picture(folder / "images" / name, frame.labels)
            save_picture(folder / "preview" / name, frame.colour if colour else palette()[frame.labels])
            coco.add(frame, f"images/{name}")
            camera = frame.camera
    if camera is not None:
        (folder / "camera.yaml").write_text(camera_yaml(camera), encoding="utf-8")
    (folder / "annotations.json").write_text(json.dumps(coco.content), encoding="utf-8")


@contextmanager
def _begun(folder: Path) -> Iterator[None]:
    """The folder with a mark that stays where a run does not come to its end."""
    try:
        make_folder(folder)
        with held(folder):
            mark = folder / UNFINISHED
            if mark.exists():
                _clear(folder)
            elif any(folder.iterdir()):
                raise SourceError(f"{folder}: holds files already; name a new folder")
            mark.touch()
            for name in ("images", "preview"):
                (folder / name).mkdir()
            yield
            mark.unlink()
    except OSError as error:
        raise SourceError(f"{folder}: cannot be written: {error.strerror}") from error
    except KeyboardInterrupt:
        raise KeyboardInterrupt(f"{folder} is not whole; the same command begins it anew") from None


def _clear(folder: Path) -> None:
    """Removes what an unfinished run wrote, and nothing else."""
    for name in ("bag", "images", "preview"):
        shutil.rmtree(folder / name, ignore_errors=True)
    for name in ("truth.jsonl", "annotations.json", "camera.yaml"):
        (folder / name).unlink(missing_ok=True)


def _write_messages(bag: BagWriter, frame: SimulatedFrame, targets: Sequence[Target], colour: bool) -> None:
    stamp, frame_id = frame.stamp_ns, frame.camera.frame_id
    bag.write_camera(CAMERA_TOPIC, stamp, frame.camera)
    bag.write_image(LABEL_TOPIC, stamp, frame_id, frame.labels)
    if colour:
        bag.write_jpeg(COLOUR_TOPIC, stamp, frame_id, frame.colour)
    for target in targets:
        poses = [p.T_camera_object for p in frame.scene.objects if p.target.name == target.name]
        bag.write_poses(f"/ground_truth/{target.name}/poses", stamp, frame_id, poses)
        if target.model.joint_components:
            bag.write(f"/ground_truth/{target.name}/joint_states", stamp, _joint_states(frame, target))


def _joint_states(frame: SimulatedFrame, target: Target) -> Message:
    """The true joints as the node tells them: red_0/front_left, numbered as the poses are."""
    placed = [p for p in frame.scene.objects if p.target.name == target.name]
    joints = [(f"{target.name}_{n}/{name}", q) for n, p in enumerate(placed) for name, q in p.joints.items()]
    fields = {
        "header": header(frame.stamp_ns, frame.camera.frame_id),
        "name": [name for name, _ in joints],
        "position": [float(q) for _, q in joints],
    }
    return Message("sensor_msgs/msg/JointState", fields)
