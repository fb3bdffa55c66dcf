"""The program that fits the covariance's numbers finds those that errors were made with."""

from pathlib import Path

import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import Pose, rotation_from_rotvec

BENCHMARKS = Path(__file__).parents[1] / "benchmarks"
MADE = np.array([0.6, 0.4, 0.8, 0.3, 1.5])
NUMBER = 1


@pytest.fixture(autouse=True)
def beside_the_program(monkeypatch):
    monkeypatch.syspath_prepend(str(BENCHMARKS))


def errors(count, seed=0):
    """Of made-up sources, in metres and radians of a few thousandths."""
    from covariance_fit import CHOICES, SHARES, Errors, covariances

    rng = np.random.default_rng(seed)
    rows = rng.normal(0, 3e-3, (count, len(CHOICES), len(SHARES), 7, 6))
    parts = rows.swapaxes(-1, -2) @ rows
    none = np.zeros(0)
    found = Errors(
        world=np.zeros(count),
        seam_px=rng.uniform(0, 1, count),
        range_m=np.ones(count),
        error=np.zeros((count, 6)),
        parts=parts,
        joint_world=none,
        joint_seam_px=none,
        joint_error=none,
        joint_parts=np.zeros((0, *parts.shape[1:3])),
        off=np.array([0]),
    )
    C = covariances(MADE, found, NUMBER)
    found.error[:] = np.einsum("nij,nj->ni", np.linalg.cholesky(C), rng.normal(size=(count, 6)))
    return found, C


def test_the_shares_that_made_the_errors_are_found():
    from covariance_fit import covariances, fitted, squared

    found, made = errors(1500)
    shares = fitted(found, NUMBER)
    np.testing.assert_allclose(shares[[0, 2]], MADE[[0, 2]], rtol=0.3)
    told = covariances(shares, found, NUMBER)
    ratio = np.trace(told, axis1=1, axis2=2) / np.trace(made, axis1=1, axis2=2)
    assert np.percentile(ratio, 5) > 0.9 and np.percentile(ratio, 95) < 1.1
    assert np.mean(squared(found.error, told)) == pytest.approx(6, abs=0.4)


def test_what_is_far_off_is_something_else():
    from covariance_fit import error_of

    truth = Pose(np.eye(3), np.array([0.1, 0.0, 1.0]))
    turned = rotation_from_rotvec([0.0, 0.2, 0.0])
    np.testing.assert_allclose(error_of(Pose(turned, truth.position + 0.01), truth), [0.01, 0.01, 0.01, 0, 0.2, 0])
    assert error_of(Pose(rotation_from_rotvec([0.0, 0.5, 0.0]), truth.position), truth) is None
    assert error_of(Pose(np.eye(3), 1.2 * truth.position), truth) is None
