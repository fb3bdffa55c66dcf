"""`benchmarks/ablation.py`: what it takes away is still there to be taken."""

from pathlib import Path


def test_what_is_replaced_is_still_there(monkeypatch):
    monkeypatch.syspath_prepend(str(Path(__file__).parents[1] / "benchmarks"))
    import ablation

    climb = ablation.Climber.climb
    for take_away, _ in ablation.VARIANTS.values():
        with take_away():  # raises where a name has moved
            pass
    with ablation.VARIANTS["without the local search on votes"][0]():
        assert ablation.Climber.climb is ablation.unclimbed
    assert ablation.Climber.climb is climb
