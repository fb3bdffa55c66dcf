"""What `artrec studio` learns from examples: by button, as the commands do, and after each mark, in a thread."""

from __future__ import annotations

import dataclasses
import re
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from studio_pictures import Pictures
from studio_sitting import again

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.constraints.constraint_set import ConstraintSet
from artrec_ros.core.constraints.intervals import Interval
from artrec_ros.core.constraints.pairs import PairConstraint
from artrec_ros.io.parameters.parameter_file import load_parameters
from artrec_ros.tools.main import main
from artrec_ros.tools.studio_state.doubts import ranked, recognised
from artrec_ros.tools.studio_state.examples import Examples
from artrec_ros.tools.studio_state.retraining import Retraining
from artrec_ros.tools.studio_state.session import Session
from artrec_ros.tools.studio_state.settings import Settings
from artrec_ros.tools.studio_state.training import changes_of, keep_scale_limits, learn_colours, train_examples
from artrec_ros.tools.train import train


def test_training_is_that_of_the_command(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    session = again(taught, tmp_path, pictures)
    examples = Examples(session)
    with pytest.raises(ConfigError, match="no example is marked yet"):
        train_examples(session, examples)
    target = session.setup.targets[0]
    for number in range(4):
        for robot in pictures.axes(number):
            examples.new(number, target, ("team", "team"), *robot["team"])
    trained = train_examples(session, examples)
    written = tmp_path / "by_command.yaml"
    arguments = ["--object", str(pictures.folder / "robot.yaml"), "--annotations", str(examples.path)]
    assert main(["train", *arguments, "-o", str(written)]) == 0
    assert trained is not None and trained.written[0].read_text() == written.read_text()
    assert "robot: 1 pairs, the first constraints" in [c.line for c in trained.changes]
    assert load_parameters(session.parameters).targets[0].constraints is not None
    examples.with_axis(examples.objects[0], ("accent", "accent"), np.array([9.0, 9.0]), np.array([30.0, 9.0]))
    trained = train_examples(session, examples)
    assert trained is not None and any("accent/accent: distance_m" in c.line for c in trained.changes)
    assert "more ranges changed" in trained.headline and max(c.moved for c in trained.changes) > 0.5


@pytest.mark.parametrize(("by", "line"), [(1e-6, "no range changed"), (2e-3, "distance_m 0.0353..0.0353 -> 0.0373")])
def test_what_no_image_resolves_is_no_change(pictures: Pictures, by: float, line: str) -> None:
    (target,) = load_parameters(pictures.parameters).targets

    def learned(distance: float) -> ConstraintSet:
        box = {"distance_m": Interval(distance, distance + 1e-7)}
        return ConstraintSet("robot", 0.95, (PairConstraint(("team", "team"), ("accent", "accent"), 9, box, box),))

    before = dataclasses.replace(target, constraints=learned(0.0353))
    (change,) = changes_of(before, learned(0.0353 + by))
    assert line in change.line


def test_examples_give_colours_and_limits_of_the_scale(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    session = again(taught, tmp_path, pictures)
    examples = Examples(session)
    for learn in (learn_colours, keep_scale_limits):
        with pytest.raises(ConfigError, match="no example is marked yet"):
            learn(session, examples)
    for number in (0, 1):
        for robot in pictures.axes(number):
            examples.new(number, session.setup.targets[0], ("team", "team"), *robot["team"])
    learned = learn_colours(session, examples)
    assert learned is not None and min(learned.right.values()) > 0.9
    written = tmp_path / "by_command.yaml"
    arguments = ["--annotations", str(examples.path), "--params-file", str(pictures.parameters)]
    assert main(["learn-colours", *arguments, "-o", str(written)]) == 0
    assert written.read_text() == (session.folder / "colours.yaml").read_text()
    limits = keep_scale_limits(session, examples)
    kept = load_parameters(session.parameters).recognizer
    assert (kept.min_scale, kept.max_scale) == (limits.low, limits.high)
    assert f"recognizer.min_scale {limits.low:.4g} and max_scale {limits.high:.4g}" in learned.lines[-1]
    assert str(limits).endswith("they rest on 6 alone: mark nearer and farther ones, and press again")


@pytest.fixture
def grouped(pictures: Pictures, taught: Session, tmp_path: Path) -> Session:
    """A sitting in which components are put together by learned constraints."""
    session = again(taught, tmp_path, pictures)
    session.keep({"recognizer.whole_object": False})
    return session


@contextmanager
def learning(session: Session, examples: Examples, settle_s: float = 0.05) -> Iterator[Retraining]:
    retraining = Retraining(session, examples, settle_s)
    try:
        yield retraining
    finally:
        retraining.close()


def mark(pictures: Pictures, examples: Examples, session: Session, *numbers: int) -> None:
    for number in numbers:
        for robot in pictures.axes(number):
            examples.new(number, session.setup.targets[0], ("team", "team"), *robot["team"])


def wait_for(retraining: Retraining) -> str:
    """Until nothing goes on; what is told then."""
    end = time.monotonic() + 120
    while not retraining.is_idle:
        assert time.monotonic() < end, retraining.told
        time.sleep(0.02)
    return retraining.told.line


def test_each_mark_is_learned_from_soon_and_what_changed_is_told(pictures: Pictures, grouped: Session) -> None:
    examples = Examples(grouped)
    with learning(grouped, examples) as retraining:
        retraining.queue = ranked(grouped, examples, recognised(grouped, range(6), lambda share: None))
        mark(pictures, examples, grouped, 0)
        told = wait_for(retraining)
        assert told.startswith("robot: 1 pairs, the first constraints; of ")
        assert "proposals in the 6 frames that wait first, " not in told, "a marked frame waits no more"
        assert re.search(r"of \d+ proposals in the 5 frames that wait first, \d+ new", told)
        assert load_parameters(grouped.parameters).targets[0].constraints is not None
        assert retraining.told.learned == 1
        assert {d.number for d in retraining.queue} == {1, 2, 3, 4, 5}
        examples.moved(examples.objects[0], "accent/accent.head", examples.objects[0].points["accent/accent.head"] + 9)
        told = wait_for(retraining)
        assert "accent/accent" in told and " -> " in told and "(3 -> 3 examples)" in told and "proposals" in told
        written = (grouped.folder / "robot_constraints.yaml").read_text()
    by_button = train_examples(grouped, examples)
    assert by_button is not None and by_button.written[0].read_text() == written, "as the button does"


def test_marks_that_come_together_are_learned_from_once(pictures: Pictures, grouped: Session) -> None:
    examples = Examples(grouped)
    with learning(grouped, examples, 0.5) as retraining:
        mark(pictures, examples, grouped, 0, 1, 2)
        assert retraining.told.learned == 0
        wait_for(retraining)
        assert retraining.told.learned == 1


def test_stopping_leaves_what_was_there(pictures: Pictures, grouped: Session, monkeypatch: pytest.MonkeyPatch) -> None:
    examples, begun = Examples(grouped), threading.Event()
    before, go_on = grouped.parameters.read_text(), threading.Event()

    def slow(*arguments: Any) -> Any:
        begun.set()
        assert go_on.wait(60)
        return train(*arguments)

    with learning(grouped, examples) as retraining:
        monkeypatch.setattr("artrec_ros.tools.studio_state.training.train", slow)
        mark(pictures, examples, grouped, 0)
        assert begun.wait(60)
        assert grouped.recognise(0).size == (320, 240), "what a person asks for is answered meanwhile"
        retraining.stop()
        go_on.set()
        assert wait_for(retraining).startswith("stopped")
        assert grouped.parameters.read_text() == before and not (grouped.folder / "robot_constraints.yaml").exists()
        mark(pictures, examples, grouped, 1)
        assert wait_for(retraining).startswith("robot: 1 pairs"), "the next mark learns again"


def test_a_mark_ends_the_sorting_for_the_one_before(
    pictures: Pictures, grouped: Session, monkeypatch: pytest.MonkeyPatch
) -> None:
    examples = Examples(grouped)
    looked_at: list[int] = []
    begun, go_on, recognise = threading.Event(), threading.Event(), grouped.recognise

    def slow(number: int, *more: Any) -> Any:
        looked_at.append(number)
        begun.set()
        assert go_on.wait(60)
        return recognise(number, *more)

    with learning(grouped, examples) as retraining:
        retraining.queue = ranked(grouped, examples, recognised(grouped, range(6), lambda share: None))
        monkeypatch.setattr(grouped, "recognise", slow)
        mark(pictures, examples, grouped, 0)
        assert begun.wait(60)
        mark(pictures, examples, grouped, 1)
        go_on.set()
        assert "proposals in the 4 frames that wait first" in wait_for(retraining)
        assert retraining.told.learned == 2 and len(looked_at) == 1 + 4 + 6, "the first round was ended"
        assert {d.number for d in retraining.queue} == {2, 3, 4, 5}


def test_what_cannot_be_learned_is_told_in_a_line(pictures: Pictures, grouped: Session) -> None:
    examples = Examples(grouped)
    with learning(grouped, examples) as retraining:
        examples.new(0, grouped.setup.targets[0], ("team", "team"), *pictures.axes(0)[0]["team"])
        assert wait_for(retraining).startswith("nothing learned: of 1 annotations, 1 show a marker of object 'robot'")
        assert not (grouped.folder / "robot_constraints.yaml").exists() and retraining.told.learned == 0


def test_what_cannot_be_learned_keeps_nothing_else_from_it(pictures: Pictures, grouped: Session) -> None:
    examples = Examples(grouped)
    with learning(grouped, examples) as retraining:
        retraining.colours = True
        mark(pictures, examples, grouped, 0)
        (grouped.folder / "colours.yaml").unlink(missing_ok=True)
        (grouped.folder / "colours.yaml").mkdir()  # it cannot be written
        told = wait_for(retraining)
        assert told.startswith("robot: 1 pairs, the first constraints; nothing learned: ") and "colours.yaml" in told
        assert retraining.told.learned == 1


def test_objects_found_as_a_whole_learn_colours(pictures: Pictures, taught: Session, tmp_path: Path) -> None:
    session = again(taught, tmp_path, pictures)
    examples = Examples(session)
    with learning(session, examples) as retraining:
        mark(pictures, examples, session, 0)
        assert wait_for(retraining).endswith("constraints change nothing") and retraining.told.learned == 0
        retraining.colours = True
        mark(pictures, examples, session, 1)
        assert re.fullmatch(r"colours: team \d+%, accent \d+% of the marked pixels told right", wait_for(retraining))
        mark(pictures, examples, session, 2)
        assert wait_for(retraining).startswith("colours: ") and retraining.told.learned == 2
        retraining.colours = retraining.constraints = False
        mark(pictures, examples, session, 3)
        assert retraining.is_idle, "nothing is switched on"


def test_parameters_that_are_tried_go_on_from_what_was_learned(pictures: Pictures, grouped: Session) -> None:
    settings = Settings(grouped)
    settings.change("recognizer.min_probability", 0.7)
    mark(pictures, examples := Examples(grouped), grouped, 0)
    train_examples(grouped, examples)
    assert settings.tried.targets[0].constraints is not None and settings.tried.recognizer.min_probability == 0.7
    settings.reset()
    assert settings.tried is grouped.setup
