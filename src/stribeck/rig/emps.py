"""EMPS: a ball-screw slide under cascade control, a benchmark with published reference models.

Its laws are found by force balance (the rig is `BalancedRig`); with its controller known, the whole
closed loop can be simulated too, which is how the report validates a model.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numba import float64, int64, types, void

from ..compile_cache import compiled
from ..data.filtering import Filtering, even, smooth
from ..errors import InputError
from ..friction import SLIP_TYPE
from ..space import Array, Param
from .balanced import BalancedRig
from .controller import Controller
from .equation import FIRST, THIRD
from .motion.drives import JOINT, JointConstants, rows
from .motion.track import Track
from .rig import Constant, Motion, constant

if TYPE_CHECKING:
    from ..data.recording import Recording
    from ..friction import Law

_REPORT = (
    "A. Janot, M. Gautier, M. Brunot, Data Set and Reference Models of EMPS, "
    "Workshop on Nonlinear System Identification Benchmarks, Eindhoven 2019"
)

#: Integration steps between two samples of the controller. Of fourth order, and at 2 the force
#: of the identified model moves by less than 1e-5 N if they are doubled (tests/test_emps.py).
STEPS = 2
#: Refinements of the instant at which the axis stops; each gains a digit or more.
_REFINEMENTS = 40

#: Way by which a step of the implicit stepper may be off, m.
_TOLERANCE = 1e-9

#: What is added to the voltage in the cross-test log, by its name there; V whatever the name says.
PULSES = "pulses_N"

_F1 = types.Array(float64, 1, "C", readonly=True)
_F2 = types.Array(float64, 2, "C", readonly=True)
_W2 = float64[:, ::1]

#: Columns of what one candidate is simulated with, SI; the first two are its own.
_MASS, _OFFSET, _KP, _KV, _GTAU, _U_MAX, _T, _DELAY = range(8)


@dataclass(frozen=True, eq=False)
class LoopMotion(Motion):
    """A simulated motion with its acceleration, which the report compares too.

    Args:
        acceleration: (n, N).
    """

    acceleration: Array


@dataclass(frozen=True)
class RelativeErrors:
    """100 ||measured − simulated|| / ||measured||, in percent, of four signals.

    Args:
        position: Of the low-passed position.
        velocity: Of its central difference.
        acceleration: Of the central difference of that.
        force: Of the raw force.
    """

    position: float
    velocity: float
    acceleration: float
    force: float


@dataclass(frozen=True, eq=False)
class Emps(BalancedRig):
    """The slide, its motor and its controller.

    At each sample k of its clock T the controller asks for the voltage

        u_k = clip(kv (kp (q_ref,k − q_k) − (q_k − q_k−2) / 2T), ±u_max) + pulses_k

    in which the velocity is a backward difference of the mean of two positions. The voltage is
    held for T from `delay` later on; force = gtau u, and M dv/dt = force − F_f − offset.
    """

    def measured(self, recording: Recording) -> Array:
        """The force of the drive, N: gtau times the voltage, or else its column."""
        if recording.voltage is not None:
            return self["gtau"] * recording.voltage
        return super().measured(recording)

    def simulate(self, law: Law, p: Array, recording: Recording) -> LoopMotion:
        """The closed loop under a recording's command, from the state in which the log starts.

        Args:
            law: Any friction law.
            p: (n, k) parameter sets: the law's parameters, then the rig's own.
            recording: Gives the command, the pulses if there were any, and the sample times.

        Raises:
            InputError: no command, or columns that are not this law's and rig's.
        """
        if not law.static:
            raise InputError(
                f"rig {self.name}: its loop is simulated with laws without states, loads and "
                f"terms, and {law.name} has some"
            )
        p = np.atleast_2d(np.asarray(p, dtype=float))
        constants = self._candidates(law, p)
        clock, command, pulses, start = self._drive(recording)
        q, v, a, u = np.full((4, len(p), len(clock)), np.nan)
        laws = np.ascontiguousarray(p[:, : len(law.params)])
        loop(law.slip, laws, constants, command, pulses, start, STEPS, q, v, a, u)
        x, speed, acceleration, voltage = (
            np.array([np.interp(recording.t, clock, row) for row in part]) for part in (q, v, a, u)
        )
        return LoopMotion(recording.t, x, speed, self["gtau"] * voltage, acceleration)

    def controller(self) -> Controller:
        """The cascade kv (kp (q_ref − q) − v) as position and velocity gains of a joint.

        Its velocity is the axis's own, not a difference.
        """

        def track(recording: Recording) -> Track:
            t, x = recording.t, recording.position
            inputs = np.zeros((5, len(t)))
            inputs[FIRST] = x
            return Track(
                t, x, t, float(x[0]), x, np.ones(len(t)), np.zeros((3, len(t) + 1)),
                inputs=inputs, held=np.array([0.0, 0.0, 1.0, 1.0, 1.0]),
            )  # fmt: skip

        def constants(law: Law, p: Array, track: Track) -> Array:
            del track
            k = len(law.params)
            per_speed = self["gtau"] * self["kv"]
            loop = JointConstants(
                J=p[:, k],
                k_p=per_speed * self["kp"],
                k_d=per_speed,
                g_sin=0.0,
                g_cos=0.0,
                g_0=0.0 if law.directional else p[:, k + 1],
                limit=self["gtau"] * self["u_max"],
                hold=2.0 if self["delay"] > 0.5 * self["T"] else 1.0,
            )
            return rows(loop, len(p))

        return Controller(JOINT, THIRD, self["T"], _TOLERANCE, track, constants)

    def relative_errors(self, motion: LoopMotion, recording: Recording) -> list[RelativeErrors]:
        """How far each simulated motion is from the log, as the report's validation counts it.

        Args:
            motion: What `simulate` returned for this recording.
            recording: The log, evenly sampled.
        """
        log = even(recording, self.measured(recording))
        first, last = self.filtering.edges(log.rate)
        rows = slice(first, len(log.t) - last)
        measured = (*smooth(log.position, log.rate, self.filtering), log.force)
        simulated = (motion.position, motion.velocity, motion.acceleration, motion.force)
        return [
            RelativeErrors(
                *(
                    float(100 * np.linalg.norm((m - s[i])[rows]) / np.linalg.norm(m[rows]))
                    for m, s in zip(measured, simulated, strict=True)
                )
            )
            for i in range(len(motion.position))
        ]

    def _candidates(self, law: Law, p: Array) -> Array:
        k = len(law.params)
        if p.shape[1] != k + len(self.own(law)):
            raise InputError(
                f"rig {self.name}, law {law.name}: parameters are "
                f"{', '.join(q.name for q in self.parameters(law))}; got {p.shape[1]} columns"
            )
        if not 0 <= self["delay"] <= self["T"] or self["T"] <= 0:
            raise InputError(f"rig {self.name}: delay must lie between 0 and the controller's T")
        c = np.zeros((len(p), 8))
        c[:, _MASS] = p[:, k]
        if not law.directional:
            c[:, _OFFSET] = p[:, k + 1]
        c[:, _KP:] = [self[n] for n in ("kp", "kv", "gtau", "u_max", "T", "delay")]
        return c

    def _drive(self, recording: Recording) -> tuple[Array, Array, Array, Array]:
        """Clock, command and pulses at its ticks, and (position, velocity, voltage) at its first.

        The voltage is the one in force before the controller's first, without pulses.
        """
        if recording.command is None:
            raise InputError(f"{recording.label}: rig {self.name} is simulated from a command")
        t, x = recording.t, recording.position
        # A hundredth of a tick more, because logs stamp their last sample with some jitter.
        clock = t[0] + self["T"] * np.arange(np.ceil((t[-1] - t[0]) / self["T"] - 0.01) + 1)
        pulses = recording.extra.get(PULSES, np.zeros(len(t)))
        voltage = 0.0 if recording.voltage is None else recording.voltage[0] - pulses[0]
        start = np.array([x[0], (x[1] - x[0]) / (t[1] - t[0]), voltage])
        return clock, np.interp(clock, t, recording.command), np.interp(clock, t, pulses), start


@compiled()
def _acceleration(slip: Any, p: Array, mass: float, F: float, v: float, s: float) -> float:
    """Acceleration in slip in direction s under a net force; friction keeps its side of zero."""
    return (F - slip(v if s * v > 0.0 else s * 0.0, p)) / mass  # type: ignore[no-any-return]


@compiled()
def _step(
    slip: Any, p: Array, mass: float, F: float, v: float, s: float, h: float
) -> tuple[float, float]:
    """Distance moved and velocity after a step h in slip, by the classical Runge-Kutta rule."""
    a1 = _acceleration(slip, p, mass, F, v, s)
    v2 = v + 0.5 * h * a1
    a2 = _acceleration(slip, p, mass, F, v2, s)
    v3 = v + 0.5 * h * a2
    a3 = _acceleration(slip, p, mass, F, v3, s)
    v4 = v + h * a3
    a4 = _acceleration(slip, p, mass, F, v4, s)
    return h / 6 * (v + 2 * v2 + 2 * v3 + v4), v + h / 6 * (a1 + 2 * a2 + 2 * a3 + a4)


@compiled()
def _stop(
    slip: Any, p: Array, mass: float, F: float, v: float, s: float, h: float, v_end: float
) -> float:
    """When within a step h, at whose end the velocity has changed sign, the axis stops.

    False position with the Illinois rule on the length of the step.
    """
    low, high, f_low, f_high = 0.0, h, s * v, s * v_end
    for _ in range(_REFINEMENTS):
        middle = (low * f_high - high * f_low) / (f_high - f_low)
        f = s * _step(slip, p, mass, F, v, s, middle)[1]
        if abs(f) <= 1e-15 or high - low <= 1e-15:  # noqa: PLR2004 - nothing below that moves
            return middle
        if f > 0.0:
            low, f_low, f_high = middle, f, 0.5 * f_high
        else:
            high, f_high, f_low = middle, f, 0.5 * f_low
    return 0.5 * (low + high)


@compiled()
def _hold(
    slip: Any, p: Array, mass: float, F: float, q: float, v: float, span: float, steps: int
) -> tuple[float, float]:
    """Position and velocity after a constant net force F over a span, with stick at rest."""
    remaining, h = span, span / steps
    while remaining > 1e-12 * span:
        if v == 0.0:
            if slip(-0.0, p) <= F <= slip(0.0, p):
                break
            s = 1.0 if F > 0.0 else -1.0
        else:
            s = 1.0 if v > 0.0 else -1.0
        step = min(h, remaining)
        moved, after = _step(slip, p, mass, F, v, s, step)
        if s * after < 0.0 and v != 0.0:
            step = _stop(slip, p, mass, F, v, s, step, after)
            moved, after = _step(slip, p, mass, F, v, s, step)[0], 0.0
        elif (
            v == 0.0 and s * after <= 0.0
        ):  # a breakaway that leads nowhere: the law is steeper than a step
            moved, after = 0.0, 0.0
        q, v, remaining = q + moved, after, remaining - step
    return q, v


@compiled(
    void(SLIP_TYPE, _F2, _F2, _F1, _F1, _F1, int64, _W2, _W2, _W2, _W2),
)
def loop(
    slip: Any,
    laws: Array,
    constants: Array,
    command: Array,
    pulses: Array,
    start: Array,
    steps: int,
    out_q: Array,
    out_v: Array,
    out_a: Array,
    out_u: Array,
) -> None:
    """Run the loop for each candidate; position, velocity, acceleration and voltage at the ticks.

    The voltage written at a tick is the one in force there: with a delay, the one before.
    """
    for i in range(len(laws)):
        p, c = laws[i], constants[i]
        mass, T, delay = c[_MASS], c[_T], c[_DELAY]
        if not mass > 0.0:
            continue  # leaves nan
        q, v = start[0], start[1]
        q1, q2 = q - T * v, q - 2 * T * v
        before = start[2]
        for k in range(len(command)):
            u = c[_KV] * (c[_KP] * (command[k] - q) - (q - q2) / (2 * T))
            u = min(max(u, -c[_U_MAX]), c[_U_MAX])
            if not np.isfinite(u):
                break
            held, now = before + pulses[k], u + pulses[k]
            acting = held if delay > 0.0 else now
            F = c[_GTAU] * acting - c[_OFFSET]
            out_q[i, k], out_v[i, k], out_u[i, k] = q, v, acting
            if v == 0.0 and slip(-0.0, p) <= F <= slip(0.0, p):
                out_a[i, k] = 0.0
            else:
                s = np.copysign(1.0, v if v != 0.0 else F)
                out_a[i, k] = _acceleration(slip, p, mass, F, v, s)
            q1, q2 = q, q1
            if delay > 0.0:
                q, v = _hold(slip, p, mass, F, q, v, delay, steps)
            if delay < T:
                F = c[_GTAU] * now - c[_OFFSET]
                q, v = _hold(slip, p, mass, F, q, v, T - delay, steps)
            before = u


def _constants() -> tuple[Constant, ...]:
    data = "DATA_EMPS.mat"
    return (
        constant("kp", 160.18, "1/s", "gain of the position loop", data),
        constant("kv", 243.45, "V s/m", "gain of the velocity loop", data),
        constant("gtau", 35.15065188248547, "N/V", "force of the drive at a volt", data),
        constant("u_max", 10.0, "V", "saturation of the controller", "the report's simulation"),
        constant("T", 1.0, "ms", "clock of the controller, 1 kHz", "the report, section 2"),
        constant(
            "delay",
            1.0,
            "ms",
            "from sampling to the voltage acting, 0 to T",
            "the report's simulation; the logs themselves fit better with 0",
        ),
    )


_COLUMNS: dict[str, Any] = {
    "time": "t [s]",
    "position": "qm [m]",
    "command": "qg [m]",
    "voltage": "vir [V]",
    "force": {"column": "vir", "factor": "gtau", "unit": "N"},
}

EMPS = Emps(
    name="emps",
    doc="a ball-screw slide under cascade control, with published reference models",
    cite=_REPORT,
    constants=_constants(),
    params=(
        Param("M", 1.0, 1000.0, "kg", "M", doc="moving mass, the motor's inertia with it"),
        Param("offset", -100.0, 100.0, "N", "F_0", doc="constant force: amplifier offset"),
    ),
    laws=(
        "coulomb-viscous",
        "coulomb-viscous-directional",
        "stribeck",
        "stribeck-directional",
    ),
    ranges={"F_S": (0.0, 200.0), "F_C": (0.0, 200.0), "F_V": (0.0, 5000.0), "v_SS": (1e-4, 0.1)},
    shows={"position": "mm", "velocity": "mm/s", "v_SS": "mm/s"},
    labels={"F_C": "F_c", "F_V": "F_v"},
    columns=_COLUMNS,
    filtering=Filtering(edge=(0.049, 0.0)),
)
