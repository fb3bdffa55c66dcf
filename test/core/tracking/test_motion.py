"""The filter of places and speeds, against the laws of the process that it assumes."""

import numpy as np
import pytest

from artrec_ros.core.tracking.motion import MotionModel, MotionState

MODEL = MotionModel(speed=0.7, steady_s=0.5)
UNIT = np.array([1.0, 1.0, 200.0])


def state(model=MODEL):
    noise = np.diag([0.01, 0.02, 3.0]) ** 2
    first = MotionState.first_seen(np.array([0.1, -0.2, 30.0]), noise, UNIT, model)
    return first.after(0.1, UNIT, model).seen(np.array([0.15, -0.2, 33.0]), noise)


def test_two_short_steps_are_one_long_one():
    once, twice = state().after(0.3, UNIT, MODEL), state().after(0.1, UNIT, MODEL).after(0.2, UNIT, MODEL)
    np.testing.assert_allclose(once.mean, twice.mean, rtol=1e-9)
    np.testing.assert_allclose(once.covariance, twice.covariance, rtol=1e-9, atol=1e-12)


def test_no_time_changes_nothing():
    after = state().after(0.0, UNIT, MODEL)
    np.testing.assert_allclose(after.mean, state().mean)
    np.testing.assert_allclose(after.covariance, state().covariance)


@pytest.mark.parametrize("dt", [1e-6, 1e-3, 0.03, 1.0, 1e4])
def test_noise_is_a_covariance(dt):
    _, noise = MODEL.step(dt)
    assert np.linalg.eigvalsh(noise).min() >= -1e-12 * np.trace(noise)
    # speeds keep their spread: what is left of the old one and what came on top
    F, Q = MODEL.step(dt)
    assert F[1, 1] ** 2 * 0.49 + Q[1, 1] == pytest.approx(0.49)


def test_noise_is_that_of_the_process():
    """Simulated in small steps."""
    rng = np.random.default_rng(0)
    place, speed, dt = np.zeros(20000), np.zeros(20000), 0.002
    for _ in range(200):
        place += speed * dt
        speed += -speed * dt / MODEL.steady_s + MODEL.speed * np.sqrt(2 * dt / MODEL.steady_s) * rng.normal(size=20000)
    np.testing.assert_allclose(np.cov(place, speed), MODEL.step(0.4)[1], rtol=0.05)


def test_a_steady_speed_is_learned_and_carried_on():
    noise = 1e-6 * np.eye(3)
    s = MotionState.first_seen(np.zeros(3), noise, UNIT, MODEL)
    for k in range(1, 11):
        s = s.after(0.05, UNIT, MODEL).seen(np.array([0.02, 0, -1.0]) * k, noise)
    expected = s.after(0.05, UNIT, MODEL).place
    np.testing.assert_allclose(expected, np.array([0.02, 0, -1.0]) * 11, rtol=0.02, atol=1e-3)


def test_measuring_makes_sure():
    before = state()
    after = before.seen(before.place, np.eye(3) * 1e-4)
    assert np.all(np.diag(after.covariance) < np.diag(before.covariance))
    np.testing.assert_allclose(after.place, before.place)
    np.testing.assert_array_less(-1e-15, np.linalg.eigvalsh(after.covariance))
