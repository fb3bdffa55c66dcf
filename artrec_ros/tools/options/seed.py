"""Seeds of random numbers, as options give them."""

from __future__ import annotations

import argparse

_MOST = 2**31 - 1


def seed(text: str) -> int:
    """:raises ArgumentTypeError: it is none, or a negative one, which NumPy does not take."""
    if not (text.isascii() and text.isdecimal() and int(text) <= _MOST):
        raise argparse.ArgumentTypeError(f"'{text}' is no seed: a whole number of 0 to {_MOST} is wanted")
    return int(text)
