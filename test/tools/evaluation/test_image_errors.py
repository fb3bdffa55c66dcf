"""Place and direction of markers against annotated axes, with errors that are known by hand."""

from __future__ import annotations

import json
from dataclasses import dataclass, replace

import numpy as np
import pytest
import yaml

from artrec_ros.core.model.found import Detection, ImagePose, Instance
from artrec_ros.tools.main import main

from .makers import OBJECT, record, true_thing, write_run, write_truth

KEYPOINTS = ["base/plate.tail", "base/plate.head", "arm/stripe.tail", "arm/stripe.head"]
AXES = {"base": [[-0.1, 0], [0.1, 0]], "arm": [[-0.06, 0], [0.06, 0]]}
OUTLINES = {
    "base": OBJECT["markers"]["plate"]["outline"],
    "arm": [[-0.06, -0.015], [0.06, -0.015], [0.06, 0.015], [-0.06, 0.015]],
}
MARKERS = {"base": "plate", "arm": "stripe"}


@dataclass(frozen=True)
class Seen:
    """Where a marker's origin lies in the image, its direction, and pixels per metre."""

    x: float
    y: float
    theta: float
    scale: float = 200.0

    def pixels(self, points) -> np.ndarray:
        """(n, 2) of points in the marker's frame; the image's y runs down, and theta from x to y."""
        c, s = np.cos(self.theta), np.sin(self.theta)
        return np.array([self.x, self.y]) + self.scale * (np.asarray(points) * (1, -1)) @ [[c, s], [-s, c]]


def centroid(outline) -> np.ndarray:
    """By triangles from the first corner."""
    p = np.asarray(outline, float)
    a, b = p[1:-1] - p[0], p[2:] - p[0]
    areas = (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]) / 2
    return p[0] + areas @ (a + b) / 3 / areas.sum()


def annotated(n: int, image: int, markers: dict[str, Seen], half=()) -> dict:
    """A COCO annotation. :param half: components of which one end alone is labelled."""
    points = []
    for component in ("base", "arm"):
        for end in (0, 1):
            missing = component not in markers or (component in half and end)
            points += [0, 0, 0] if missing else [*markers[component].pixels([AXES[component][end]])[0], 2]
    return {"id": n, "image_id": image, "category_id": 1, "keypoints": points}


def found(markers: dict[str, Seen], off=(0.0, 0.0), turned_deg=0.0, of: str | None = None) -> Detection:
    """The same as a detection; the component `of`, or each one, displaced by `off` pixels and turned."""
    parts = []
    for name, seen in markers.items():
        wrong = of in (None, name)
        x, y = seen.pixels([centroid(OUTLINES[name])])[0] + (np.array(off) if wrong else 0)
        theta = seen.theta + (np.radians(turned_deg) if wrong else 0)
        theta = (theta + np.pi) % (2 * np.pi) - np.pi
        parts.append(Instance(name, MARKERS[name], 0.9, float(x), float(y), float(theta), seen.scale))
    base = parts[0]
    return Detection("thing", 0, 0.9, ImagePose(base.x, base.y, base.theta, base.scale), tuple(parts), None, {})


def scored(folder, frames, shapes=None):
    """All figures of a replay; `frames`: annotations and detections of each. :param shapes: of markers, by name."""
    folder.mkdir(exist_ok=True)
    run = write_run(folder / "run", [record(i, *ds, name=f"{i}.png") for i, (_, ds) in enumerate(frames)])
    if shapes:
        changed = OBJECT | {"markers": OBJECT["markers"] | shapes}
        (run / "thing.yaml").write_text(yaml.safe_dump(changed, sort_keys=False))
    content = {
        "images": [{"id": i, "file_name": f"images/{i}.png"} for i in range(len(frames))],
        "categories": [{"id": 1, "name": "thing", "keypoints": KEYPOINTS}],
        "annotations": [a for annotations, _ in frames for a in annotations],
    }
    (folder / "coco.json").write_text(json.dumps(content))
    assert main(["evaluate", str(run), "--truth", str(folder / "coco.json"), "--no-page"]) == 0
    return json.loads((run / "metrics.json").read_text())["all"]


def errors(figures):
    pair = figures["image_error_px_median"], figures["direction_error_deg_median"]
    return (*(f["value"] for f in pair), *(f["n"] for f in pair))


THING = {"base": Seen(70.0, 50.0, 0.4), "arm": Seen(95.0, 62.0, -1.1)}


def test_what_lies_on_its_annotation_has_no_error(tmp_path):
    """At the centroid, which is not the middle of the annotated axis."""
    assert np.linalg.norm(THING["base"].pixels([centroid(OUTLINES["base"]), (0, 0)])[0] - (70, 50)) > 1
    px, deg, *n = errors(scored(tmp_path, [([annotated(0, 0, THING)], [found(THING)])]))
    assert (px, deg, n) == (pytest.approx(0, abs=1e-3), pytest.approx(0, abs=1e-3), [2, 2])


@pytest.mark.parametrize("turned_deg", [7.0, -7.0])
@pytest.mark.parametrize("theta", [0.0, np.pi - 0.02, -np.pi + 0.02, 1.7])
def test_place_and_direction_are_off_by_what_they_were_moved(tmp_path, theta, turned_deg):
    """Directions are compared around the circle: from 179 to -174 degrees it is 7."""
    thing = {"base": replace(THING["base"], theta=theta), "arm": replace(THING["arm"], theta=theta + 1.0)}
    px, deg, *n = errors(scored(tmp_path, [([annotated(0, 0, thing)], [found(thing, (3.0, -4.0), turned_deg)])]))
    assert (px, deg, n) == (pytest.approx(5.0, abs=1e-3), pytest.approx(7.0, abs=1e-3), [2, 2])


def test_the_median_is_over_all_markers_of_all_objects(tmp_path):
    thing = {"base": THING["base"]}
    frames = [
        ([annotated(i, i, thing)], [found(thing, (px, 0.0), deg)])
        for i, (px, deg) in enumerate([(1.0, 9.0), (2.0, 2.0), (6.0, 1.0)])
    ]
    px, deg, *n = errors(scored(tmp_path, frames))
    assert (px, deg, n) == (pytest.approx(2.0, abs=1e-3), pytest.approx(2.0, abs=1e-3), [3, 3])


def test_each_component_counts_with_its_own_error(tmp_path):
    px, deg, *n = errors(scored(tmp_path, [([annotated(0, 0, THING)], [found(THING, (0, 6), 10, of="arm")])]))
    assert (px, deg, n) == (pytest.approx(3.0, abs=1e-3), pytest.approx(5.0, abs=1e-3), [2, 2])  # of 0 and 6, 0 and 10


def test_a_marker_that_was_not_annotated_whole_says_nothing(tmp_path):
    frames = [
        ([annotated(0, 0, {"base": THING["base"]})], [found(THING, (2, 0), 3)]),
        ([annotated(1, 1, THING, half=("arm",))], [found(THING, (2, 0), 3)]),
    ]
    px, deg, *n = errors(scored(tmp_path, frames))
    assert (px, deg, n) == (pytest.approx(2.0, abs=1e-3), pytest.approx(3.0, abs=1e-3), [2, 2])  # the bases alone


def test_what_was_not_found_or_lies_on_nothing_has_no_error(tmp_path):
    away = {name: replace(seen, x=seen.x + 75, y=seen.y + 40) for name, seen in THING.items()}
    frames = [
        ([annotated(0, 0, THING)], []),  # missed
        ([], [found(THING, (1, 1), 20)]),  # false
        ([annotated(1, 2, THING)], [found({"base": THING["base"]}, (0, 2), 4), found(away, (9, 9), 90)]),
    ]
    figures = scored(tmp_path, frames)
    px, deg, *n = errors(figures)
    assert (px, deg, n) == (pytest.approx(2.0, abs=1e-3), pytest.approx(4.0, abs=1e-3), [1, 1])
    assert (figures["counts"]["objects"], figures["counts"]["recognised"], figures["counts"]["false"]) == (2, 1, 2)


def test_a_direction_that_is_the_wrong_way_round_is_half_a_turn_off(tmp_path):
    """Also where the marker looks the same: the annotation says which end is the head."""
    _, deg, *_ = errors(scored(tmp_path, [([annotated(0, 0, THING)], [found(THING, turned_deg=180, of="arm")])]))
    assert deg == pytest.approx(90, abs=1e-3)  # the median of 0 and 180


def test_both_are_told_in_the_table_and_on_no_other_truth(tmp_path, capsys):
    scored(tmp_path, [([annotated(0, 0, THING)], [found(THING, (3.0, 4.0), 7.0)])])
    told = [line.split() for line in capsys.readouterr().out.splitlines()]
    assert [line[5] for line in told if line[:5] == ["place", "in", "the", "image,", "px"]] == ["5.0"]
    assert [line[2] for line in told if line[:2] == ["direction,", "deg"]] == ["7.00"]
    run, truth = write_run(tmp_path / "other", [record(1)]), write_truth(tmp_path / "t.jsonl", {1: [true_thing()]})
    assert main(["evaluate", str(run), "--truth", str(truth), "--no-page"]) == 0
    assert "place in the image" not in capsys.readouterr().out
    assert errors(json.loads((run / "metrics.json").read_text())["all"]) == (None, None, 0, 0)


ROUND = [[0.06 * np.cos(a).item(), 0.06 * np.sin(a).item()] for a in np.linspace(0, 2 * np.pi, 36, endpoint=False)]
DISCS = ({"disc": {"radius": 0.06}}, {"outline": ROUND, "axis": [[-0.06, 0], [0.06, 0]]})


@pytest.mark.parametrize("disc", DISCS)
def test_the_direction_of_a_disc_is_whatever_the_annotator_chose_and_does_not_count(tmp_path, disc):
    frames = [([annotated(0, 0, THING)], [found(THING, (0, 6), 80, of="arm")])]
    px, deg, *n = errors(scored(tmp_path, frames, {"stripe": disc}))
    assert (px, deg, n) == (pytest.approx(3.0, abs=1e-3), pytest.approx(0.0, abs=1e-3), [2, 1])


ALL_DISCS = {"plate": {"disc": {"radius": 0.1}}, "stripe": DISCS[0]}


@pytest.mark.parametrize("turned_deg", [0, 30, 180])
def test_several_discs_tell_a_direction_by_their_places(tmp_path, turned_deg):
    """Once an object, whatever direction is told of each."""
    base, arm, angle = THING["base"], THING["arm"], np.radians(turned_deg)
    x, y = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]) @ (
        arm.x - base.x,
        arm.y - base.y,
    )
    places = ("base", base.x, base.y, 1.0), ("arm", base.x + x, base.y + y, 2.0)
    parts = tuple(Instance(name, MARKERS[name], 0.9, *map(float, place), 200.0) for name, *place in places)
    told = Detection("thing", 0, 0.9, ImagePose(base.x, base.y, 1.0, 200.0), parts, None, {})
    _, deg, *n = errors(scored(tmp_path, [([annotated(0, 0, THING)], [told])], ALL_DISCS))
    assert (deg, n) == (pytest.approx(turned_deg, abs=0.1), [2, 1])


def test_where_nothing_has_a_direction_it_is_said_so(tmp_path, capsys):
    frames = [([annotated(0, 0, THING)], [found({"base": THING["base"]}, (0, 6), 80)])]
    px, deg, *n = errors(scored(tmp_path, frames, ALL_DISCS))
    told = capsys.readouterr().out
    assert (deg, n) == (None, [1, 0]) and px is not None
    assert "no direction is judged" in told and "direction, deg" not in told


def test_one_of_ten_that_is_turned_by_half_shows_in_what_95_percent_are_below(tmp_path):
    turned = {name: replace(seen, theta=seen.theta + np.pi) for name, seen in THING.items()}
    frames = [([annotated(i, i, THING)], [found(turned if i == 3 else THING)]) for i in range(10)]
    figures = scored(tmp_path, frames)
    assert figures["direction_error_deg_median"]["value"] == pytest.approx(0, abs=1e-3)
    assert figures["direction_error_deg_p95"]["value"] > 90


def test_what_lies_in_a_crowd_is_neither_right_nor_false(tmp_path):
    """Nobody has said what is there."""
    away = {name: replace(seen, x=seen.x + 130) for name, seen in THING.items()}
    crowd = {"id": 9, "image_id": 0, "category_id": 1, "keypoints": [0] * 12, "iscrowd": 1}
    for place, precision in (([170, 30, 70, 50], 1.0), ([20, 150, 70, 50], 0.5)):
        frame = [annotated(1, 0, THING), {**crowd, "bbox": place}], [found(THING), found(away)]
        assert scored(tmp_path / str(precision), [frame])["precision"]["value"] == precision
