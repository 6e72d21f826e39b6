"""Axes of known truth whose logs come from the foreign simulators, which share nothing with ours.

One function a kind of rig: it simulates, and returns the channels as the sensors would log them
without noise. `noisy` adds noise, and `recordings` makes files of it and reads them as a user's.
"""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

import foreign_path  # noqa: F401 - before what it finds
from foreign import (
    cascade,
    combined,
    cylinder,
    driven,
    joint,
    presliding,
    sensors,
    servo,
    slide_bed,
    two_masses,
)
from foreign.friction import Curve, coulomb_viscous
from foreign.sensors import Table
from foreign.strokes import combined as combined_strokes
from foreign.strokes import even, ramp, sines, strokes
from stribeck import Recording, read
from stribeck.space import Array, Rng

#: Heads of the columns by channel, of a linear and of a rotary axis.
HEADS = {
    "t": ("t [s]", "t [s]"), "position": ("x [m]", "q [rad]"), "command": ("x_d [m]", "q_d [rad]"),
    "force": ("F [N]", "tau [N m]"), "voltage": ("u [V]", "u [V]"),
    "pressure": ("p [Pa]", "p [Pa]"), "velocity": ("v [m/s]", "omega [rad/s]"),
    "mass": ("mass", "mass"), "length": ("length", "length"), "enabled": ("", "torque_enable"),
    "motor": ("motor_position", "motor_position"),
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Axis:
    """Logs of an axis whose parameters are known.

    Args:
        rig: Name of the rig that has its equation, or the file that composes it.
        law: Name of its law of friction.
        truth: The parameters behind the logs, SI, by name.
        tables: Channels of each log as ideal sensors have them.
        channels: Those that are logged.
        noise: Standard deviation of the sensor's noise by channel, SI.
        given: Constants that its user knows, as `--set` reads them.
        rotary: Whether its position is an angle.
        constants: Those that its user does not know, SI, by name.
        steps: Steps of a sensor that has any by channel, SI.
    """

    rig: str
    law: str
    truth: Mapping[str, float]
    tables: tuple[Table, ...]
    channels: tuple[str, ...]
    noise: Mapping[str, float]
    given: Mapping[str, float] = field(default_factory=dict)
    rotary: bool = False
    constants: Mapping[str, float] = field(default_factory=dict)
    steps: Mapping[str, float] = field(default_factory=dict)


def noisy(axis: Axis, rng: Rng, memory: float = 0.0) -> list[Table]:
    """All channels of its logs with white noise.

    Args:
        axis: its logs.
        rng: chance.
        memory: samples within which noise on the force forgets (to 1/e).
    """
    tables = list(axis.tables)
    for channel, sd in axis.noise.items():
        keeps = memory if channel == "force" else 0.0
        tables = [sensors.noisy(table, channel, sd, rng, keeps) for table in tables]
    for channel, step in axis.steps.items():
        tables = [sensors.quantised(table, channel, step) for table in tables]
    return tables


def recordings(axis: Axis, tables: Sequence[Table]) -> list[Recording]:
    """The logged channels as a user has them: written as CSV and read."""
    logs = []
    with tempfile.TemporaryDirectory() as folder:
        for k, table in enumerate(tables, 1):
            file = Path(folder) / f"log{k}.csv"
            names = ("t", *axis.channels)
            heads = [HEADS[name][axis.rotary] for name in names]
            rows = np.column_stack([table[name] for name in names])
            np.savetxt(file, rows, "%.9g", ",", header=",".join(heads), comments="")
            logs.append(read(file))
    return logs


# --- force balances -------------------------------------------------------------------------------

#: Speeds and way of the strokes of a balance, m/s and m; rad/s and rad on a rotary axis.
SPEEDS, WAY = (0.05, 0.1, 0.15, 0.2, 0.3), 0.08
#: A drive whose loop is far faster than its log, so that the logged force is the one that acts.
FAST = 1e-4
#: Plain steps of two masses from sample to sample of 2 ms.
COUPLED_STEPS = 8000


def forced(
    mass: float = 10.0,
    plus: Curve = coulomb_viscous(20.0, 60.0),  # noqa: B008 - a NamedTuple
    minus: Curve | None = None,
    extras: driven.Extras = driven.Extras(offset=3.0),  # noqa: B008
    speeds: Sequence[float] = SPEEDS,
    one_way: bool = False,
    command: tuple[Array, Array] | None = None,
    tones: float = 0.0,
    noise: float = 0.5,
) -> Axis:
    """A slide under a position loop, its force measured: twice through all speeds.

    What differs from side to side is, for a law without sides, half the difference in the offset.

    Args:
        mass: of the slide.
        plus: friction to the right.
        minus: friction to the left, if it is another.
        extras: what else acts.
        speeds: of its strokes.
        one_way: whether it only goes to the right.
        command: times and positions instead of strokes.
        tones: amplitude of the first of two slow tones instead of strokes.
        noise: of the force.
    """
    minus = minus or plus
    times, positions, velocity = strokes(np.tile(speeds, 2), WAY)
    if one_way:
        positions = np.cumsum(np.maximum(velocity, 0.0)) * (times[1] - times[0])
    if tones:
        command = sines(24.0, tones * np.array([1.0, 0.3]), np.array([0.21, 0.41]))
    if command is not None:
        times, positions = command
    loop = driven.Loop(kp=4e4, kd=2e3, mass_ff=9.0, tick=FAST)
    motion = driven.simulate(mass, plus, minus, loop, times, positions, extras)
    truth = {
        "F_C": (plus.F_C + minus.F_C) / 2.0, "F_V": (plus.F_V + minus.F_V) / 2.0, "M": mass,
        "offset": extras.offset + (plus.F_C - minus.F_C) / 2.0,
    }  # fmt: skip
    channels = ("position", "force")
    noises = {"force": noise, "position": 1e-6}
    return Axis("forced", "coulomb-viscous", truth, (motion._asdict(),), channels, noises)


def forced_pendulum(
    inertia: float = 0.3,
    curve: Curve = coulomb_viscous(0.5, 0.2),  # noqa: B008
    extras: driven.Extras = driven.Extras(offset=0.1, g_sin=2.0, g_cos=0.5),  # noqa: B008
    noise: float = 0.01,
) -> Axis:
    """A pendulum under a position loop, its torque measured."""
    times, command, _ = strokes(np.tile([0.5, 1.0, 1.5, 2.0, 3.0], 2), 1.6)
    loop = driven.Loop(kp=400.0, kd=20.0, tick=FAST)
    motion = driven.simulate(inertia, curve, curve, loop, times, command - 0.8, extras)
    truth = {
        "F_C": curve.F_C, "F_V": curve.F_V, "M": inertia, "offset": extras.offset,
        "g_sin": extras.g_sin, "g_cos": extras.g_cos,
    }  # fmt: skip
    return Axis(
        "forced-pendulum", "coulomb-viscous", truth, (motion._asdict(),), ("position", "force"),
        {"force": noise, "position": 1e-5}, rotary=True,
    )  # fmt: skip


def emps(
    axis: cascade.Cascade = cascade.Cascade(delay=0.0),  # noqa: B008
    curve: Curve = coulomb_viscous(20.3935, 203.5034),  # noqa: B008
    noise: float = 0.05,
) -> Axis:
    """The published slide under its cascade, the controller's voltage logged."""
    times, command, _ = strokes(np.tile([0.1, 0.2, 0.3, 0.4, 0.5], 2), 0.2)
    del times
    motion = cascade.simulate(axis, curve, curve, command)
    truth = {"F_C": curve.F_C, "F_V": curve.F_V, "M": axis.M, "offset": axis.offset}
    return Axis(
        "emps", "coulomb-viscous", truth, (motion._asdict(),), ("position", "command", "voltage"),
        {"voltage": noise, "position": 1e-6},
    )  # fmt: skip


def rod(
    axis: cylinder.Cylinder = cylinder.Cylinder(  # noqa: B008
        M=20.0, F_C=10.0, F_V=300.0, mu_p=5e-5, b=2e-5, offset=3.0
    ),
    pressures: Sequence[float] = (1e5, 3e5, 6e5),
    known_bore: float = 0.025,
    noise: float = 0.3,
) -> Axis:
    """A cylinder on a testing machine, a log for each pressure.

    Args:
        axis: constants.
        pressures: of the logs.
        known_bore: that its user takes; b has the area that it leaves out.
        noise: of the force.
    """
    times, _, speed = strokes(np.array([0.05, 0.1, 0.2]), 0.05)
    motions = [cylinder.simulate(axis, times, speed, np.full_like(times, p)) for p in pressures]
    truth = {
        "F_C": axis.F_C, "F_V": axis.F_V, "mu": axis.mu_p, "M": axis.M, "offset": axis.offset,
        "b": axis.b + np.pi / 4.0 * (axis.bore**2 - known_bore**2),
    }  # fmt: skip
    return Axis(
        "cylinder", "coulomb-load", truth, tuple(m._asdict() for m in motions),
        ("position", "force", "pressure"), {"force": noise, "position": 1e-6, "pressure": 100.0},
        given={"bore": 1e3 * known_bore},
    )  # fmt: skip


# --- stick-slip and simulated rigs ----------------------------------------------------------------


def bed(
    constants: slide_bed.Bed = slide_bed.Bed(),  # noqa: B008
    curve: Curve = Curve(130.0, 60.0, 958.3, 2e-3),  # noqa: B008
    law: str = "stribeck",
    scatter: Sequence[float] = (1.0,),
    right: bool = True,
    dt: float = 0.02,
    noise: float = 0.3e-3,
) -> Axis:
    """The paper's slide bed under a ramp of 5 mm/s that lasts a minute.

    Args:
        constants: of the bed.
        curve: friction, both ways.
        law: that it is identified with.
        scatter: factors on F_S from rest to rest.
        right: whether the ramp goes to the right.
        dt: from sample to sample.
        noise: of the position.
    """
    side = 1.0 if right else -1.0
    times, way = ramp(60.0, 5e-3)
    motion = slide_bed.simulate(
        constants, curve, curve, times, 0.2 + side * (way - 0.15), 0.2 - side * 0.156, dt,
        np.array(scatter),
    )  # fmt: skip
    truth = {
        "F_S": float(curve.F_S * np.mean(scatter)), "F_C": curve.F_C, "F_V": curve.F_V,
        "v_SS": curve.v_SS,
        "k_spring": constants.k_spring_up if right else constants.k_spring_down,
    }  # fmt: skip
    return Axis(
        "slide-bed", law, truth, (motion._asdict(),), ("position", "command"),
        {"position": noise},
        constants={"F_fm": constants.F_fm, "m": constants.m, "F_m_max": constants.F_m_max}
        | {"k_hat+": constants.k_hat_up, "k_hat-": constants.k_hat_down},
    )  # fmt: skip


#: Mass, length, size, and a slow and a fast frequency (rad/s) of the goal, of each log.
RUNS = ((0.5, 0.1, 0.8, 1.2, 5.0), (0.7, 0.15, 1.2, 2.0, 4.5), (0.35, 0.2, 1.0, 1.6, 7.0))


def pendulum(
    axis: servo.Servo = servo.Servo(armature=3e-3, q_offset=0.02),  # noqa: B008
    bam: servo.Bam = servo.Bam(0.02, 0.008),  # noqa: B008
    law: str = "coulomb-viscous",
    runs: Sequence[tuple[float, float, float, float, float]] = RUNS,
    noise: float = 1e-3,
) -> Axis:
    """A pendulum on a servo: logs with masses and lengths of their own.

    The torque is off for the last third, and the pendulum swings out.
    """
    tables = []
    for m, l, size, slow, fast in runs:  # noqa: E741 - the equation's letter
        t = even(6.0, 0.01)
        goal = size * np.sin(slow * t) + 0.3 * np.sin(fast * t)
        enabled = (t < 4.0).astype(float)  # noqa: PLR2004
        motion = servo.simulate(axis._replace(m=m, l=l), bam, t, goal, enabled)
        table = motion._asdict() | {"mass": np.full_like(t, m), "length": np.full_like(t, l)}
        tables.append(table)
    truth = {
        "F_C": bam.K_c, "F_V": bam.K_v, "k_t": axis.k_t, "R": axis.R, "armature": axis.armature,
        "q_offset": axis.q_offset,
    }  # fmt: skip
    return Axis(
        "servo-pendulum", law, truth, tuple(tables),
        ("position", "command", "mass", "length", "enabled"), {"position": noise},
        given={"kp": axis.kp, "vin": axis.vin}, rotary=True,
    )  # fmt: skip


def arm(
    axis: joint.Joint = joint.Joint(J=0.2, g_sin=1.0, g_cos=2.0, g_0=0.3, kp=70.0, kd=4.4),  # noqa: B008
    curve: Curve = Curve(1.2, 0.6, 0.3, 0.1),  # noqa: B008
    scatter: Sequence[float] = (1.0,),
    neighbour: float = 0.0,
    step: float = 0.0,
    noise: float = 0.5e-3,
) -> Axis:
    """A robot joint under PD control, slow enough to stick and slip and now and then fast.

    Args:
        axis: constants.
        curve: friction, both ways.
        scatter: factors on F_S from rest to rest.
        neighbour: torque of a neighbour that moves and is not logged, its amplitude.
        step: the height of steps in the command.
        noise: of the angle.
    """
    t, command = sines(16.0, np.array([0.6, 0.25]), np.array([0.25, 0.7]), dt=0.01)
    command = command + step * (np.floor(t / 2.0) % 2)
    motion = joint.simulate(
        axis, curve, curve, t, command, np.gradient(command, t),
        neighbour * np.sin(2.0 * np.pi * 0.31 * t), scatter=np.array(scatter),
    )  # fmt: skip
    truth = {
        "F_S": float(curve.F_S * np.mean(scatter)), "F_C": curve.F_C, "F_V": curve.F_V,
        "v_SS": curve.v_SS, "J": axis.J,
        "g_sin": axis.g_sin, "g_cos": axis.g_cos, "g_0": axis.g_0,
    }  # fmt: skip
    return Axis(
        "joint", "stribeck", truth, (motion._asdict(),), ("position", "command"),
        {"position": noise}, given={"kp": axis.kp, "kd": axis.kd}, rotary=True,
    )  # fmt: skip


def bristles(
    law: presliding.LuGre = presliding.dahl(1.2e6, 14.0, 50.0),  # noqa: B008
    name: str = "dahl",
    mass: float = 15.0,
    corners: bool = False,
    peak: float = 15.0,
    noise: float = 0.4e-6,
) -> Axis:
    """A mass on bristles under cycles of force that grow until it creeps, at 0.3 mm/s at most.

    Dahl's law has one level. That of the log is the level at such speeds: of LuGre's it is F_S,
    whose drop to F_C begins at v_s.

    Args:
        law: its friction.
        name: of the law that it is identified with.
        mass: of the axis.
        corners: whether the cycles are triangles.
        peak: the largest force.
        noise: of the position.
    """
    t = even(4.0, 2e-3)
    wave = np.sin(2.0 * np.pi * 1.5 * t)
    force = 2.0 + (1.0 + (peak - 3.0) / 4.0 * t) * (
        np.arcsin(wave) * 2.0 / np.pi if corners else wave
    )
    motion = presliding.simulate(mass, law, t, force, offset=0.5, dt=2e-3)
    truth = {"M": mass, "offset": 0.5} | (
        {"sigma_0": law.sigma_0, "F_C": law.F_S, "exponent": 1.0, "F_V": law.F_V}
        if name == "dahl"
        else law._asdict()
    )
    return Axis(
        "presliding", name, truth, (motion._asdict(),), ("position", "force"),
        {"position": noise},
    )  # fmt: skip


def both(
    law: presliding.LuGre | combined.Elements,
    mass: float,
    way: float,
    offset: float = 1.0,
    speeds: Sequence[float] = (0.5e-3, 1e-3, 2e-3, 4e-3, 8e-3, 0.02, 0.05),
    noise: float = 0.1,
    step: float = 1e-7,
) -> Axis:
    """Presliding and sliding in one log of a minute, the axis under a stiff position loop.

    Args:
        law: its friction.
        mass: of the axis.
        way: of its bristles before they give way.
        offset: constant force.
        speeds: of its strokes.
        noise: of the force.
        step: of the encoder, whose noise is half of it.
    """
    stiffness = 4e5
    level = law.F_C if isinstance(law, presliding.LuGre) else float(np.sum(law.levels))
    bend = 0.25 * level / stiffness  # the loop gives way, too
    times, command = combined_strokes(60.0, way + bend, np.asarray(speeds))
    loop = driven.Loop(kp=stiffness, kd=3e3, tick=FAST)
    motion = combined.simulate(mass, law, loop, times, command, offset)
    own = law._asdict()
    if isinstance(law, combined.Elements):
        levels, yields = own.pop("levels"), own.pop("yields")
        own |= {f"W_{i}": float(x) for i, x in enumerate(levels, 1)}
        own |= {f"r_{i}": float(x) for i, x in enumerate(yields[1:] / yields[:-1], 2)}
        own["d_1"] = float(yields[0])
    name = "lugre" if isinstance(law, presliding.LuGre) else f"gms:{len(law.levels)}"
    return Axis(
        "forced", name, own | {"M": mass, "offset": offset}, (motion._asdict(),),
        ("position", "force"), {"position": 0.5 * step, "force": noise}, steps={"position": step},
    )  # fmt: skip


#: The file of an axis of two masses, an encoder on each, and the friction that both have.
TWO_MASSES = Path(__file__).parents[1] / "docs" / "rigs" / "two_masses.toml"


def coupled(
    values: Mapping[str, float], command: tuple[Array, Array], noise: tuple[float, float]
) -> Axis:
    """A motor and a load that a spring with play joins, in a loop of the motor's position.

    Args:
        values: As `two_masses.simulate` has them, `kp` and `kd` of the loop among them.
        command: Times and positions.
        noise: Of the motor's encoder and of the load's.
    """
    t, goal = command
    motor, load = two_masses.simulate(values, t, COUPLED_STEPS, goal=goal)
    table = {"t": t, "position": load, "command": goal, "motor": motor}
    known = {"armature": values["M_m"], "M": values["M"], "kp": values["kp"], "kd": values["kd"]}
    return Axis(
        str(TWO_MASSES), "coulomb-viscous", values, (table,), ("position", "command", "motor"),
        {"motor": noise[0], "position": noise[1]}, given=known,
    )  # fmt: skip
