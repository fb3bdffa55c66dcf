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
