"""The EMPS benchmark: the published models, errors and simulations, from the published logs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import scipy.io

from emps_loop import relative_errors
from stribeck.data.filtering import Filtering
from stribeck.data.recording import Recording
from stribeck.errors import InputError
from stribeck.friction import LAWS
from stribeck.identify.balance.balance import Balance, balance, validate
from stribeck.identify.parameters import Parameters
from stribeck.rig import emps
from stribeck.rig.balanced import slips
from stribeck.rig.emps import EMPS
from stribeck.space import Array, Space

DATA = Path(__file__).parents[2] / "shared" / "data" / "emps"
real = pytest.mark.recordings("emps")
SYMMETRIC, DIRECTIONAL = LAWS["coulomb-viscous"], LAWS["coulomb-viscous-directional"]
#: The report's symmetric model in the order of EMPS.parameters: F_C, F_V, M, offset.
PUBLISHED = np.array([20.3935, 203.5034, 95.1089, -3.1648])


def load(name: str) -> Recording:
    raw = scipy.io.loadmat(DATA / f"{name}.mat")
    d = {k: np.asarray(v, dtype=float).ravel() for k, v in raw.items() if not k.startswith("__")}
    extra = {"pulses_N": d["pulses_N"]} if "pulses_N" in d else {}
    return Recording(
        t=d["t"], position=d["qm"], command=d["qg"], voltage=d["vir"],
        force=d["gtau"] * d["vir"], extra=extra,
    )  # fmt: skip


@pytest.fixture(scope="module")
def log() -> Recording:
    return load("DATA_EMPS")


@pytest.fixture(scope="module")
def pulses() -> Recording:
    return load("DATA_EMPS_PULSES")


@pytest.fixture(scope="module")
def symmetric(log: Recording) -> Balance:
    return balance(log, Parameters.declared(EMPS, SYMMETRIC))


def printed(value: float, decimals: int = 4) -> float:
    """A number as the report prints it."""
    return round(float(value), decimals)


@real
@pytest.mark.parametrize(
    ("name", "value", "standard_error"),
    [
        ("M", 95.1089, 0.1085),
        ("F_V", 203.5034, 1.1460),
        ("F_C", 20.3935, 0.1012),
        ("offset", -3.1648, 0.0444),
    ],
)
def test_symmetric_model_is_the_published_one_to_every_printed_digit(
    symmetric: Balance, name: str, value: float, standard_error: float
) -> None:
    assert printed(symmetric[name]) == value
    assert printed(symmetric.standard_error(name)) == standard_error


@real
def test_its_condition_number_and_errors_are_the_published_ones(symmetric: Balance) -> None:
    assert printed(symmetric.condition) == 25.9883
    assert printed(symmetric.relative_error) == 4.0834
    assert printed(symmetric.residual_sd) == 2.1843
    assert symmetric.rows == 2480
    assert symmetric.at_bound == {}
    assert symmetric.notes == ()


@real
def test_direction_dependent_model_is_the_published_one(log: Recording) -> None:
    directional = balance(log, Parameters.declared(EMPS, DIRECTIONAL))
    assert {n: printed(directional[n]) for n in directional.names} == {
        "F_C+": 20.1440,
        "F_V+": 166.7061,
        "F_C-": 20.6277,
        "F_V-": 240.4236,
        "M": 95.1540,
    }
    assert printed(directional.relative_error) == 3.1117


@real
def test_cross_test_on_the_pulses_is_the_published_one(
    symmetric: Balance, pulses: Recording
) -> None:
    assert (
        printed(
            validate(pulses, Parameters.declared(EMPS, SYMMETRIC), symmetric.values).relative_error
        )
        == 5.9824
    )


@real
def test_force_follows_from_the_voltage_where_a_log_has_no_force(
    log: Recording, symmetric: Balance
) -> None:
    alone = Recording(t=log.t, position=log.position, voltage=log.voltage)
    from_voltage = balance(alone, Parameters.declared(EMPS, SYMMETRIC))
    np.testing.assert_allclose(from_voltage.values, symmetric.values, rtol=1e-9)


#: The report's closed-loop simulation, percent: position, velocity, acceleration, force.
LOOP = {
    "DATA_EMPS": (0.013752, 0.22911, 8.6036, 5.848),
    "DATA_EMPS_PULSES": (0.0080248, 0.47888, 19.8152, 8.9409),
}


@real
@pytest.mark.parametrize("name", list(LOOP))
@pytest.mark.parametrize("delay", [1.0, 0.0])
def test_closed_loop_is_as_near_to_the_log_as_the_published_simulation(
    name: str, delay: float
) -> None:
    log, rig = load(name), EMPS.set(delay=delay)
    ours = relative_errors(rig.simulate(SYMMETRIC, PUBLISHED[None], log), log)
    assert all(a <= 1.01 * b for a, b in zip(ours, LOOP[name], strict=True)), ours
    # And it is a simulation, not a copy of the log: the report's force misfit within a third.
    assert ours[3] > LOOP[name][3] * 0.6


@real
def test_the_logged_voltage_is_the_controller_s(log: Recording) -> None:
    # The controller of the docstring, fed with the logged positions, gives the logged voltage
    # at the same sample: the constants, the FIR and the difference are right.
    assert log.command is not None
    assert log.voltage is not None
    q = log.position
    u = EMPS["kv"] * (EMPS["kp"] * (log.command - q)[2:] - (q[2:] - q[:-2]) / (2 * EMPS["T"]))
    error = np.linalg.norm(log.voltage[2:] - u) / np.linalg.norm(log.voltage)
    assert error < 0.003


@real
@pytest.mark.parametrize("name", ["stribeck", "stribeck-directional"])
def test_no_confident_stribeck_parameters_from_data_that_has_none(
    log: Recording, symmetric: Balance, name: str
) -> None:
    estimates = balance(log, Parameters.declared(EMPS, LAWS[name]))
    assert estimates.relative_error <= symmetric.relative_error + 1e-9  # it holds the Coulomb law
    for n in estimates.names:
        if n.startswith(("F_S", "v_SS")):
            error = estimates.standard_error(n)
            assert error > 0.5 * estimates[n] or n in estimates.at_bound, (n, estimates[n], error)
            assert n not in estimates.at_bound or error == np.inf
    stems = {n.rstrip("+-") for n in estimates.at_bound}
    assert stems & {"F_S", "v_SS"}
    assert any(("stopped" in note or "cannot be identified" in note) for note in estimates.notes)
    # What the data does show keeps its value.
    assert estimates["M"] == pytest.approx(95.1, abs=0.2)


@real
def test_rows_can_be_held_out(log: Recording, symmetric: Balance) -> None:
    half = np.zeros(len(log), dtype=bool)
    half[: len(log) // 2] = True
    first, second = (
        balance(log, Parameters.declared(EMPS, SYMMETRIC), rows=[m]) for m in (half, ~half)
    )
    assert first.rows + second.rows == symmetric.rows
    assert first["M"] != second["M"]
    assert first["M"] == pytest.approx(second["M"], rel=0.02)
    joined = balance(
        [log, log], Parameters.declared(EMPS, SYMMETRIC), rows=[half, slice(len(log) // 2, None)]
    )
    np.testing.assert_allclose(joined.values, symmetric.values, rtol=1e-10)


# The loop in itself: a log made up, so that these run everywhere.


def made_up(n: int = 2000, speed: float = 0.2) -> Recording:
    t = np.arange(n) / 1000.0
    command = 0.02 * (1 - np.cos(speed * 2 * np.pi * 5 * t))
    return Recording(t=t, position=np.zeros(n), command=command, voltage=np.zeros(n))


STRIBECK = np.array([30.0, 18.0, 200.0, 5e-3, 1.0, 95.0, -3.0])


@pytest.mark.parametrize(
    ("law", "p"), [("coulomb-viscous", PUBLISHED), ("stribeck", STRIBECK)], ids=["linear", "curved"]
)
def test_loop_has_converged_at_its_step(
    monkeypatch: pytest.MonkeyPatch, law: str, p: Array
) -> None:
    log, slow = made_up(), EMPS.set(T=8.0, delay=8.0, kp=20.0)  # a slow clock makes steps coarse
    default_steps, default_tolerance = emps.STEPS, emps.TOLERANCE

    def run(steps: int, tolerance: float, rig: emps.Emps = slow) -> Array:
        monkeypatch.setattr(emps, "STEPS", steps)
        monkeypatch.setattr(emps, "TOLERANCE", tolerance)
        return np.asarray(rig.simulate(LAWS[law], p[None], log).velocity[0])

    fine = run(1024, 1e-15)
    errors = np.array([np.abs(run(n, 1.0) - fine).max() for n in (1, 2, 4, 8)])
    assert errors[0] < 2e-3 * np.abs(fine).max()
    assert errors[-1] < 2e-5 * np.abs(fine).max()
    if law == "stribeck":  # on lines and exponentials nothing is left to gain
        assert np.log2(errors[0] / errors[-1]) > 3 * 2, errors
    # At the real clock and the default step next to nothing is left to gain.
    default = run(default_steps, default_tolerance, EMPS)
    assert np.abs(default - run(64, 1e-16, EMPS)).max() < 4e-9


def weak(law: str) -> Array:
    """A physical parameter set near the lower ends of the ranges, so that the axis moves."""
    params = EMPS.parameters(LAWS[law])
    u = 0.1 * np.random.default_rng(8).random((256, len(params)))
    p = Space(params).decode(u)
    for i, q in enumerate(params):
        p[:, i] = {"M": 90.0, "offset": -3.0}.get(q.name, p[:, i] if q.fixed is None else q.fixed)
    return np.asarray(p[LAWS[law].physical(p[:, : len(LAWS[law].params)])][0])


@pytest.mark.parametrize("law", [name for name, law in LAWS.items() if law.static])
def test_loop_obeys_the_force_balance_of_the_rig(law: str) -> None:
    log = made_up()
    p = weak(law)
    motion = EMPS.simulate(LAWS[law], p[None], log)
    v, a, F = motion.velocity[0], motion.acceleration[0], motion.force[0]
    slip = np.abs(v) > 1e-12  # between a stop and its tick, an interpolation leaves rounding
    assert slip.mean() > 0.5
    np.testing.assert_allclose(F[slip], EMPS.force(LAWS[law], p, v, a)[slip], atol=1e-9)
    # At rest friction balances the drive, within its levels.
    low, high = LAWS[law].levels(p)
    static = F[~slip] - (0.0 if LAWS[law].directional else p[-1])
    resting = motion.acceleration[0][~slip] == 0
    assert ((static >= low) & (static <= high))[resting].all()


@pytest.mark.parametrize(("tolerance", "off"), [(emps.TOLERANCE, 5e-10), (1e-16, 1e-11)])
def test_coasting_to_a_stop_is_the_closed_form(
    monkeypatch: pytest.MonkeyPatch, tolerance: float, off: float
) -> None:
    # Gains at zero: only friction acts. v = (v0 + c) e^{-bt} - c with b = F_V / M, c = F_C / F_V.
    n, v0, F_C, F_V, M = 2000, 0.5, 20.0, 100.0, 50.0
    t = np.arange(n) / 1000.0
    x = np.r_[0.0, v0 * 1e-3 * np.ones(n - 1)]
    log = Recording(t=t, position=x, command=np.zeros(n), voltage=np.zeros(n))
    rig = EMPS.set(kp=0.0, kv=0.0)
    monkeypatch.setattr(emps, "TOLERANCE", tolerance)
    motion = rig.simulate(SYMMETRIC, np.array([[F_C, F_V, M, 0.0]]), log)
    b, c = F_V / M, F_C / F_V
    stop = np.log((v0 + c) / c) / b
    expected = np.where(t < stop, (v0 + c) * np.exp(-b * t) - c, 0.0)
    distance = (v0 + c) * (1 - np.exp(-b * stop)) / b - c * stop
    np.testing.assert_allclose(motion.velocity[0], expected, rtol=0.0, atol=off)
    assert motion.position[0, -1] == pytest.approx(distance, rel=0.0, abs=off)
    assert (motion.velocity[0, t > stop] == 0).all()


def pulled(volts: Array, before: float) -> Recording:
    """An axis at rest under voltages without a controller, and the voltage before them."""
    t = np.arange(len(volts)) / 1000.0
    return Recording(
        t=t, position=0.0 * t, command=0.0 * t, voltage=volts + before, extra={"pulses_N": volts}
    )


def test_a_reversal_between_two_samples_is_the_closed_form() -> None:
    # Without viscous friction: up by (F - F_C) / M, down by (F + F_C) / M to a stop at t_0 within
    # a sample, then on in the other direction by (F - F_C) / M without a rest.
    F_C, M = 10.0, 50.0
    volts = np.where(np.arange(40) < 10, 1.0, -1.0)
    F = EMPS["gtau"]
    rig = EMPS.set(kp=0.0, kv=0.0, delay=0.0)
    motion = rig.simulate(SYMMETRIC, np.array([[F_C, 0.0, M, 0.0]]), pulled(volts, 0.0))
    t = motion.t
    up, down = (F - F_C) / M, (F + F_C) / M
    t_0 = 0.01 + 0.01 * up / down
    expected = np.where(
        t < 0.01, up * t, np.where(t < t_0, 0.01 * up - down * (t - 0.01), -up * (t - t_0))
    )
    np.testing.assert_allclose(motion.velocity[0], expected, rtol=0.0, atol=1e-9)
    assert motion.velocity[0, -1] < 0


def test_a_delay_of_a_part_of_a_sample_is_kept() -> None:
    # The voltage in force before acts for the delay, then nothing does.
    M, delay = 50.0, 0.4e-3
    rig = EMPS.set(kp=0.0, kv=0.0, delay=0.4)
    motion = rig.simulate(SYMMETRIC, np.array([[0.0, 0.0, M, 0.0]]), pulled(np.zeros(5), 2.0))
    v = 2.0 * EMPS["gtau"] * delay / M
    np.testing.assert_allclose(motion.velocity[0], [0.0, v, v, v, v], rtol=1e-12)
    assert motion.position[0, 1] == pytest.approx(v * (0.5 * delay + 0.6e-3), rel=1e-12)


def test_it_sticks_under_what_breakaway_holds_and_slips_above() -> None:
    n = 200
    log = Recording(
        t=np.arange(n) / 1000.0, position=np.zeros(n), command=np.zeros(n),
        voltage=np.full(n, 0.5), extra={"pulses_N": np.full(n, 0.5)},
    )  # fmt: skip
    pull = 0.5 * EMPS["gtau"]
    rig = EMPS.set(kp=0.0, kv=0.0)
    p = np.array([[level, 10.0, 80.0, 0.0] for level in (1.001 * pull, 0.999 * pull)])
    motion = rig.simulate(SYMMETRIC, p, log)
    assert (motion.velocity[0] == 0).all()
    assert (motion.velocity[1, 1:] > 0).all()


@real
def test_candidates_do_not_touch_each_other(log: Recording) -> None:
    p = PUBLISHED * (1 + 0.1 * np.random.default_rng(5).standard_normal((4, 4)))
    together = EMPS.simulate(SYMMETRIC, p, log.cut(slice(0, 3000)))
    for i in range(4):
        alone = EMPS.simulate(SYMMETRIC, p[[i]], log.cut(slice(0, 3000)))
        np.testing.assert_array_equal(alone.velocity[0], together.velocity[i])


def test_a_mass_that_cannot_be_gives_nan_and_leaves_the_others() -> None:
    p = np.vstack([PUBLISHED, PUBLISHED])
    p[0, 2] = 0.0
    motion = EMPS.simulate(SYMMETRIC, p, made_up(50))
    assert np.isnan(motion.position[0]).all()
    assert np.isfinite(motion.position[1]).all()


def test_a_log_of_another_rate_is_simulated_on_the_controller_s_clock() -> None:
    fine = made_up()
    coarse = fine.cut(slice(None, None, 4))
    a, b = (EMPS.simulate(SYMMETRIC, PUBLISHED[None], r).position[0] for r in (fine, coarse))
    assert len(b) == len(coarse)
    # The command between coarse samples is a line: 0.02 (2 pi)^2 (4 ms)^2 / 8 = 1.6e-6 m at most.
    np.testing.assert_allclose(b, a[::4], atol=2e-6)


@pytest.mark.parametrize(
    ("rig", "columns", "command", "says"),
    [
        (EMPS, 3, True, "parameters are F_C, F_V, M, offset; got 3 columns"),
        (EMPS, 4, False, "is simulated from a command"),
        (EMPS.set(delay=1.5), 4, True, "delay must lie between"),
    ],
)
def test_refusals(rig: emps.Emps, columns: int, command: bool, says: str) -> None:
    log = made_up(50)
    if not command:
        log = Recording(t=log.t, position=log.position)
    with pytest.raises(InputError, match=says):
        rig.simulate(SYMMETRIC, np.ones((1, columns)), log)


def test_friction_at_rest_is_midway_between_the_levels() -> None:
    p = np.array([10.0, 1.0, 14.0, 1.0])
    friction = slips(DIRECTIONAL.slip, np.array([0.0, 2.0, -2.0]), p)
    np.testing.assert_array_equal(friction, [-2.0, 12.0, -16.0])


def test_the_filtering_is_the_report_s() -> None:
    f = EMPS.filtering
    assert (f.order, f.cutoff(1000.0), f.factor(1000.0), f.edges(1000.0)) == (4, 100.0, 10, (49, 0))
    assert f != Filtering()
