"""Rows of arrays, however they are told."""

import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import rows_of


@pytest.mark.parametrize(
    "index", [slice(1, 3), [2, 0], [], np.array([4, 4, 1]), np.array([], int), np.arange(5) > 2, np.zeros(5, bool)]
)
def test_rows_are_those_that_an_index_gives(index):
    R, q, votes = np.arange(45.0).reshape(5, 3, 3), np.zeros((5, 0)), np.arange(5)
    number = index if not isinstance(index, list) else np.array(index, int)
    for found, of in zip(rows_of(index, R, q, votes), (R, q, votes), strict=True):
        np.testing.assert_array_equal(found, of[number])
        assert found.shape == of[number].shape and found.dtype == of.dtype
