"""The examples in the documentation work."""

import json
import os
import re
import shlex
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import charuco_views
import cv2
import numpy as np
import pytest
import yaml
from tutorial import PICTURES, Command, SaveFile, alternatives, steps

from artrec_ros.core.model.found import ClassFit
from artrec_ros.core.model.frame_result import ConstraintFailure, Rejection
from artrec_ros.io.images.cameras import load_camera
from artrec_ros.io.learned.annotations import load_coco
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.io.results.results import FrameRecord, read_results
from artrec_ros.io.truth.records import load_truth
from artrec_ros.tools.main import COMMANDS, NEEDING_ROS, _parse, main

ROOT = Path(__file__).parents[1]
PAGES = ["README.md", *sorted(str(p.relative_to(ROOT)) for p in (ROOT / "docs").glob("*.md"))]
TO_COME: set[str] = set()  # commands that pages tell of and that may not be there yet


@pytest.fixture(scope="module")
def followed(tmp_path_factory):
    """A folder in which the tutorial was followed, with fewer frames."""
    pytest.importorskip("svgelements")
    folder = tmp_path_factory.mktemp("tutorial")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        for step in steps():
            if isinstance(step, SaveFile):
                step.save(folder)
            else:
                run(step)
    return folder


def run(step: Command, frames: str = "4"):
    program, *arguments = step.arguments
    if program != "artrec":  # a snippet of the page, or the shell's own
        assert program in ("python", "sed"), step
        path = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
        environment = {**os.environ, "PATH": path, "PYTHONPATH": str(ROOT)}
        line = step.line.replace("python ", f"{shlex.quote(sys.executable)} ", 1) if program == "python" else step.line
        subprocess.run(line, shell=True, check=True, env=environment)
        return
    if "--frames" in arguments:
        arguments[arguments.index("--frames") + 1] = frames
    assert main(arguments) == 0, step


def follow(page: str, frames: str = "4"):
    """Save the page's files in the current folder and run its commands there."""
    for step in steps(ROOT / "docs" / page):
        if isinstance(step, SaveFile):
            step.save(Path())
        else:
            run(step, frames)


def test_the_tutorial_leads_to_poses(followed):
    truth = load_truth(followed / "simulated/truth.jsonl")
    records = [r for r in read_results(followed / "result/detections.jsonl") if r.complete]  # the first may compile
    assert len(records) >= 3
    for record in records:
        (true,), (found,) = truth[record.stamp_ns], record.detections
        assert np.linalg.norm(found.pose.position - true.pose.position) < 0.02 * np.linalg.norm(true.pose.position)
    joints = {name for record in records for d in record.detections for name in d.joints}
    assert joints == {"tilt", "lift"}


def test_the_tutorials_pictures_are_made_by_its_commands(followed):
    page = (ROOT / "docs/tutorial.md").read_text(encoding="utf-8")
    for name, made in PICTURES.items():
        assert len(list(followed.glob(made))) == 1 and (ROOT / "docs/images" / name).is_file()
        assert f"images/{name}" in page


def test_the_tutorials_other_parameters_are_valid(followed):
    (colour,) = alternatives()
    parameters = yaml.safe_load((followed / "forklift_params.yaml").read_text())
    parameters["/**"]["ros__parameters"] |= yaml.safe_load(colour)
    path = followed / "colour_params.yaml"
    path.write_text(yaml.safe_dump(parameters))
    setup = load_parameters(path)
    assert setup.image.kind == "colour" and setup.targets[0].label == 3


def test_the_camera_page_finds_a_known_calibration(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    charuco_views.write(tmp_path / "views", 8)
    follow("camera.md")
    found = load_camera(tmp_path / "camera.yaml")
    np.testing.assert_allclose(found.matrix, charuco_views.MATRIX, atol=3.0)
    np.testing.assert_allclose(found.distortion[:2], charuco_views.DISTORTION[:2], atol=0.05)


@pytest.fixture(scope="module")
def robots(tmp_path_factory):
    """A folder in which the pages on identities and on the field were followed, with fewer frames."""
    folder = tmp_path_factory.mktemp("robots")
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        follow("identity.md")
        follow("field.md", "8")
    return folder


def test_the_page_on_identities_tells_robots_apart(robots):
    told = [json.loads(line)["objects"] for line in (robots / "simulated/truth.jsonl").read_text().splitlines()]
    found = right = wrong = 0
    for record, objects in zip(read_results(robots / "result/detections.jsonl"), told, strict=True):
        for d in record.detections:
            nearest = min(
                objects, key=lambda o: np.hypot(*np.subtract(o["components"]["team"]["centre"], _at(d, "team")))
            )
            found += 1
            right += d.identity.name == nearest["identity"]
            wrong += d.identity.name not in (None, nearest["identity"])
    assert found >= 12 and right >= found - 2 and wrong <= 1


def _at(detection, component):
    """(2,) pixels."""
    (place,) = ((c.x, c.y) for c in detection.components if c.component == component)
    return place


def test_the_page_on_robots_from_above_names_them(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    import overhead

    monkeypatch.chdir(tmp_path)
    rng = np.random.default_rng(5)
    room = overhead.Room.random(14.0, 0.0, rng)
    scenes = overhead.write_pictures(tmp_path, room, rng, 6)
    (tmp_path / "coco.json").rename("pictures/coco.json")
    follow("overhead.md")
    score = overhead.Score()
    for record, scene in zip(read_results(tmp_path / "again/detections.jsonl"), scenes, strict=True):
        score.add(room, scene, record.detections)
    assert score.robots == 72 and score.right >= 65 and score.wrong == 0 and score.false <= 1


def test_the_page_on_the_field_finds_places_there(robots):
    """Distances between robots, and turns of one against the other, do not depend on where the field's frame lies."""
    truth = load_truth(robots / "moving/truth.jsonl")
    errors, turns = [], []
    for record in read_results(robots / "moved/detections.jsonl"):
        placed = [d for d in record.detections if d.pose is not None]
        assert {(d.frame_id, d.pose_from) for d in placed} <= {("field", "plane")} and len(placed) >= 1
        near = [_nearest(truth[record.stamp_ns], d) for d in placed]
        for i in range(len(near)):
            for j in range(i):
                told = np.linalg.norm(placed[i].pose.position - placed[j].pose.position)
                errors.append(abs(told - np.linalg.norm(near[i].pose.position - near[j].pose.position)))
                told, true = (x[i].pose.rotation.T @ x[j].pose.rotation[:, 0] for x in (placed, near))
                turns.append(np.degrees(np.arccos(np.clip(told @ true, -1, 1))))
    assert len(errors) > 15 and np.median(errors) < 0.004 and max(errors) < 0.03
    assert np.median(turns) < 4


def _team(truth):
    """(2,) pixels; far off where the patch cannot be seen."""
    team = truth.components.get("team")
    return np.full(2, 1e6) if team is None or team.centre is None else team.centre


def _nearest(objects, detection):
    """The object of the truth whose team patch lies nearest to the one that was found."""
    (team,) = (np.array([c.x, c.y]) for c in detection.components if c.component == "team")
    return min(objects, key=lambda o: np.linalg.norm(_team(o) - team))


def test_the_page_on_annotating_converts_an_export_and_trains_on_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    overview = (ROOT / "docs/overview.md").read_text(encoding="utf-8")
    (lamp,) = [text for text in re.findall(r"```yaml\n(.*?)```", overview, re.DOTALL) if "name: lamp" in text]
    Path("lamp.yaml").write_text(lamp)
    expected = _write_export(Path("export.json"), np.random.default_rng(0))
    follow("annotate.md")
    converted = load_coco(["annotations.json"]).objects
    assert len(converted) == len(expected)
    for annotated, points in zip(converted, expected, strict=True):
        assert set(annotated.points) == set(points) and annotated.category == "lamp"
        for name, place in points.items():
            np.testing.assert_allclose(annotated.points[name], place, atol=1e-6)
    pairs = yaml.safe_load(Path("lamp_constraints.yaml").read_text())["pairs"]
    assert pairs[0]["examples"] == sum(len(points) == 4 for points in expected)


def _write_export(path, rng):
    """An export of Label Studio of 24 tasks with two lamps each, some without their arm; the points, pixels."""
    size, expected, tasks = np.array([640, 480]), [], []
    for n in range(24):
        result = []
        for k in range(2):
            turn, scale, at = rng.uniform(-3, 3), rng.uniform(500, 900), rng.uniform(150, 330, 2)
            spread = rng.uniform(-0.4, 0.4)
            ends = {"foot/house.tail": -0.04 + 0j, "foot/house.head": 0.04 + 0j}
            if rng.random() < 0.8:
                ends |= {"arm/ribbon.tail": 0.02 * np.exp(1j * spread), "arm/ribbon.head": 0.15 * np.exp(1j * spread)}
            placed = {name: scale * np.exp(1j * turn) * z for name, z in ends.items()}
            points = {name: at + [z.real, z.imag] for name, z in placed.items()}
            sized = {"original_width": 640, "original_height": 480, "image_rotation": 0}
            box = {"x": 1, "y": 2, "width": 30, "height": 40, "rotation": 0, "rectanglelabels": ["lamp"]}
            for name, place in points.items():
                x, y = 100 * (place + 0.5) / size
                value = {"x": x, "y": y, "width": 0.3, "keypointlabels": [name]}
                result.append(
                    {"id": f"{n}{k}{name}", "type": "keypointlabels", "parentID": f"box{k}", "value": value, **sized}
                )
            result.append({"id": f"box{k}", "type": "rectanglelabels", "value": box, **sized})
            expected.append(points)
        name = f"{n:08x}-frame.png"
        cv2.imwrite(str(path.parent / name), np.zeros((480, 640), np.uint8))
        data = {"image": f"/data/upload/1/{name}"}
        tasks.append({"id": n, "data": data, "annotations": [{"id": n, "was_cancelled": False, "result": result}]})
    path.write_text(json.dumps(tasks))
    return expected


@pytest.mark.parametrize("page", PAGES)
def test_links_lead_somewhere(page):
    text = (ROOT / page).read_text(encoding="utf-8")
    links = [t.split("#")[0] for t in re.findall(r"\]\(([^)]+)\)", text) if "://" not in t]
    missing = [link for link in links if link and not ((ROOT / page).parent / link).exists()]
    assert not missing


def test_the_format_of_detections_is_told():
    """Every key that a replay may write stands in the section, and its example is a line of a replay."""
    section = (ROOT / "docs/replay.md").read_text(encoding="utf-8").partition("## detections.jsonl")[2]
    section = section.partition("\n## ")[0]
    example, rejection = re.findall(r"```json\n(.*?)```", section, re.DOTALL)
    record = FrameRecord.from_json(example.replace("\n", ""))
    assert json.loads(record.to_json()) == json.loads(example)
    failed = ConstraintFailure("a/b", "c/d", "turn_rad", 1.0, 0.0, 0.5, 0.5)
    everything = replace(
        record,
        source=1,
        error="why",
        detections=(replace(record.detections[0], class_fit=ClassFit(None, 0.1, "b", 0.2, "why"), margin=0.5),),
        rejected=(Rejection("red", "why", 0.5, 1.0, 2.0, failed),),
    )
    told = set(re.findall(r"`(\w+)`", section))
    named = {name for d in record.detections for name in d.joints}
    assert keys_of(json.loads(everything.to_json())) - named <= told
    assert keys_of(json.loads(rejection)) <= told


def keys_of(content) -> set[str]:
    if isinstance(content, list):
        return set().union(*map(keys_of, content)) if content else set()
    if not isinstance(content, dict):
        return set()
    return set(content).union(*map(keys_of, content.values()))


@pytest.mark.parametrize("page", PAGES)
def test_links_to_headings_lead_somewhere(page):
    for target, anchor in re.findall(r"\]\(([^)#:]*)#([^)]+)\)", (ROOT / page).read_text(encoding="utf-8")):
        text = ((ROOT / page).parent / target if target else ROOT / page).read_text(encoding="utf-8")
        headings = [re.sub(r"[^\w\- ]", "", h.lower()).replace(" ", "-") for h in re.findall(r"^#+ (.*)$", text, re.M)]
        assert anchor in headings, f"{target}#{anchor}"


def test_every_page_is_reached_from_the_readme():
    reached, waiting = set(), ["README.md"]
    while waiting:
        page = waiting.pop()
        reached.add(page)
        text = (ROOT / page).read_text(encoding="utf-8")
        for link in re.findall(r"\]\(([^)#:]+\.md)[^)]*\)", text):
            target = os.path.relpath((ROOT / page).parent / link, ROOT)
            if target in PAGES and target not in reached:
                waiting.append(target)
    assert not set(PAGES) - reached


def shown_commands(page):
    """`artrec` commands in the page's blocks: whole lines, behind RUN, && or a program that runs them."""
    text = (ROOT / page).read_text(encoding="utf-8")
    for block in re.findall(r"^```\w*\n(.*?)^```", text, re.DOTALL | re.M):
        for line in re.sub(r"\\\n\s*", " ", block).splitlines():
            for part in re.split(r"\s&&\s|\s\|\s", re.sub(r"^(\$|RUN)\s+", "", line)):
                part = re.sub(r"^(ros2 run artrec_ros|\w+=\S+)\s+", "", part.strip())
                if re.match(r"artrec(\s|$)", part) and "…" not in part:
                    yield shlex.split(part, comments=True)[1:]


@pytest.mark.parametrize("page", PAGES)
def test_commands_that_are_shown_are_valid(page, capsys):
    for arguments in shown_commands(page):
        if arguments[0] in TO_COME - set(COMMANDS) or (arguments[0] in NEEDING_ROS and not _has_ros()):
            continue
        try:
            _parse(arguments)
        except SystemExit as leaving:
            assert leaving.code == 0, f"{shlex.join(['artrec', *arguments])}: {capsys.readouterr().err}"


def _has_ros():
    try:
        import rclpy  # noqa: F401
    except ImportError:
        return False
    return True


def test_commands_are_found_on_the_pages():
    shown = [arguments[0] for page in PAGES for arguments in shown_commands(page)]
    assert len(shown) > 30 and set(COMMANDS) <= set(shown) | TO_COME
