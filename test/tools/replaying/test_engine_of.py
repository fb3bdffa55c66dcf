"""Who does the work of a command, by its options."""

from __future__ import annotations

from argparse import Namespace

import pytest

from artrec_ros.tools.options import work_options
from artrec_ros.tools.options.work_options import engine_of
from artrec_ros.tools.replaying.engines import InlineEngine
from artrec_ros.tools.replaying.processes import ProcessEngine


@pytest.mark.parametrize(
    ("jobs", "kept", "kind", "said"),
    [(1, True, InlineEngine, ""), (2, True, ProcessEngine, ""), (1, False, InlineEngine, ""),
     (2, False, InlineEngine, "warning: no 2 workers: each would compile anew")],
)  # fmt: skip
def test_where_compiled_code_cannot_be_kept_one_process_works_alone(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], jobs: int, kept: bool, kind: type, said: str
) -> None:
    monkeypatch.setattr(work_options, "is_kept", lambda: kept, raising=False)
    with engine_of(Namespace(jobs=jobs, scheduler=None)) as engine:
        assert type(engine) is kind
    told = capsys.readouterr().err
    assert said in told and bool(told) == bool(said)
