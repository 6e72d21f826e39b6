"""A servo's logs identified by `mujoco.sysid`, as one writes it with that tool.

Coulomb and viscous friction, the rotor's inertia, both constants of the motor and an angle, from
the middle of the ranges that `servo-pendulum` has. The voltage is clipped where the tendon is.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np

mujoco: Any = import_module("mujoco")
sysid: Any = import_module("mujoco.sysid")
if not hasattr(sysid, "optimize"):  # it hides what it lacks
    raise ImportError("mujoco.sysid lacks absl-py and colorama: they come with the extra bench")

LOGS = Path(__file__).parents[2] / "shared" / "data" / "bam_xl330" / "logs"
DUTY, VOLTS = 0.00287738, 7.4
#: rad: an absolute error is smooth within it, as a least squares' residual has to be.
SMOOTH = 0.01
XML = """<mujoco>
  <option timestep="0.005" integrator="implicitfast"><flag contact="disable"/></option>
  <worldbody>
    <body name="arm">
      <joint name="shaft" axis="0 1 0"/>
      <inertial pos="0 0 -0.1" mass="0.49" diaginertia="1e-9 1e-9 1e-9"/>
    </body>
  </worldbody>
  <tendon>
    <fixed name="winding" actuatorfrclimited="true" actuatorfrcrange="-1 1">
      <joint joint="shaft" coef="1"/>
    </fixed>
  </tendon>
  <actuator>
    <general name="goal" tendon="winding" gainprm="1"/>
    <general name="position" tendon="winding" gaintype="affine" gainprm="0 -1 0"/>
    <general name="induced" joint="shaft" gaintype="affine" gainprm="0 0 -1"/>
  </actuator>
  <sensor><jointpos name="angle" joint="shaft"/></sensor>
</mujoco>"""


def _per_volt(spec: Any, p: Any) -> None:
    spec.actuator("goal").gainprm[0] = p.value[0]
    spec.actuator("position").gainprm[1] = -p.value[0]
    spec.tendon("winding").actfrcrange = [-VOLTS * p.value[0], VOLTS * p.value[0]]


def _induced(spec: Any, p: Any) -> None:
    spec.actuator("induced").gainprm[2] = -p.value[0]


def _offset(spec: Any, p: Any) -> None:
    spec.body("arm").quat = [np.cos(p.value[0] / 2), 0, np.sin(p.value[0] / 2), 0]


def _damping(spec: Any, p: Any) -> None:
    spec.joint("shaft").damping[0] = p.value[0]


def _joint(name: str) -> Callable[[Any, Any], None]:
    return lambda spec, p: setattr(spec.joint("shaft"), name, p.value[0])


#: Start, range, and what it changes of the model; N m per V is k_t / R, N m s per rad k_t² / R.
PARAMETERS: dict[str, tuple[float, float, float, Callable[[Any, Any], None]]] = {
    "frictionloss": (0.025, 0.0, 0.05, _joint("frictionloss")),
    "damping": (0.025, 0.0, 0.05, _damping),
    "armature": (1e-3, 1e-4, 1e-2, _joint("armature")),
    "per_volt": (0.1, 0.005, 1.0, _per_volt),
    "induced": (0.03, 5e-4, 1.0, _induced),
    "offset": (0.0, -0.1, 0.1, _offset),
}


def _measured() -> Any:
    spec = mujoco.MjSpec.from_string(XML)
    model, rows = spec.compile(), []
    for file in sorted(LOGS.glob("*.json")):
        log = json.loads(file.read_text(encoding="utf-8"))
        names = ("timestamp", "position", "speed", "goal_position", "torque_enable")
        t, q, v, goal, on = (np.array([float(e[n]) for e in log["entries"]]) for n in names)
        volts, times = VOLTS * DUTY * log["kp"] * on, t - t[0]
        rows.append((
            file.name, sysid.create_initial_state(model, q[:1], v[:1]),
            sysid.TimeSeries(times, np.column_stack([volts * goal, volts, on])),
            sysid.TimeSeries.from_names(times, q[:, None], model),
        ))  # fmt: skip
    return sysid.ModelSequences("servo", spec, *map(list, zip(*rows, strict=True)))


def fitted(loss: str, start: list[float] | None = None) -> dict[str, Any]:
    """The identification by `squares` or `absolute` errors, and its errors in mrad."""
    begun, sequences, rollouts = time.process_time(), _measured(), 0
    many = len(sequences.measured_rollout)
    parameters = sysid.ParameterDict()
    for name, (value, low, high, change) in PARAMETERS.items():
        parameters.add(sysid.Parameter(name, value, low, high, modifier=change))
    if start is not None:
        parameters.update_from_vector(np.array(start))

    def residuals(_p: Any, model: Any, log: Any, *_: Any, **__: Any) -> tuple[Any, Any, Any]:
        nonlocal rollouts
        rollouts += 1
        log = sysid.apply_delayed_ts_window(log, model, 0.0, 0.0)
        model = model.resample(log.times)
        r = model.data - log.data
        if loss == "absolute":
            r = np.sign(r) * np.sqrt(2 * (np.sqrt(r**2 + SMOOTH**2) - SMOOTH))
        return r / np.sqrt(len(r) * many), model, log

    cost = sysid.build_residual_fn(models_sequences=[sequences], modify_residual=residuals)
    best, _ = sysid.optimize(
        initial_params=parameters, residual_fn=cost, optimizer="scipy", verbose=False, x_scale="jac"
    )
    seconds, evaluations = time.process_time() - begun, rollouts / many
    _, models, logs = cost(best.as_vector(), best)
    errors = [m.data - n.data for ms, ns in zip(models, logs, strict=True)
              for m, n in zip(ms, ns, strict=True)]  # fmt: skip
    return {
        "absolute": 1e3 * float(np.mean([np.mean(np.abs(e)) for e in errors])),
        "squares": 1e3 * float(np.sqrt(np.mean([np.mean(e**2) for e in errors]))),
        "evaluations": round(evaluations),
        "processor_seconds": seconds,
        "x": best.as_vector().tolist(),
    }
