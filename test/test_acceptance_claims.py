"""The programs that fit acceptance see what the recogniser finds in made-up scenes."""

from pathlib import Path

import pytest

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"


@pytest.fixture(autouse=True)
def beside_the_programs(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))


def test_objects_in_space_become_claims_some_of_them_right():
    import acceptance_claims

    claims, _ = acceptance_claims.watch(900, 3, 3)
    assert claims.final.any() and claims.right[claims.final].any()


def test_flat_objects_become_claims_some_of_them_right():
    import acceptance_facing

    claims, parts = acceptance_facing.watch(900, 2, 4)
    assert claims.final.all() and claims.right.any() and len(parts.right)


def test_among_strays_more_of_the_claims_lack_much_and_are_wrong():
    import acceptance_facing
    from acceptance import rows_of

    (usual, _), (strewn, _) = (acceptance_facing.watch(3, 1, 8, dotted) for dotted in (None, 1.0))
    lacks = [rows_of(claims, ("lacking",))[:, 0] < -0.5 for claims in (usual, strewn)]
    assert lacks[1].sum() > lacks[0].sum() and strewn.right[lacks[1]].mean() < 0.2 < strewn.right[~lacks[1]].mean()


def test_what_strays_take_leaves_what_is_seen_whole_as_it_was():
    import numpy as np
    from acceptance_strays import fitted
    from scipy.special import expit

    rng, n = np.random.default_rng(0), 2000
    off, lacking = rng.normal(1, 2, n), rng.uniform(-0.8, 0, n)
    right = rng.random(n) < expit(off - 4 * (lacking < -0.4))
    curves, _ = fitted(lacking[:, None], right.astype(float), np.arange(n) % 20, off)
    assert curves.probability(np.array([[0.0]]), np.zeros(1)) == pytest.approx([0.5])
    assert curves.probability(np.array([[-0.7]]), np.zeros(1)) == pytest.approx(expit([-4.0]), abs=0.02)


def test_objects_that_learned_colours_show_become_claims_some_of_them_right():
    import acceptance_colour

    claims, _ = acceptance_colour.watch(901, 3, 3)
    final = claims[claims.final]
    assert final.right.any() and not final.right.all()


def test_a_world_may_have_a_background_near_its_objects_colour_that_nobody_has_named():
    import acceptance_colour

    both = [acceptance_colour.colours_of(n) for n in range(24)]
    near = [(shown, read) for shown, read in both if len(shown.background) > 3]
    assert 0 < len(near) < len(both)
    assert {read is shown for shown, read in near} == {True, False}
    assert all(read.background == shown.background[:3] for shown, read in near if read is not shown)
