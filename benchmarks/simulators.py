"""Exported friction in MuJoCo, beside our own simulation of the card.

A slide and a hinge of known friction, exported by `mjcf` into a file with one joint. Each is pulled
through a soft spring whose end moves slowly, coasts to a stop, is pushed by a constant force, and
is held by half of what breaks it away.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from stribeck.data.recording import Recording
from stribeck.export.model import Model, as_model
from stribeck.export.robot.mjcf import mjcf
from stribeck.export.robot.spring_pull import spring_pull
from stribeck.friction import law_named
from stribeck.identify.card import Card
from stribeck.rig import RIGS
from stribeck.rig.rig import shown_in


@dataclass(frozen=True)
class Axis:
    """An axis and its tests, SI."""

    name: str
    joint: str
    rig: str
    units: tuple[str, str]
    inertia: float
    friction: dict[str, float]
    spring: float
    pull: float
    coast: float
    push: float


AXES = (
    Axis("slide of 10 kg", "slide", "forced", ("N", "mm"), 10.0,
         {"F_S": 20.0, "F_C": 12.0, "F_V": 40.0, "v_SS": 0.01},
         spring=1000.0, pull=2e-3, coast=0.3, push=18.0),
    Axis("hinge of 0.1 kg m²", "hinge", "forced-rotary", ("N m", "mrad"), 0.1,
         {"F_S": 0.5, "F_C": 0.3, "F_V": 0.05, "v_SS": 0.05},
         spring=10.0, pull=0.01, coast=3.0, push=0.45),
)  # fmt: skip
LAWS = ("coulomb-viscous", "stribeck")
#: Options of the exported joint.
EXPORTS: dict[str, dict[str, bool]] = {
    "MuJoCo, frictionloss": {},
    "MuJoCo, frictionloss, firm": {"firm": True},
    "MuJoCo, lugre": {"lugre": True},
}
#: Seconds of a pull, of a coast or push, and of holding.
PULL, FREE, HOLD = 60.0, 30.0, 10.0
#: Steps at speed before an axis is released.
SLID = 100
FILE = """<mujoco>
  <option gravity="0 0 0"/>
  <worldbody>
    <body>
      <joint name="axis" type="{kind}" axis="0 0 1"/>
      <inertial pos="0 0 0" mass="{inertia}" diaginertia="{inertia} {inertia} {inertia}"/>
    </body>
  </worldbody>
  <actuator><general joint="axis" gainprm="{spring}" biastype="affine" biasprm="0 -{spring} 0"/>
  </actuator>
</mujoco>
"""


def measure(*, quick: bool = False) -> dict[str, Any]:
    """The motion of each axis under each law; with `quick` one axis alone."""
    import mujoco  # noqa: PLC0415 - needed for this benchmark alone

    rows = []
    for axis in AXES[: 1 if quick else None]:
        for law in LAWS:
            model = card_model(axis, law)
            rows.append({"axis": axis.name, "law": law, "who": "ours", **our_motions(axis, model)})
            for simulator, options in EXPORTS.items():
                if "lugre" in options and not mujoco.__version__ >= "4":
                    continue
                start_time = time.perf_counter()
                motions = _theirs(axis, model, options)
                motions["seconds"] = time.perf_counter() - start_time
                rows.append({"axis": axis.name, "law": law, "who": simulator, **motions})
    return {"mujoco": mujoco.__version__, "rows": rows}


def card_model(axis: Axis, law: str) -> Model:
    """The axis's friction under a law, as a card has it."""
    rig, friction = RIGS[axis.rig], {**axis.friction, "M": axis.inertia, "offset": 0.0}
    cards = {
        rig.label(q.name): {
            "value": float(shown_in(rig, q, friction[q.name])), "unit": rig.unit_of(q),
            "low": None, "high": None, "at_bound": None, "verdict": "identified",
        }
        for q in rig.parameters(law_named(law))
        if q.name in friction
    }  # fmt: skip
    return as_model(
        Card.model_validate({
            "schema": "stribeck-card/1", "law": law, "rig": axis.rig, "kind": axis.rig,
            "parameters": cards, "data": [], "software": {},
            "speeds": {"low": -axis.coast, "high": axis.coast,
                       "unit": "rad/s" if rig.rotary else "m/s"},
            "objective": {"name": "relative_error", "value": 0, "unit": "%", "samples": 1},
            "search": {"method": "none", "seed": 0, "evaluations": 0, "seconds": 0, "ended": ""},
        })
    )  # fmt: skip


def our_motions(axis: Axis, model: Model) -> dict[str, float]:
    """The axis's motions by the rig's own integrators."""
    pull = spring_pull(model.law, model.p, axis.inertia, axis.spring, axis.pull, PULL)
    coast, _ = _free(axis, model, axis.coast, 0.0, FREE)
    _, speed = _free(axis, model, 0.1 * axis.coast, axis.push, FREE)
    creep, _ = _free(axis, model, 0.0, 0.5 * model.law.levels(model.p)[1], HOLD)
    return {
        "breakaway": pull.breakaway, "jump": pull.jump, "stop": float(coast[-1]),
        "speed": float(speed[-1]), "creep": float(creep[-1]),
    }  # fmt: skip


def _free(
    axis: Axis, model: Model, v0: float, force: float, span: float
) -> tuple[np.ndarray, np.ndarray]:
    """Position and velocity of the axis alone, under a constant force."""
    t = np.arange(0.0, span, 1e-3)
    # Only its first sample counts; a position that never changes would be no recording.
    log = Recording(
        t=t, position=max(v0, 1e-6) * t, velocity=np.full(len(t), v0), command=np.zeros(len(t)),
        rotary=True, extra={"tau_ff_Nm": np.full(len(t), force)},
    )  # fmt: skip
    rig = RIGS["joint"].set(kp=0.0, kd=0.0, tolerance=1e-5)
    p = np.concatenate([model.p, [axis.inertia, 0.0, 0.0, 0.0]])
    motion = rig.simulate(model.law, p[None], log)
    return motion.position[0], motion.velocity[0]


def _theirs(axis: Axis, model: Model, options: dict[str, bool]) -> dict[str, float]:
    """The axis's motions by MuJoCo, from the exported file."""
    import mujoco  # noqa: PLC0415 - the same

    def run(spring: float, span: float, v0: float, force: float) -> tuple[Any, Any, Any]:
        text = FILE.format(kind=axis.joint, inertia=axis.inertia, spring=spring)
        model_text, _ = mjcf(model, text.encode(), "axis", **options)
        sim = mujoco.MjModel.from_xml_string(model_text.decode())
        data = mujoco.MjData(sim)
        for _ in range(SLID if v0 > 0.0 else 0):  # it has slid for a while when it is let go
            data.qvel[0] = v0
            mujoco.mj_step(sim, data)
        data.qpos[0], data.qvel[0], data.qfrc_applied[0] = 0.0, v0, force
        steps = round(span / sim.opt.timestep)
        command, x = np.empty(steps), np.empty(steps)
        for i in range(steps):
            data.ctrl[0] = command[i] = axis.pull * sim.opt.timestep * i
            mujoco.mj_step(sim, data)
            x[i] = data.qpos[0]
        return command, x, float(data.qvel[0])

    command, x, _ = run(axis.spring, PULL, 0.0, 0.0)
    stretch = command - x
    # Until the axis stands still but for its creep, by our own simulation.
    coast_time = int(np.argmax(_free(axis, model, axis.coast, 0.0, FREE)[1] <= 0.0)) * 1e-3
    _, coast, _ = run(0.0, 1.2 * coast_time, axis.coast, 0.0)
    below_static = 0.5 * model.law.levels(model.p)[1]
    _, creep, _ = run(0.0, HOLD, 0.0, below_static)
    return {
        "breakaway": axis.spring * float(stretch.max()),
        "jump": float(np.ptp(stretch[len(stretch) // 2 :])),
        "stop": float(coast[-1]),
        "speed": run(0.0, FREE, 0.1 * axis.coast, axis.push)[2],
        "creep": float(creep[-1] - creep[len(creep) // 10]) / 0.9,
    }


def tables(results: dict[str, Any]) -> list[str]:
    """One table for each axis."""
    engine = results.get("engine") or f"MuJoCo {results['mujoco']} at its own time step"
    texts = []
    for axis in AXES:
        force, length = axis.units
        lines = []
        for row in (r for r in results["rows"] if r["axis"] == axis.name):
            ours = next(
                r for r in results["rows"]
                if (r["axis"], r["law"], r["who"]) == (row["axis"], row["law"], "ours")
            )  # fmt: skip
            even = 0.02 * ours["breakaway"] / axis.spring
            jump = "slides evenly" if row["jump"] < even else f"{1e3 * row['jump']:.2f}"
            lines.append(
                f"| {row['law']} | {row['who']} | {row['breakaway']:.4g} | {jump} "
                f"| {1e3 * row['speed']:.2f} | {1e3 * row['stop']:.1f} "
                f"| {1e3 * row['creep']:.2g} |"
            )
        if lines:
            texts.append(
                f"A {axis.name}, {engine} of 2 ms.\n\n"
                f"| card | who | breaks away at / {force} | jumps by / {length} "
                f"| steady speed / {length}/s | stops after / {length} "
                f"| creeps in {HOLD:g} s / {length} |\n"
                "|---|---|---:|---:|---:|---:|---:|\n" + "\n".join(lines)
            )
    return texts
