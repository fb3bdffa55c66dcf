"""Results of the compiler on disk."""

from artrec_ros.core.base import jit


def test_results_are_kept_until_any_of_the_sources_changes(tmp_path):
    source, kept = tmp_path / "one.py", tmp_path / "__pycache__" / "two.f-1.py311.nbi"
    source.write_text("a = 1")
    jit.forget_stale(tmp_path)
    kept.write_text("compiled")
    jit.forget_stale(tmp_path)
    assert kept.exists()
    source.write_text("a = 2")
    jit.forget_stale(tmp_path)
    assert not kept.exists()
