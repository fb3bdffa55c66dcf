from pathlib import Path

import pytest

from artrec_ros.core.constraints.pairs import configuration
from artrec_ros.core.model.target import Target
from artrec_ros.io.learned.constraints import load_constraints
from artrec_ros.io.objects.object_reader import load_object
from artrec_ros.simulation.config import SceneConfig
from artrec_ros.simulation.joint_examples import joint_examples
from artrec_ros.simulation.simulator import pinhole_camera
from artrec_ros.tools.main import main

OBJECTS = Path(__file__).parents[2] / "config" / "objects"
EXCAVATOR = OBJECTS / "excavator.yaml"


def train(tmp_path, *more, model=EXCAVATOR):
    arguments = ["train", "--object", model, "--from-joints", "-o", tmp_path / "c.yaml", "--views", "200", *more]
    return main([str(a) for a in arguments])


def test_new_views_lie_within_what_was_learned(tmp_path, capsys):
    assert train(tmp_path) == 0
    assert "from its joints alone" in capsys.readouterr().out
    model = load_object(EXCAVATOR, {})
    constraints = load_constraints(tmp_path / "c.yaml", model)
    assert len(constraints.pairs) > 15
    scene = SceneConfig(distractors=0, facing=0.0, margin=0.0)
    inside = checked = 0
    for example in joint_examples(Target("e", model, 1), pinhole_camera((640, 480), 60), scene, 99, 60):
        kept = {k: i for k, i in example.items() if i.scale >= max(j.scale for j in example.values()) / 2}
        for pair in constraints.pairs:
            if pair.first in kept and pair.second in kept:
                values = configuration(kept[pair.first], kept[pair.second])
                inside += all(float(interval.excess(values[d])) <= 0 for d, interval in pair.allowed.items())
                checked += 1
    assert checked > 100 and inside / checked > 0.85


def test_pairs_that_nobody_asks_are_counted_and_listed_with_debug_alone(tmp_path, capsys):
    for more, listed in (((), False), (("--debug",), True)):
        assert train(tmp_path, "--views", "30", *more) == 0
        printed = capsys.readouterr().out
        pairs = load_constraints(tmp_path / "c.yaml", load_object(EXCAVATOR, {})).pairs
        assert "no pair is asked" in printed and f"{len(pairs)} pairs of object" in printed
        assert (f"{len(pairs)} pairs: --debug lists them" in printed) != listed
        assert ("by chance" in printed) == listed == (printed.count(" deg") > 5)
    assert train(tmp_path, "--views", "30", model=OBJECTS / "pendulum.yaml") == 1  # whose markers have no places


def test_the_same_seed_learns_the_same(tmp_path):
    texts = []
    for seed in (1, 1, 2):
        assert train(tmp_path, "--seed", seed, "--views", "30") == 0
        texts.append((tmp_path / "c.yaml").read_text())
    assert texts[0] == texts[1] != texts[2]


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (["--views", "1"], "--views: 1"),
        (["--view-angle", "500"], "--view-angle"),
        (["--size", "0.9", "0.1"], "scene.size"),
        (["--category", "walk"], "go with --annotations"),
    ],
)
def test_wrong_usage_is_told(tmp_path, capsys, more, message):
    assert train(tmp_path, *more) == 1
    assert message in capsys.readouterr().err and not (tmp_path / "c.yaml").exists()


def test_an_object_without_places_is_refused(tmp_path, capsys):
    assert train(tmp_path, model=OBJECTS / "pendulum.yaml") == 1
    assert "has no pose" in capsys.readouterr().err


def test_one_source_of_examples_is_needed(tmp_path, capsys):
    assert main(["train", "--object", str(EXCAVATOR), "-o", str(tmp_path / "c.yaml")]) == 2
    assert "--annotations --from-joints" in capsys.readouterr().err
