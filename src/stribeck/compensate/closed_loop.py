"""A simulated closed loop with a friction compensator, sampled and held as in a controller.

The axis moves between samples as `implicit` moves it, under any law and any of these drives:

| rig | what the compensator's output is added to |
|---|---|
| slide-bed | the motor's force, before its friction: F_motor = k̂ e + u |
| an axis of parts | what its controller asks for, as force over the motor's gain |
| joint | so, too: the feed-forward torque |
| servo-pendulum | so, too: the voltage, as torque times R/k_t of the model |
| emps | the force that the controller asks for, held and late as its voltage is |

At each sample the compensator sees the position, as its sensor shows it, takes its difference to
the sample before for the velocity, and knows the reference's velocity over the sample to come.
The position loop itself is not limited by the sensor, as it is not elsewhere. The cascade of EMPS
is a joint's controller of the same gains; its velocity is the axis's own, not a difference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import boolean, float64, int64, types, void

from ..compile_cache import compiled
from ..data.recording import Recording
from ..errors import InputError
from ..friction import RUB_TYPE, SLIP_TYPE
from ..friction.law import DRIVE, term_places, terms_factor
from ..rig.controller import Controller
from ..rig.motion import row_pool
from ..rig.motion.axis_row import DEMAND, LOAD_ROOM
from ..rig.motion.drive_force import LOOP_MEMORY, demanded, driven, held_demand, mixed
from ..rig.motion.drives import ENABLED, INPUTS
from ..rig.motion.implicit import EACH, FEWEST, MOST_STEPS, ROOM, started
from ..rig.motion.passage import MEMORY, passed
from ..rig.motion.row_pool import borrowed
from ..rig.motion.velocity import calls_of
from ..rig.rig import Motion, Rig
from ..space import Array
from ..wording import either
from .compensator import Compensator, compensator_output

if TYPE_CHECKING:
    from ..friction import Law

_F1 = types.Array(float64, 1, "C", readonly=True)
_F2 = types.Array(float64, 2, "C", readonly=True)
_W3 = float64[:, :, ::1]
_I1 = int64[::1]

#: An axis that is so many times its reference's travel away from its start has run away, where
#: that is more than so many m or rad.
_FAR, _NOT_FAR = 100.0, 10.0


@dataclass(frozen=True, eq=False)
class Reference:
    """What the axis is told to do, at the samples of its controller.

    Args:
        name: What it is called.
        t: Samples, s, evenly spaced, (N,).
        x: Positions, m or rad, (N,).
    """

    name: str
    t: Array
    x: Array

    def __post_init__(self) -> None:
        if not (len(self.t) == len(self.x) >= 3 and np.isfinite(self.x).all()):  # noqa: PLR2004
            raise InputError(f"reference {self.name}: give three finite positions or more")
        steps = np.diff(self.t)
        if not (steps[0] > 0 and np.allclose(steps, steps[0], rtol=1e-6, atol=0)):
            raise InputError(f"reference {self.name}: its samples are not evenly spaced")

    @property
    def h(self) -> float:
        """The sample time, s."""
        return float((self.t[-1] - self.t[0]) / (len(self.t) - 1))

    @property
    def v(self) -> Array:
        """Its velocity over the sample to come, (N,); at the last one it rests."""
        v = np.zeros(len(self.x))
        v[:-1] = np.diff(self.x) / np.diff(self.t)
        return v


@dataclass(frozen=True)
class Sensor:
    """How the compensator sees the position.

    Args:
        resolution: A count, m or rad; 0 for a sensor without steps.
        noise: Standard deviation of a reading, m or rad.
        seed: Of the noise.
    """

    resolution: float = 0.0
    noise: float = 0.0
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("resolution", "noise"):
            if not 0.0 <= getattr(self, name) < np.inf:
                raise InputError(f"sensor: {name} = {getattr(self, name):g}: give 0 or above")


IDEAL = Sensor()


@dataclass(frozen=True, eq=False)
class CompensatedMotion(Motion):
    """Simulated trajectories of n loops.

    Args:
        output: What the compensator puts out, N or N m, (n, N).
        seen: The velocity that it sees, (n, N).
    """

    output: Array
    seen: Array


def controlled(rig: Rig) -> Controller:
    """The controller of a rig, which a compensator adds to.

    Raises:
        InputError: it has none.
    """
    controller = rig.controller()
    if controller is None:
        raise InputError(
            f"rig {rig.name} has no controller to add a compensation to: state its gains kp and kd "
            f"{either('in a file (--loop FILE.toml)', 'as loop=PositionLoop(kp, kd)')}"
        )
    return controller


def compensated(
    rig: Rig,
    law: Law,
    plants: Array,
    reference: Reference,
    compensators: Sequence[Compensator],
    model: tuple[Law, Array],
    sensor: Sensor = IDEAL,
) -> CompensatedMotion:
    """Simulate loops with compensators, each from rest at the start of the reference.

    With a scale of 0 a motion is, bit for bit, the one that `implicit` gives without compensator.

    Args:
        rig: One with a controller.
        law: The friction of the axes.
        plants: (n, k) parameter sets of the axes: the law's, then the rig's own.
        reference: What they follow.
        compensators: One each, or one for all.
        model: The law that the compensators ask, and its (m,) parameters, the rig's own after them.
        sensor: How they see.

    Raises:
        InputError: a rig without a controller, parameters that are not the law's and rig's, or so
            many steps that nobody would wait for them.
    """
    controller = controlled(rig)
    plants = np.atleast_2d(np.asarray(plants, dtype=float))
    believed_law, believed = model[0], np.asarray(model[1], dtype=float)
    n, N = len(plants), len(reference.t)
    if len(compensators) not in (1, n):
        raise InputError(f"{len(compensators)} compensators for {n} axes: give one, or one each")
    if believed.shape != (k := len(rig.parameters(believed_law)),):
        raise InputError(f"model {believed_law.name} on rig {rig.name} has {k} parameters, "
                         f"got {believed.shape}")  # fmt: skip
    if plants.shape[1] != len(rig.parameters(law)):
        raise InputError(
            f"rig {rig.name}, law {law.name}: parameters are "
            f"{', '.join(q.name for q in rig.parameters(law))}; got {plants.shape[1]} columns"
        )
    track = controller.track(
        Recording(t=reference.t, position=reference.x, command=reference.x, rotary=rig.rotary)
    )
    constants = controller.constants(law, plants, track)
    settings = np.array([compensator.c for compensator in compensators])
    settings = np.repeat(settings, n, axis=0) if len(settings) < n else settings
    if not np.ceil(np.diff(reference.t) / controller.step - 1e-9).clip(1).sum() <= MOST_STEPS:
        raise InputError(
            f"reference {reference.name}: {reference.t[-1] - reference.t[0]:.4g} s in steps of "
            f"{controller.step:.3g} s are more than {MOST_STEPS:,}: take a shorter one"
        )
    t = np.ascontiguousarray(reference.t - reference.t[0])
    parts = np.maximum(np.ceil(np.diff(t) / controller.step - 1e-9), 1).astype(np.int64)
    rows = np.empty((5, n, N))
    noise = sensor.noise * np.random.default_rng(sensor.seed).standard_normal(N)
    far = max(_FAR * float(np.ptp(reference.x)), _NOT_FAR)
    start = np.column_stack([np.full(n, track.x0), np.full(n, track.v0)])
    row_pool.pool().share(
        _loops, n,
        (
            *calls_of(law), law.states, *calls_of(believed_law), believed_law.states,
            controller.drive, controller.entry,
            np.ascontiguousarray(plants[:, : len(law.params)]), term_places(law), constants,
            np.ascontiguousarray(believed[: len(believed_law.params)]), term_places(believed_law),
            settings, controller.command_per_force(believed_law, believed), far, t,
            np.ascontiguousarray(track.inputs), track.held.astype(np.int64), parts, start,
            reference.v, noise, sensor.resolution, reference.h, controller.tolerance, rows,
        ),
        FEWEST,
    )  # fmt: skip
    return CompensatedMotion(reference.t, *rows)


@compiled(
    void(
        SLIP_TYPE, RUB_TYPE, boolean, int64, SLIP_TYPE, RUB_TYPE, boolean, int64, int64, int64,
        _F2, _I1, _F2, _F1, _I1, _F2, float64, float64, _F1, _F2, _I1, _I1, _F2, _F1, _F1, float64,
        float64, float64, _W3, _I1,
    ),
    nogil=True,
)  # fmt: skip
def _loops(  # noqa: PLR0915 - a loop over candidates and samples
    slip: Any, rub: Any, general: bool, states: int, slip_m: Any, rub_m: Any, general_m: bool,
    states_m: int, kind: int, added: int, p: Array, term: Array, c: Array, p_m: Array,
    term_m: Array, settings: Array, per_force: float, far: float, t: Array, inputs: Array,
    held: Array, parts: Array, start: Array, v_ref: Array, noise: Array, resolution: float,
    h: float, tolerance: float, out: Array, counter: Array,
) -> None:  # fmt: skip
    """Simulate the loops that no thread has taken yet, one after the other, until none is left."""
    m = len(inputs)
    term, term_m, p_m = borrowed(term), borrowed(term_m), borrowed(p_m)
    states_owner = np.empty((6, max(states, states_m, 1)))
    u_owner, load_owner = np.zeros(INPUTS), np.empty(LOAD_ROOM)
    memory_owner, ends_owner = np.empty(MEMORY), np.empty((m, 2))
    demands_owner = np.empty(LOOP_MEMORY)
    u_owner[ENABLED] = 1.0
    loaded = general_m or term_m[0] >= 0 or term_m[1] >= 0
    u, load, memory = borrowed(u_owner), borrowed(load_owner), borrowed(memory_owner)
    demands = borrowed(demands_owner)
    ends = borrowed(ends_owner)  # the inputs at this sample and at the end of it
    z, coarse, half, fine, z_m, new = (
        borrowed(states_owner[0]), borrowed(states_owner[1]), borrowed(states_owner[2]),
        borrowed(states_owner[3]), borrowed(states_owner[4]), borrowed(states_owner[5]),
    )  # fmt: skip
    while True:
        row = row_pool.next_row(counter)
        if row >= len(p):
            states_owner[0, 0] = u_owner[0] = load_owner[0] = memory_owner[0] = 0.0  # kept alive
            ends_owner[0, 0] = demands_owner[0] = 0.0
            return
        a, b, s = borrowed(p[row]), borrowed(c[row]), borrowed(settings[row])
        q, v = start[row, 0], start[row, 1]
        memory[:] = 0.0
        z_m[:] = 0.0
        steps_left = ROOM + EACH * parts.sum()
        holds = held_demand(kind, b)
        started(rub, states, kind, a, term, b, inputs, held, 0, q, v, u, load, demands, coarse, z)
        output, last = 0.0, 0.0
        for k in range(len(t)):
            shown = q + noise[k]
            if resolution > 0.0:
                shown = resolution * np.floor(shown / resolution + 0.5)
            v_measured = 0.0 if k == 0 else (shown - last) / h
            last = shown
            if loaded:  # the loads are those under the output of the sample before
                mixed(inputs, held, k, 0.0, u)
                u[added] += per_force * output
                driven(kind, b, u, q, v, load)
            output = compensator_output(
                slip_m, rub_m, general_m, states_m, terms_factor(term_m, p_m, load), v_ref[k],
                v_measured, h, output, z_m, load, p_m, s, new,
            )  # fmt: skip
            if states_m > 0:
                z_m[:] = new
            for i in range(m):
                ends[i, 0] = inputs[i, k]
                ends[i, 1] = inputs[i, min(k + 1, len(t) - 1)]
            ends[added, 0] += per_force * output
            ends[added, 1] += per_force * output
            mixed(ends, held, 0, 0.0, u)
            if holds:
                load[DEMAND] = demanded(b, u, q, v, demands)
            driven(kind, b, u, q, v, load)
            out[0, row, k], out[1, row, k], out[2, row, k] = q, v, load[DRIVE]
            out[3, row, k], out[4, row, k] = output, v_measured
            if k == len(t) - 1 or not (abs(q - start[row, 0]) < far and abs(v) < 1e12):  # noqa: PLR2004
                out[:, row, k + 1 :] = np.nan
                break
            q, v, steps_left = passed(
                slip, rub, general, states, kind, a, term, b, ends, held, 0, parts[k],
                t[k + 1] - t[k], tolerance, False, q, v, z, coarse, half, fine, u, load, memory,
                steps_left,
            )  # fmt: skip
