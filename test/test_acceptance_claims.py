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
