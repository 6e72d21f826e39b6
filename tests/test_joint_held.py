"""A joint whose controller holds its torque between samples, against an explicit loop."""

from __future__ import annotations

import numpy as np
import pytest

from stribeck.data.recording import Recording
from stribeck.errors import InputError
from stribeck.friction import LAWS
from stribeck.rig import RIGS
from stribeck.rig.stepped import SteppedRig
from stribeck.space import Array

KP, KD, GAIN, LIMIT = 40.0, 2.5, 0.5, 4.0
F_C, F_V, J, G_SIN, G_COS, G_0 = 0.4, 0.3, 0.25, 1.5, -0.5, 0.2
RNG = np.random.default_rng(3)
#: Sample times as uneven as those of a serial link; a command with a step beyond the torque limit.
T = np.cumsum(np.r_[0.0, RNG.uniform(0.02, 0.09, 120)])
COMMAND = 0.3 * np.sin(1.3 * T) + 0.8 * (T > 4.0)
RATE = 0.39 * np.cos(1.3 * T)
AHEAD = 0.3 * np.sin(0.7 * T)


def log() -> Recording:
    return Recording(
        t=T,
        position=1e-6 * np.sin(T),
        velocity=np.zeros(len(T)),
        command=COMMAND,
        rotary=True,
        extra={"qd_cmd_rad_s": RATE, "tau_ff_Nm": AHEAD},
    )


def joint(hold: float) -> SteppedRig:
    stepped_rig = RIGS["joint"]
    assert isinstance(stepped_rig, SteppedRig)
    return stepped_rig.set(kp=KP, kd=KD, gain=GAIN, limit=LIMIT, hold=hold)


def looped(late: int, steps: int = 2000) -> tuple[Array, Array]:
    """Positions and torques sample by sample; Coulomb friction by comparing forces."""
    q, v, before = float(log().position[0]), 0.0, 0.0
    out, torque = np.empty(len(T)), np.empty(len(T))
    for k in range(len(T)):
        error, rate = COMMAND[k] - q, RATE[k] - v
        demand = float(np.clip(AHEAD[k] + GAIN * (KP * error + KD * rate), -LIMIT, LIMIT))
        out[k], torque[k] = q, demand if k == 0 or late == 0 else before
        before = demand
        if k == len(T) - 1:
            break
        h = (T[k + 1] - T[k]) / steps
        for _ in range(steps):
            force = torque[k] - G_SIN * np.sin(q) - G_COS * np.cos(q) - G_0
            if v == 0.0 and abs(force) <= F_C:
                break
            s = np.sign(v) if v != 0.0 else np.sign(force)
            w = v + h * (force - s * F_C - F_V * v) / J
            v = w if v * w >= 0.0 else 0.0
            q += h * v
    return out, torque


@pytest.mark.parametrize(("hold", "late"), [(1.0, 0), (2.0, 1)])
def test_a_held_torque_against_a_plain_loop(hold: float, late: int) -> None:
    x, torque = looped(late)
    p = np.array([[F_C, F_V, J, G_SIN, G_COS, G_0]])
    motion = joint(hold).simulate(LAWS["coulomb-viscous"], p, log())
    assert np.ptp(x) > 0.5
    assert (np.diff(x) == 0).sum() > 5  # it sticks on the way
    assert (np.abs(torque) == LIMIT).any()  # and its drive is at its limit
    np.testing.assert_allclose(motion.position[0], x, atol=1e-3)
    np.testing.assert_allclose(motion.force[0], torque, atol=0.03)


def test_fine_samples_make_a_held_torque_one_that_follows() -> None:
    t = np.linspace(0.0, 3.0, 30_001)
    fine = Recording(t=t, position=1e-6 * np.sin(t), command=0.3 * np.sin(2 * t), rotary=True)
    p = np.array([[F_C, F_V, J, G_SIN, G_COS, G_0]])
    law = LAWS["coulomb-viscous"]
    follows, sampled = (joint(hold).simulate(law, p, fine).position[0] for hold in (0.0, 1.0))
    assert np.abs(sampled - follows).max() < 1e-3 * np.ptp(follows)
    # and one that is held over 50 ms is another motion
    rough = Recording(t[::500], fine.position[::500], np.sin(2 * t[::500]) * 0.3, rotary=True)
    x = joint(1.0).simulate(law, p, rough).position[0]
    assert np.abs(x - follows[::500]).max() > 5e-3 * np.ptp(follows)


def test_another_hold_is_refused() -> None:
    p = np.array([[F_C, F_V, J, G_SIN, G_COS, G_0]])
    with pytest.raises(InputError, match="hold = 3 must be 0, 1 or 2"):
        joint(3.0).simulate(LAWS["coulomb-viscous"], p, log())
