"""The filter of places and speeds, against the laws of the process that it assumes."""

import numpy as np
import pytest

from artrec_ros.core.geometry.transforms import rotation_from_rotvec, rotvec_from_rotation
from artrec_ros.core.tracking.motion import Bodies, MotionModel, MotionState, calmed

MODEL = MotionModel(speed=0.7, steady_s=0.5)
UNIT = np.array([[1.0, 1.0, 200.0], [1.0, 2.0, 3.0]])
NOISE = np.stack([np.diag([0.01, 0.02, 3.0]) ** 2, np.diag([0.02, 0.01, 0.1]) ** 2])


def state(model=MODEL):
    """Two things that were seen twice."""
    places = np.array([[0.1, -0.2, 30.0], [0.0, 0.0, 1.0]])
    first = MotionState.first_seen(places, NOISE, UNIT, model)
    return first.after(0.1, model).seen(places + [[0.05, 0, 3.0]], NOISE)


def plain(s, row):
    """Mean (2 n) and covariance (2 n, 2 n) of one thing, as textbooks have them."""
    n = s.mean.shape[2]
    return s.mean[row].reshape(-1), s.covariance[row].transpose(0, 2, 1, 3).reshape(2 * n, 2 * n)


def test_two_short_steps_are_one_long_one():
    once, twice = state().after(0.3, MODEL), state().after(0.1, MODEL).after(0.2, MODEL)
    np.testing.assert_allclose(once.mean, twice.mean, rtol=1e-9)
    np.testing.assert_allclose(once.covariance, twice.covariance, rtol=1e-9, atol=1e-12)


def test_no_time_changes_nothing():
    after = state().after(0.0, MODEL)
    np.testing.assert_allclose(after.mean, state().mean)
    np.testing.assert_allclose(after.covariance, state().covariance)


def test_it_is_kalmans_filter():
    """Against the textbook's, one thing and one matrix at a time."""
    F, Q = MODEL.step(0.2)
    later = state().after(0.2, MODEL)
    measured = later.place + [[0.01, 0.02, 1.0], [0.0, -0.01, 0.02]]
    seen = later.seen(measured, NOISE)
    for row in range(2):
        x, P = plain(state(), row)
        big, H = np.kron(F, np.eye(3)), np.eye(3, 6)
        x, P = big @ x, big @ P @ big.T + np.kron(Q, np.diag(UNIT[row] ** 2))
        np.testing.assert_allclose(plain(later, row)[1], P, rtol=1e-9, atol=1e-15)
        K = P @ H.T @ np.linalg.inv(H @ P @ H.T + NOISE[row])
        np.testing.assert_allclose(plain(seen, row)[0], x + K @ (measured[row] - H @ x), rtol=1e-9)
        np.testing.assert_allclose(plain(seen, row)[1], (np.eye(6) - K @ H) @ P, rtol=1e-9, atol=1e-12)


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
    noise = 1e-6 * np.eye(3)[None]
    s = MotionState.first_seen(np.zeros((1, 3)), noise, UNIT[:1], MODEL)
    for k in range(1, 11):
        s = s.after(0.05, MODEL).seen(np.array([[0.02, 0, -1.0]]) * k, noise)
    expected = s.after(0.05, MODEL).place
    np.testing.assert_allclose(expected[0], np.array([0.02, 0, -1.0]) * 11, rtol=0.02, atol=1e-3)


def test_measuring_makes_sure():
    before = state()
    after = before.seen(before.place, np.stack([np.eye(3) * 1e-4] * 2))
    np.testing.assert_allclose(after.place, before.place)
    for row in range(2):
        assert np.all(np.diag(plain(after, row)[1]) < np.diag(plain(before, row)[1]))
        np.testing.assert_array_less(-1e-15, np.linalg.eigvalsh(plain(after, row)[1]))


def test_rotation_vectors():
    rng = np.random.default_rng(1)
    vectors = np.concatenate([rng.normal(0, 1, (50, 3)), rng.normal(0, 1e-9, (5, 3)), np.zeros((1, 3))])
    vectors = vectors[np.linalg.norm(vectors, axis=1) < 3]
    R = rotation_from_rotvec(vectors)
    for v, own in zip(vectors, R, strict=True):
        np.testing.assert_allclose(own, rotation_from_rotvec(v), atol=1e-12)
    np.testing.assert_allclose(rotvec_from_rotation(R), vectors, atol=1e-9)
    halves = np.pi * np.array([[1.0, 0, 0], [0, -1.0, 0], [0.6, 0, 0.8], [-0.48, 0.64, 0.6]])
    for found, half in zip(rotvec_from_rotation(rotation_from_rotvec(halves)), halves, strict=True):
        assert min(np.abs(found - half).max(), np.abs(found + half).max()) < 1e-6
    assert np.linalg.norm(rotvec_from_rotation(np.diag([1.0, -1.0, -1.0]))) == np.pi


BODY_UNIT = np.array([[1.0, 1.0, 1.0, 2.0, 2.0, 2.0]])


def seen_bodies(rng, steps, speed, spin, noise, dt=1 / 30):
    """A body that moves and turns steadily, measured with noise: after each step the filter's, and the truth."""
    L, place, turn = np.linalg.cholesky(noise), np.array([0.1, 0.0, 1.5]), np.eye(3)
    body = None
    for _ in range(steps):
        place, turn = place + dt * speed, rotation_from_rotvec(dt * spin) @ turn
        e = L @ rng.normal(size=6)
        measured = (place + e[:3])[None], (rotation_from_rotvec(e[3:]) @ turn)[None]
        if body is None:
            body = Bodies.first_seen(*measured, noise[None], BODY_UNIT, MODEL)
        else:
            body = body.after(dt, MODEL).seen(*measured, noise[None])
        yield body, place, turn


def test_constant_velocity_and_spin_are_recovered():
    rng, noise = np.random.default_rng(0), np.diag([0.003] * 3 + [0.02] * 3) ** 2
    speed, spin = np.array([0.3, -0.1, 0.2]), np.array([0.0, 1.5, 0.5])
    steps = list(seen_bodies(rng, 120, speed, spin, noise))
    rates = np.mean([body.motion.mean[0, 1] for body, _, _ in steps[30:]], axis=0)  # one alone is noisy
    np.testing.assert_allclose(rates, [*speed, *spin], rtol=0.15, atol=0.05)
    off = np.array([body.error(place[None], turn[None])[0] for body, place, turn in steps[30:]])
    assert np.sqrt(np.mean(off**2, axis=0) / np.diag(noise)).max() < 1  # better than what was measured
    body, _, _ = steps[-1]
    np.testing.assert_array_equal(body.motion.place[0, 3:], 0)  # the turn is where turns are


def test_the_filter_is_consistent():
    """Normalised estimation error squared of bodies that move as the model says: 6 on average (Bar-Shalom, 5.4)."""
    rng, dt, n = np.random.default_rng(2), 1 / 30, 60
    A = rng.normal(size=(6, 6)) * ([0.004] * 3 + [0.03] * 3)
    noise = A.T @ A + np.diag([0.002] * 3 + [0.01] * 3) ** 2
    L, (F, Q) = np.linalg.cholesky(noise), MODEL.step(dt)
    S = np.linalg.cholesky(Q + 1e-18 * np.eye(2))
    place, turn, rate = np.zeros((n, 3)) + [0, 0, 2.0], np.stack([np.eye(3)] * n), MODEL.speed * rng.normal(size=(n, 6))
    rate *= BODY_UNIT
    unit, noises, nees, body = np.repeat(BODY_UNIT, n, axis=0), np.stack([noise] * n), [], None
    for k in range(40):
        kick = rng.normal(size=(n, 6, 2)) @ S.T * unit[..., None]
        step = F[0, 1] * rate + kick[..., 0]
        rate = F[1, 1] * rate + kick[..., 1]
        place, turn = place + step[:, :3], rotation_from_rotvec(step[:, 3:]) @ turn
        e = rng.normal(size=(n, 6)) @ L.T
        measured = place + e[:, :3], rotation_from_rotvec(e[:, 3:]) @ turn
        if body is None:
            body = Bodies.first_seen(*measured, noises, unit, MODEL)
        else:
            body = body.after(dt, MODEL).seen(*measured, noises)
        if k >= 10:
            off = body.error(place, turn)
            nees.append((off * np.linalg.solve(body.motion.place_covariance, off[..., None])[..., 0]).sum(axis=1))
    assert 5.5 < np.mean(nees) < 6.5


def test_who_moves_little_is_expected_to():
    rng, noise, most = np.random.default_rng(3), np.diag([0.002] * 3 + [0.01] * 3) ** 2, BODY_UNIT
    still = Bodies.first_seen(np.zeros((1, 3)), np.eye(3)[None], noise[None], BODY_UNIT, MODEL)
    quick = still
    for k in range(1, 90):
        e = rng.normal(0, 0.002, (1, 3))
        still = still.after(1 / 30, MODEL).seen(e, np.eye(3)[None], noise[None])
        quick = quick.after(1 / 30, MODEL).seen(e + [[0.03 * k, 0, 0]], np.eye(3)[None], noise[None])
        still, quick = (Bodies(calmed(b.motion, 1 / 30, most, 3, MODEL, 0.2), b.turn) for b in (still, quick))
    assert (still.motion.unit[0, :3] < 0.3).all() and (still.motion.unit >= 0.2 * most - 1e-12).all()
    assert (quick.motion.unit[0, :3] > 0.6).all() and (quick.motion.unit[0, 3:] < 0.6).all()
    assert np.trace(still.motion.place_covariance[0]) < np.trace(quick.motion.place_covariance[0])
