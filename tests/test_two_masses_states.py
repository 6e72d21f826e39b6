"""Two masses under laws with states: against plain steps, closed forms and laws without."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from foreign import two_masses as static_steps
from foreign import two_masses_bristles as plain_steps
from foreign.combined import Elements
from foreign.presliding import LuGre, dahl
from stribeck.friction import law_named
from stribeck.rig.axis_table import composed_axis
from stribeck.rig.simulated import as_simulated
from stribeck.space import Array
from two_mass_axes import FORCE, GAINS, GOAL, SERVO, moved, rig_of, started, t

AXIS = {name: x for name, x in SERVO.items() if not name.startswith("F_")}
#: A load's and a motor's law, as parameters by name.
LUGRE = (
    {"sigma_0": 1e6, "sigma_1": 300.0, "F_S": 30.0, "F_C": 20.0, "v_s": 5e-3, "F_V": 30.0},
    {"sigma_0": 2e6, "sigma_1": 200.0, "F_S": 12.0, "F_C": 10.0, "v_s": 5e-3, "F_V": 20.0},
)
DAHL = (
    {"sigma_0": 1e6, "F_C": 20.0, "F_V": 30.0, "exponent": 1.0},
    {"sigma_0": 2e6, "F_C": 10.0, "F_V": 20.0, "exponent": 1.0},
)
MAXWELL = (
    {"W_1": 12.0, "W_2": 8.0, "d_1": 5e-6, "r_2": 4.0, "F_V": 30.0},
    {"W_1": 6.0, "W_2": 4.0, "d_1": 3e-6, "r_2": 5.0, "F_V": 20.0},
)
GMS = (
    MAXWELL[0] | {"ratio": 1.4, "v_s": 5e-3, "tau": 5e-3},
    MAXWELL[1] | {"ratio": 1.2, "v_s": 5e-3, "tau": 5e-3},
)


def _elements(p: dict[str, float]) -> Elements:
    """Elements of the plain simulator; those of Maxwell slip stay on their level at once."""
    levels, yields = np.array([p["W_1"], p["W_2"]]), p["d_1"] * np.array([1.0, p["r_2"]])
    return Elements(
        levels, yields, p["F_V"], p.get("ratio", 1.0), p.get("v_s", 1.0), p.get("tau", 1e-7)
    )


#: By the name of a law, both sides' parameters, and the plain simulator's law of them.
LAWS: dict[str, tuple[tuple[dict[str, float], dict[str, float]], Any]] = {
    "lugre": (LUGRE, lambda p: LuGre(**p)),
    "dahl": (DAHL, lambda p: dahl(p["sigma_0"], p["F_C"], p["F_V"])),
    "maxwell-slip:2": (MAXWELL, _elements),
    "gms:2": (GMS, _elements),
}
AXES: dict[str, tuple[dict[str, float], dict[str, Array]]] = {
    "under force": (AXIS, {"force": FORCE}),
    "in a loop": (AXIS | GAINS, {"goal": GOAL}),
    "without play and damper": (AXIS | GAINS | {"play": 0.0, "damping": 0.0}, {"goal": GOAL}),
    "creeping": (AXIS | GAINS | {"stiffness": 4e4}, {"goal": 3e-3 * t}),
    "lossy": (AXIS | GAINS | {"eta": 0.8, "eta_back": 0.6}, {"goal": GOAL}),
}


def both(sides: tuple[dict[str, float], dict[str, float]]) -> dict[str, float]:
    """The parameters of the load and, named so, of the motor."""
    load, motor = sides
    return load | {f"{name}_motor": x for name, x in motor.items()}


@pytest.mark.parametrize(
    ("law", "axis"),
    [
        *(("lugre", axis) for axis in AXES),
        ("dahl", "in a loop"),
        ("maxwell-slip:2", "in a loop"),
        ("gms:2", "creeping"),
        ("gms:2", "in a loop"),
    ],
)
def test_plain_steps_come_nearer_in_proportion_to_their_length(law: str, axis: str) -> None:
    (load, motor), plain = LAWS[law]
    values, inputs = AXES[axis]
    own = {"armature": "M_m"}
    stated = plain_steps.Axis(**{own.get(n, n): x for n, x in values.items()})
    drive = {"drive" if n == "force" else n: x for n, x in inputs.items()}
    values = values | both((load, motor))
    ours = np.array(moved(rig_of(values, law, tolerance=1e-5), values, **inputs))
    known = [
        plain_steps.simulate(stated, plain(motor), plain(load), t, sub, **drive)[[0, 2]]
        for sub in (400, 1600, 3200)
    ]
    errors = [float(np.abs(k - ours).max()) for k in known]
    way = np.ptp(ours[0] - ours[1])
    assert way > 1e-4
    assert errors[2] < 5e-3 * way  # at 0.6 us
    if law != "gms:2":  # whose elements begin to slide at a level that jumps as they turn
        assert errors[2] < 0.7 * errors[1] < 0.3 * errors[0]


@pytest.mark.parametrize("law", LAWS)
def test_a_step_may_be_off_by_what_it_is_said_to(law: str) -> None:
    values = AXIS | GAINS | both(LAWS[law][0])
    fine, usual, rough = (
        np.array(moved(rig_of(values, law, tolerance=tolerance), values, goal=GOAL))
        for tolerance in (1e-5, 1e-3, 1e-1)
    )
    assert np.abs(usual - fine).max() < 6e-7
    assert 0.0 < np.abs(rough - fine).max() < 2e-5


@pytest.mark.parametrize("law", LAWS)
def test_a_mirrored_force_mirrors_the_motion(law: str) -> None:
    values = AXIS | both(LAWS[law][0])
    forth, back = (moved(rig_of(values, law), values, force=sign * FORCE) for sign in (1.0, -1.0))
    for a, b in zip(forth, back, strict=True):
        np.testing.assert_array_equal(a, -b)


def test_a_parameter_set_moves_as_it_does_alone() -> None:
    """Bit for bit, beside one with a lossy coupling that holds its load."""
    values = AXIS | GAINS | both(LUGRE)
    rig = rig_of({n: x for n, x in values.items() if n != "damping"}, "lugre",
                 transmission={"compliant": {"stiffness": 5e5, "play": 2e-4,
                                             "eta": {"free": [0.1, 1.0]}}})  # fmt: skip
    law = law_named("lugre")
    own = rig.parameters(law)
    sets = np.array([[(values | {"eta": eta})[q.name] for q in own] for eta in (1.0, 0.7)])
    together = rig.sides(law, sets, started(rig, goal=GOAL))
    for i in range(2):
        alone = rig.sides(law, sets[i : i + 1], started(rig, goal=GOAL))
        for a, b in zip(together, alone, strict=True):
            np.testing.assert_array_equal(a.position[i], b.position[0])


@pytest.mark.parametrize("law", ["dahl", "lugre", "maxwell-slip:2"])
def test_an_axis_left_alone_gains_no_energy(law: str) -> None:
    """Kinetic and of the spring, and at most what bristles have stored, from the force's end on."""
    load, motor = ({**p, "F_V": 1.0} for p in LAWS[law][0])
    values = AXIS | both((load, motor)) | {"damping": 0.0}
    rig = rig_of(values, law, tolerance=1e-4)
    p = np.array([[values[q.name] for q in rig.parameters(law_named(law))]])
    sides = rig.sides(law_named(law), p, started(rig, np.where(t < 0.1, FORCE, 0.0)))
    ahead = sides[0].position[0] - sides[1].position[0]
    twist = np.sign(ahead) * np.maximum(np.abs(ahead) - 0.5 * values["play"], 0.0)
    energy = 0.5 * values["stiffness"] * twist**2
    for mass, side in zip((2.0, 5.0), sides, strict=True):
        energy += 0.5 * mass * side.velocity[0] ** 2
    stored = 0.0
    for own in (load, motor):
        if "sigma_0" in own:
            stored += 0.5 * own.get("F_S", own["F_C"]) ** 2 / own["sigma_0"]
        else:
            stored += 0.5 * own["d_1"] * (own["W_1"] + own["W_2"] * own["r_2"])
    alone = energy[t > 0.102]
    assert alone[0] > 100.0 * stored
    assert (alone - np.minimum.accumulate(alone)).max() <= stored
    assert alone[-1] < 1e-2 * alone[0]


def test_stiff_bristles_are_coulomb_friction() -> None:
    """Dahl's law comes to it as what is left to swing gets less, on both sides or on the load's."""
    known = np.array(static_steps.simulate({**SERVO, **GAINS, "M_m": 2.0}, t, 3200, goal=GOAL))
    errors: dict[str, list[float]] = {"dahl": [], "coulomb-viscous": []}
    for sigma_0 in (1e6, 1e7, 1e8):
        for motor, off in errors.items():
            values = SERVO | GAINS | {"sigma_0": sigma_0, "exponent": 1.0}
            values |= {"sigma_0_motor": sigma_0, "exponent_motor": 1.0}
            rig = rig_of(values, "dahl", friction={"side": "both", "motor": motor})
            off.append(float(np.abs(np.array(moved(rig, values, goal=GOAL)) - known).max()))
    for off in errors.values():
        assert off[2] < 1e-5
        assert off[2] < 0.4 * off[1] < 0.16 * off[0]


def test_a_stiff_coupling_is_none() -> None:
    """The nearer to one mass under the same law the stiffer, in proportion."""
    load = LUGRE[0]
    table = {
        "controller": {"none": {}}, "motor": {"force": {"armature": 2.0}},
        "load": {"mass": {"M": 5.0}}, "law": "lugre", "tolerance": 1e-4,
    }  # fmt: skip
    law = law_named("lugre")
    rigid = as_simulated(composed_axis(table, "rigid"))
    p = np.array([[load[q.name] for q in law.params]])
    known = rigid.move(law, p, started(rigid, FORCE)).position[0]
    errors = []
    for k in (1e5, 1e6, 1e7):
        values = AXIS | load | {"stiffness": k, "damping": 2.0 * np.sqrt(k), "play": 0.0}
        rig = rig_of(values, "lugre", friction={"side": "load"}, tolerance=1e-4)
        motor, moved_load = moved(rig, values, force=FORCE)
        errors.append(max(np.abs(motor - known).max(), np.abs(moved_load - known).max()))
    assert errors[2] < 2e-4 * np.ptp(known)
    assert errors[2] < 0.2 * errors[1] < 0.04 * errors[0]


@pytest.mark.parametrize("law", ["dahl", "coulomb-viscous"])
def test_a_lossy_coupling_holds_its_load(law: str) -> None:
    """A weight goes up where η T passes it and friction, down where T / η_back falls below it."""
    weight, eta, eta_back, level = 50.0, 0.8, 0.5, 10.0
    values = AXIS | GAINS | {
        "offset": weight, "eta": eta, "eta_back": eta_back, "play": 0.0, "stiffness": 1e5,
        "damping": 500.0, "F_C": level, "F_V": 10.0, "sigma_0": 1e8, "exponent": 1.0,
    }  # fmt: skip
    rig = rig_of(values, law, friction={"side": "load"})
    goal = 4e-3 * np.interp(t, [0.0, 0.3, 0.7, 0.8, 1.4], [0.0, 0.0, 1.0, 1.0, -1.0])
    motor, load = moved(rig, values, goal=goal)
    T = values["stiffness"] * (motor - load)
    low, high = load[t <= 0.3][-1], load[t <= 0.8][-1]
    up = np.flatnonzero((t > 0.3) & (load > low + 2e-6))[0]
    down = np.flatnonzero((t > 0.8) & (load < high - 2e-6))[0]
    assert abs(T[up] - (weight + level) / eta) < 2.0
    assert abs(T[down] - eta_back * (weight - level)) < 2.0
    held = load[(t > 0.8) & (np.arange(len(t)) < down)]
    assert len(held) > 20
    assert np.ptp(held) < 3e-6
