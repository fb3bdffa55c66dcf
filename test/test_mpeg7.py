"""Single rigid markers on third-party silhouettes: rotation and scale are measured to a fraction of a degree."""

from __future__ import annotations

import os
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[1]
DATA = Path(os.environ.get("ARTREC_SHARED", ROOT.parent / "shared")) / "data" / "mpeg7"


@pytest.mark.skipif(not DATA.is_dir(), reason="the silhouettes are not here")
def test_turned_and_scaled_silhouettes_are_measured(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(ROOT / "benchmarks"))
    import mpeg7

    for folder in ("scale", "rotation"):
        (tmp_path / folder).mkdir()
        for name in ("cup", "lizzard", "device2"):  # without, and with a symmetry of order 8
            for path in (DATA / folder).glob(f"{name}-*.png"):
                (tmp_path / folder / path.name).symlink_to(path.resolve())
    rows = mpeg7.measure_all(tmp_path)
    sys.modules.pop("mpeg7")
    assert len(rows) == 30
    for row in rows:
        if row.scale >= 0.25:
            assert row.right, row
