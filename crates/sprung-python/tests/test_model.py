"""The functions of the identified robot obey mechanics."""

from __future__ import annotations

import numpy as np
import pytest

import sprung

RANDOM = np.random.default_rng(1)
STATES = [RANDOM.normal(size=(50, 2)) for _ in range(6)]


def test_regressor_times_parameters_is_the_torque(result: sprung.Result) -> None:
    model = result.model
    q, dq, ddq, phi, dphi, ddphi = STATES
    regressor = model.regressor(q, dq, ddq, phi, dphi, ddphi)
    assert regressor.shape == (50, 4, 15)
    torques = model.predict(q, dq, ddq, phi, dphi, ddphi)
    product = regressor @ np.array(list(model.parameters.values()))
    assert np.allclose(product, np.hstack(torques), rtol=1e-12, atol=1e-12)


def test_forward_dynamics_is_the_inverse(result: sprung.Result) -> None:
    model = result.model
    q, dq, ddq, phi, dphi, ddphi = STATES
    link, motor = model.predict(q, dq, ddq, phi, dphi, ddphi)
    found = model.forward_dynamics(q, dq, motor, phi, dphi, link)
    assert np.allclose(found.ddq, ddq, rtol=1e-9, atol=1e-9)
    assert np.allclose(found.ddphi, ddphi, rtol=1e-9, atol=1e-9)


def test_parts_add_up(result: sprung.Result) -> None:
    model = result.model
    q, dq, ddq, phi, dphi, ddphi = STATES
    link, motor = model.predict(q, dq, ddq, phi, dphi, ddphi)
    masses = model.mass_matrix(q)
    assert np.allclose(masses, masses.transpose(0, 2, 1))
    assert np.linalg.eigvalsh(masses).min() > 0
    moved = np.einsum("kij,kj->ki", masses, np.hstack([ddq, ddphi]))
    spring = model.spring(q, phi, dq, dphi)
    friction = model.friction(q, dq, phi, dphi)
    total = moved[:, :2] + model.coriolis_torques(q, dq) + model.gravity(q) - spring + friction.link
    assert np.allclose(total, link)
    assert np.allclose(moved[:, 2:] + spring + friction.motor, motor)


def test_one_state_and_many_agree(result: sprung.Result) -> None:
    model = result.model
    q, dq, ddq, *_ = STATES
    one = model.predict(q[3], dq[3], ddq[3])
    many = model.predict(q, dq, ddq)
    assert one.link.shape == (2,)
    assert np.array_equal(one.link, many.link[3]) and np.array_equal(one.motor, many.motor[3])


def test_a_simulated_step_follows_forward_dynamics(result: sprung.Result) -> None:
    model = result.model
    tau = np.zeros((200, 2))
    motion = model.simulate(tau, 1e-4, q=[0.1, -0.2], phi=[0.15, -0.1])
    assert motion.q.shape == (201, 2) and motion.t[-1] == pytest.approx(0.02)
    rate = (motion.dq[2:] - motion.dq[:-2]) / 2e-4
    inner = [signal[1:-1] for signal in (motion.q, motion.dq, motion.phi, motion.dphi)]
    q, dq, phi, dphi = inner
    expected = model.forward_dynamics(q, dq, tau[1:], phi, dphi).ddq
    assert np.abs(rate - expected).max() < 1e-3 * np.abs(expected).max()


def test_wrong_shapes_are_refused(result: sprung.Result) -> None:
    model = result.model
    with pytest.raises(sprung.InputError, match="shape"):
        model.gravity([0.0, 0.0, 0.0])
    with pytest.raises(sprung.InputError, match="shape"):
        model.coriolis_torques(np.zeros((3, 2)), np.zeros((4, 2)))
    with pytest.raises(sprung.InputError, match="numbers"):
        model.gravity(["a", "b"])
    with pytest.raises(sprung.InputError, match="without bound"):
        model.simulate(np.full((50, 2), 1e300), 0.1, q=[0, 0])
