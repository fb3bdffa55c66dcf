"""Compiled code means what it says as plain Python: tests marked `uncompiled` pass without the compiler too."""

import os
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from artrec_ros.core.base import jit

HERE = Path(__file__).parent


@pytest.mark.uncompiled
def test_the_compiler_is_off_where_the_environment_says_so():
    off = os.environ.get("NUMBA_DISABLE_JIT") == "1"
    assert bool(numba.config.DISABLE_JIT) == off
    for decorate in (jit.jit, jit.lean, jit.inlined):

        def one(x):
            return x

        assert (decorate(one) is one) == off


@pytest.mark.skipif(os.environ.get("NUMBA_DISABLE_JIT") == "1", reason="this is the run without the compiler")
def test_kernels_as_plain_python():
    command = [sys.executable, "-m", "pytest", "-q", "-m", "uncompiled", "-p", "no:cacheprovider", str(HERE)]
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    done = subprocess.run(command, env=environment, cwd=HERE.parents[1], capture_output=True, text=True, timeout=600)
    assert done.returncode == 0, done.stdout[-5000:] + done.stderr
