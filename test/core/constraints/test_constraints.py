import numpy as np
import pytest
from scene import Placed, capsule, crane, crane_placed, disc, flag, polygon, rectangle

from artrec_ros.core.base.errors import ConfigError
from artrec_ros.core.constraints.constraint_set import ConstraintSet
from artrec_ros.core.constraints.pairs import configuration
from artrec_ros.core.learning.pair_learning import learn
from artrec_ros.core.model.objects import Component, ObjectModel


def examples(count=40, seed=0):
    rng = np.random.default_rng(seed)
    return [
        crane_placed(
            *rng.uniform(50, 500, 2), rng.uniform(-4, 4), rng.uniform(20, 90), tuple(rng.uniform(-0.5, 0.5, 2))
        )
        for _ in range(count)
    ]


def test_configuration_is_invariant_under_similarity():
    one, other = (crane_placed(10, 20, a, k, (0.3, -0.2)) for a, k in ((0.0, 10.0), (2.5, 77.0)))
    keys = [("base", "flag"), ("fore", "bar")]
    a, b = (configuration(*(placed[k] for k in keys)) for placed in (one, other))
    for dimension in ("distance_m", "offset_x_m", "offset_y_m", "bearing_rad", "turn_rad", "scale_ratio"):
        assert float(a[dimension]) == pytest.approx(float(b[dimension]))
    assert float(a["distance_px"]) != pytest.approx(float(b["distance_px"]))


def test_learned_boxes_hold_their_examples_once_per_pair():
    rows = examples()
    constraints = learn(crane(), rows)
    assert [(p.first[0], p.second[0]) for p in constraints.pairs] == [
        ("base", "fore"),
        ("base", "aft"),
        ("fore", "aft"),
    ]
    for p in constraints.pairs:
        assert p.examples == 40
        assert 0.8 < p.coverage_seen < 0.85  # (39/41)^4
        for row in rows:
            T = configuration(row[p.first], row[p.second])
            for box in (p.seen, p.allowed):
                for dimension, interval in box.items():
                    assert interval.excess(T[dimension]) < 1e-9


def test_margin_holds_the_promised_share_of_new_examples():
    model, inside, count = crane(), 0, 0
    for seed in range(30):
        p = learn(model, examples(15, seed), coverage=0.9).pairs[0]
        for row in examples(20, 1000 + seed):
            T = configuration(row[p.first], row[p.second])
            # learned and tested without noise: ratios are 1 up to rounding
            inside += all(i.excess(T[d]) < 1e-9 for d, i in p.allowed.items())
            count += 1
    assert inside / count > 0.88


def test_bare_box_for_coverage_zero():
    p = learn(crane(), examples(), coverage=0.0).pairs[0]
    assert all(p.allowed[d] == p.seen[d] for d in p.allowed)


def test_pairs_never_seen_together_are_not_constrained():
    rows = [{k: v for k, v in row.items() if k[0] != ("fore", "aft")[n % 2]} for n, row in enumerate(examples())]
    constraints = learn(crane(), rows)
    assert constraints.pair(("base", "flag"), ("fore", "bar")).examples == 20
    assert constraints.pair(("fore", "bar"), ("aft", "bar")) is None
    assert learn(crane(), []).pairs == ()


def test_discs_constrain_no_direction():
    model = ObjectModel(
        "eye",
        (
            Component("spot", (disc("spot", 0.1),), required=True),
            Component("body", (flag(),)),
            Component("other", (disc("spot", 0.1),)),
        ),
    )
    rng = np.random.default_rng(0)
    rows = []
    for _ in range(20):
        body = Placed(100, 100, rng.uniform(-3, 3), 50)
        rows.append(
            {
                ("body", "flag"): body,
                ("spot", "spot"): body.moved(0.5, 0.1, rng.uniform(-3, 3)),
                ("other", "spot"): body.moved(-0.5, 0.3, rng.uniform(-3, 3)),
            }
        )
    constraints = learn(model, rows)
    directed = constraints.pair(("body", "flag"), ("spot", "spot"))  # seen from the one that has a direction
    assert set(directed.allowed) == {"distance_m", "bearing_rad", "scale_ratio"}
    assert directed.allowed["bearing_rad"].width < 1e-6
    assert set(constraints.pair(("spot", "spot"), ("other", "spot")).allowed) == {"distance_m", "scale_ratio"}


def test_offset_replaces_bearing_where_centroids_coincide():
    model = ObjectModel(
        "cross",
        (
            Component("a", (rectangle("a", 1.0, 0.2),), required=True),
            Component("b", (capsule("b", 0.1, 0.8),)),
        ),
    )
    rng = np.random.default_rng(0)
    rows = []
    for _ in range(20):
        a = Placed(50, 50, rng.uniform(-3, 3), 40)
        rows.append({("a", "a"): a, ("b", "b"): a.moved(*rng.uniform(-0.02, 0.02, 2), 0.5)})
    p = learn(model, rows).pairs[0]
    assert set(p.allowed) == {"offset_x_m", "offset_y_m", "turn_rad", "scale_ratio"}
    assert -0.03 < p.allowed["offset_x_m"].low < 0 < p.allowed["offset_x_m"].high < 0.03


def test_directions_given_at_random_are_taken_modulo_the_symmetry():
    model = ObjectModel(
        "patches",
        (
            Component("a", (rectangle("square", 1.0, 1.0),), required=True),
            Component("b", (flag(),)),
        ),
    )
    rng = np.random.default_rng(0)

    def rows(turns):
        for _ in range(30):
            base = Placed(50, 50, rng.uniform(-3, 3), 40)
            yield {
                ("a", "square"): base.moved(0, 0, np.pi / 2 * rng.integers(turns)),
                ("b", "flag"): base.moved(1.2, 0.3, 0.5),
            }

    told = learn(model, list(rows(1))).pairs[0].allowed["bearing_rad"]
    random = learn(model, list(rows(4))).pairs[0].allowed["bearing_rad"]
    assert told.period == pytest.approx(2 * np.pi)
    assert random.period == pytest.approx(np.pi / 2)
    assert random.width < 0.1


def triangle(side=0.6):
    corners = side / np.sqrt(3) * np.exp(2j * np.pi * np.arange(3) / 3)
    return polygon("triangle", *zip(corners.real, corners.imag, strict=True))


BAR_AND_TRIANGLE = ObjectModel(
    "pair", (Component("bar", (rectangle("bar", 1.0, 0.2),), required=True), Component("tri", (triangle(),)))
)


def bars_and_triangles(spread, bar_turns, triangle_turns, count=60):
    """A bar that looks the same after half a turn, a triangle that does after a third, each told so many ways."""
    rng = np.random.default_rng(0)
    for _ in range(count):
        bar = Placed(50, 50, rng.uniform(-3, 3), 40)
        turn = 0.3 + rng.uniform(-spread / 2, spread / 2) + 2 * np.pi / 3 * rng.integers(triangle_turns)
        yield {
            ("bar", "bar"): bar.moved(0, 0, np.pi * rng.integers(bar_turns)),
            ("tri", "triangle"): bar.moved(1.2, 0.3, turn),
        }


@pytest.mark.parametrize("bar_turns, triangle_turns", [(2, 3), (2, 1), (1, 3)])
def test_two_symmetries_leave_a_turn_known_modulo_the_turns_that_they_make_together(bar_turns, triangle_turns):
    (pair,) = learn(BAR_AND_TRIANGLE, list(bars_and_triangles(0.1, bar_turns, triangle_turns))).pairs
    turn = pair.allowed["turn_rad"]
    assert turn.period == pytest.approx(2 * np.pi / 6)
    assert 0.05 < turn.width < 0.2
    every = 0.3 + np.pi * np.arange(2)[:, None] + 2 * np.pi / 3 * np.arange(3)
    assert (turn.excess(every) == 0).all() and (turn.excess(every + np.pi / 6) > 0.3).all()


@pytest.mark.parametrize("bar_turns, triangle_turns, order", [(2, 1, 2), (1, 3, 3)])
def test_where_the_turns_together_are_too_fine_those_of_one_marker_remain(bar_turns, triangle_turns, order):
    """A turn that spreads by 1 rad fills the sixth of a circle."""
    (pair,) = learn(BAR_AND_TRIANGLE, list(bars_and_triangles(1.0, bar_turns, triangle_turns))).pairs
    turn = pair.allowed["turn_rad"]
    assert turn.period == pytest.approx(2 * np.pi / order)
    assert 0.9 < turn.width < 1.3


def test_a_turn_that_only_spreads_keeps_its_full_circle():
    (pair,) = learn(BAR_AND_TRIANGLE, list(bars_and_triangles(1.2, 1, 1))).pairs
    assert pair.allowed["turn_rad"].period == pytest.approx(2 * np.pi)
    assert 1.0 < pair.allowed["turn_rad"].width < 1.5


def test_round_trip_through_plain_values():
    constraints = learn(crane(), examples())
    again = ConstraintSet.from_dict(constraints.to_dict())
    assert again.to_dict() == constraints.to_dict()
    for p, q in zip(constraints.pairs, again.pairs, strict=True):
        for d in p.allowed:
            assert q.allowed[d].low == pytest.approx(p.allowed[d].low, abs=1e-6)
            assert q.allowed[d].period == pytest.approx(p.allowed[d].period)


def damaged(change):
    values = learn(crane(), examples()).to_dict()
    change(values)
    return values


@pytest.mark.parametrize(
    ("change", "named"),
    [
        (lambda v: v.pop("pairs"), "pairs"),
        (lambda v: v["pairs"][1].pop("first"), r"pairs\[1\]"),
        (lambda v: v["pairs"][0].update(first="base"), r"pairs\[0\]"),
        (lambda v: v["pairs"][0]["allowed"].update(distance_m=[2.0, 1.0]), "distance_m"),
        (lambda v: v["pairs"][0]["allowed"].update(distance_m=[float("nan"), 1.0]), "distance_m"),
        (lambda v: v["pairs"][0]["allowed"].update(height=[0, 1]), "height"),
        (lambda v: v["pairs"][0]["allowed"].update(turn_rad=[0, 1, 0]), "turn_rad: its period 0 must be 2 pi over"),
        (lambda v: v["pairs"][0]["allowed"].update(turn_rad=[0, 1, 2]), "turn_rad: its period 2 must be 2 pi over"),
        (lambda v: v["pairs"][0]["allowed"].update(turn_rad=[0, 1, float("nan")]), "turn_rad: its period nan"),
        (lambda v: v["pairs"].append(v["pairs"][0]), "twice"),
    ],
)
def test_damaged_values_are_refused_by_name(change, named):
    with pytest.raises(ConfigError, match=named):
        ConstraintSet.from_dict(damaged(change))


def test_constraints_of_another_model_are_refused():
    constraints = learn(crane(), examples())
    other = ObjectModel("other", (Component("base", (flag(),), required=True),))
    with pytest.raises(ConfigError, match="fore/bar"):
        constraints.check_model(other)
