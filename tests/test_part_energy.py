"""What parts of an axis do with energy: ripple and an uneven lead keep it, efficiencies take it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from stribeck import LAWS
from stribeck.rig.axis_table import composed_axis
from stribeck.rig.motion.track import Track
from stribeck.rig.simulated import SimulatedRig, as_simulated
from stribeck.rig.two_masses import TwoMassRig
from stribeck.space import Array
from two_mass_axes import started, t

LAW = LAWS["coulomb-viscous"]
FREE = np.array([[0.0, 0.0]])
M, ARMATURE, PERIOD, STIFFNESS = 5.0, 2.0, 0.01, 1e4
RIPPLE = {"rip_period": PERIOD, "rip_cos": 3.0, "rip_sin": -2.0, "rip_cos2": 1.0, "rip_sin2": 0.5}


def axis(**parts: Any) -> SimulatedRig:
    """An axis of one mass, or of two where its transmission is compliant."""
    table: dict[str, Any] = {"motor": {"force": {"armature": ARMATURE}}, "tolerance": 1e-5, **parts}
    return as_simulated(composed_axis(table, "axis"))


def pushed(force: Array) -> Track:
    """A track from rest at 0 under a force."""
    return started(axis(load={"mass": {"M": M}}), force)


def ripple_energy(q: Array) -> Array:
    """The integral of the ripple's force over the way."""
    k = 2.0 * np.pi / PERIOD
    first = (3.0 * np.sin(k * q) + 2.0 * np.cos(k * q)) / k
    second = (1.0 * np.sin(2.0 * k * q) - 0.5 * np.cos(2.0 * k * q)) / (2.0 * k)
    return first + second


def test_ripple_takes_back_what_it_gives() -> None:
    rig = axis(load={"mass": {"M": M}, "ripple": RIPPLE})
    motion = rig.move(LAW, FREE, pushed(np.where(t < 0.3, 20.0, 0.0)))
    alone = t > 0.302
    q, v = motion.position[0][alone], motion.velocity[0][alone]
    kinetic, potential = 0.5 * (M + ARMATURE) * v**2, ripple_energy(q)
    assert np.ptp(potential) > 5e-3
    assert np.ptp(kinetic + potential) < 1e-6 * kinetic.max()


@pytest.mark.parametrize("part", ["ripple", "motor-ripple"])
def test_ripple_of_two_masses_acts_on_its_own(part: str) -> None:
    """That of the load by the load's position, cogging by the motor's."""
    cogging = {"cog_order": 2.0 * np.pi / PERIOD, "cog_cos": 3.0, "cog_sin": -2.0}
    load = RIPPLE | {"rip_cos2": 0.0, "rip_sin2": 0.0} if part == "ripple" else cogging
    rig = axis(
        transmission={"compliant": {"stiffness": STIFFNESS}},
        load={"mass": {"M": M}, part: load}, friction={"side": "load"},
    )  # fmt: skip
    assert isinstance(rig, TwoMassRig)
    motor, slide = rig.sides(LAW, FREE, pushed(np.where(t < 0.3, 20.0, 0.0)))
    alone = t > 0.302
    q_m, v_m, q, v = (
        x[0][alone] for x in (motor.position, motor.velocity, slide.position, slide.velocity)
    )
    k = 2.0 * np.pi / PERIOD
    at = q if part == "ripple" else q_m
    potential = (3.0 * np.sin(k * at) + 2.0 * np.cos(k * at)) / k
    energy = 0.5 * (ARMATURE * v_m**2 + M * v**2 + STIFFNESS * (q_m - q) ** 2) + potential
    assert np.ptp(q_m - q) > 1e-4
    assert np.ptp(potential) > 5e-3
    assert np.ptp(energy) < 1e-6 * energy.max()


def test_an_uneven_lead_passes_on_all_of_the_power() -> None:
    """Under a constant force the kinetic energy is the force times the motor's way."""
    force, error = 20.0, {"err_period": PERIOD, "err_cos": 4e-4, "err_sin": -3e-4}
    rig = axis(load={"mass": {"M": M}}, sensor={"lead-error": error})
    motion = rig.move(LAW, FREE, pushed(np.full(len(t), force)))
    q, v = motion.position[0], motion.velocity[0]
    x = 2.0 * np.pi * q / PERIOD
    q_m = q - 4e-4 * np.cos(x) + 3e-4 * np.sin(x)
    work, kinetic = force * (q_m - q_m[0]), 0.5 * (M + ARMATURE) * v**2
    assert np.ptp(q_m - q) > 9e-4
    assert np.abs(work - kinetic).max() < 1e-6 * kinetic.max()


def test_a_lossy_gear_is_its_closed_form_both_ways() -> None:
    """It drives with η F and brakes with F / η_back, so that a push and its mirror end at rest."""
    eta, eta_back, force, J, n = 0.7, 0.5, 2.0, 0.4, 10.0
    table = {
        "rotary": True, "motor": {"force": {}}, "load": {"inertia": {"J": J}}, "tolerance": 1e-5,
        "transmission": {"gear": {"gear_ratio": n, "eta": eta, "eta_back": eta_back}},
    }  # fmt: skip
    rig = as_simulated(composed_axis(table, "gear"))
    push = np.where(t < 0.5, force, -force)
    track = pushed(push)
    v = rig.move(LAW, FREE, track).velocity[0]
    gained, slowed = eta * n * force / J, n * force / (eta_back * J)
    up = 0.498 + 0.25 * 2e-3  # the force turns in a straight line from one sample to the next
    down = 0.5 - 0.25 * 2e-3
    known = np.where(t < 0.499, gained * t, gained * up - slowed * (t - down))
    stops = down + gained * up / slowed
    moving = t < stops
    assert np.abs(v - known)[moving].max() < 1e-9 * v.max()
    assert stops < 0.7
    back = t > stops + 2e-3  # the other way it drives again
    slope = np.polyfit(t[back], v[back], 1)[0]
    assert abs(slope + eta * n * force / J) < 1e-6 * abs(slope)


def test_a_lossy_coupling_takes_power_both_ways() -> None:
    """What the motor has put in less what is there never falls, and is lost as the load brakes."""
    rig = axis(
        transmission={"compliant": {"stiffness": STIFFNESS, "eta": 0.8, "eta_back": 0.6}},
        load={"mass": {"M": M}}, friction={"side": "load"},
    )  # fmt: skip
    assert isinstance(rig, TwoMassRig)
    force = np.where(t < 0.3, 40.0, np.where(t < 0.5, -40.0, 0.0))
    motor, slide = rig.sides(LAW, FREE, pushed(force))
    q_m, v_m, q, v = (
        x[0] for x in (motor.position, motor.velocity, slide.position, slide.velocity)
    )
    work = np.concatenate([[0.0], np.cumsum(0.5 * (force[1:] + force[:-1]) * np.diff(q_m))])
    energy = 0.5 * (ARMATURE * v_m**2 + M * v**2 + STIFFNESS * (q_m - q) ** 2)
    lost = work - energy
    assert lost[-1] > 0.2 * work.max()
    assert np.diff(lost).min() > -2e-4 * work.max()
    swinging = t > 0.502
    assert np.diff(lost[swinging]).min() > -1e-9 * work.max()
    assert lost[swinging][-1] > lost[swinging][0]


def test_what_resists_the_speed_of_a_load_resists_it_behind_a_coupling() -> None:
    """A fluid's drag, as docs/parts.md has it for a part of one's own: v falls as 1 / (1 + v t)."""
    from stribeck.rig.motion.part_call import DAMPING, Row  # noqa: PLC0415 - of this part alone
    from stribeck.rig.parts.part import Coefficient, Part  # noqa: PLC0415

    def drag(force: float, q: float, v: float, u: Row, c: Row, slope: Row) -> float:  # noqa: ARG001
        slope[DAMPING] += 2.0 * c[0] * abs(v)
        return force - c[0] * v * abs(v)

    part = Part(
        name="drag", role="load", doc="", equation="", slot="load", function=drag,
        coefficients=(Coefficient("c_2", "kg/m", "drag").known(8.0, "here"),),
        constants=lambda values: (values["c_2"],),
    )  # fmt: skip
    plain = composed_axis(
        {
            "motor": {"force": {"armature": 1e-3}}, "load": {"mass": {"M": M}}, "tolerance": 1e-4,
            "transmission": {"compliant": {"stiffness": 1e5, "damping": 100.0}},
        },
        "axis",
    )  # fmt: skip
    rig = TwoMassRig.compose(
        "axis", (*plain.parts, part), rotary=False, friction_side="load", doc="", cite="",
        constants=tuple(c for c in plain.constants if c.name in ("step", "tolerance")),
        shows=plain.shows,
    )  # fmt: skip
    _, slide = rig.sides(LAW, FREE, pushed(np.where(t < 0.3, 20.0, 0.0)))
    v = slide.velocity[0]
    begin = int(np.searchsorted(t, 0.35))
    known = v[begin] / (1.0 + 8.0 * v[begin] * (t - t[begin]) / (M + 1e-3))
    assert v[-1] < 0.6 * v[begin]
    assert np.abs(v - known)[begin:].max() < 1e-5 * v[begin]
