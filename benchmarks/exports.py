"""The cost of a call of exported C, and the agreement of co-simulation units with the rigs."""

from __future__ import annotations

import shutil
import subprocess
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

import axis_servo
from stribeck import read
from stribeck.data.recording import Recording
from stribeck.export.code.c import c
from stribeck.export.fmu.axis import axis
from stribeck.export.fmu.build import fmu
from stribeck.export.model import Model, as_model
from stribeck.friction import law_named
from stribeck.identify.card import Card
from stribeck.rig import RIGS
from stribeck.rig.motion.drives import SLIDE
from stribeck.rig.motion.implicit import motions
from stribeck.rig.motion.track import Track, track
from stribeck.rig.rig import shown_in
from stribeck.rig.simulated import SimulatedRig
from stribeck.rig.slide_bed import SlideBed
from stribeck.rig.twin import TestBed
from stribeck.space import Array

#: Laws of growing effort.
LAWS = ("coulomb-viscous", "stribeck", "stribeck-gauss", "lugre", "maxwell-slip", "gms", "bam-m6")
#: Parameters of a slide and of a small servo, SI; a law reads its own.
VALUES = {
    "slide-bed": {
        "F_S": 144.5, "F_C": 47.9, "F_V": 958.0, "v_SS": 1.1e-3, "v_s": 1.1e-3, "sigma_0": 1e6,
        "sigma_1": 1e3, "k_spring": 968.0, "temp_slope": -0.01, "d_1": 1e-6, "ratio": 3.0,
        "tau": 2e-3, **{f"W_{i}": 12.0 for i in range(1, 5)},
        **{f"r_{i}": 2.0 for i in range(2, 5)},
    },
    "servo-pendulum": {
        "k_t": 0.41, "R": 8.6, "armature": 2e-3, "q_offset": 0.01, "F_S": 0.05, "F_C": 0.02,
        "F_V": 0.01, "v_SS": 1.0, "K_c": 0.012, "K_v": 0.01, "K_cs": 0.02, "w_s": 1.5,
        "alpha": 1.2, "K_l": 0.1, "K_ls": 0.15, "K_m": 0.1, "K_e": 0.15, "K_ms": 0.05,
        "K_es": 0.1, "K_mq": 0.05, "K_eq": 0.1,
    },
    "presliding": {
        "M": 95.1, "offset": -3.16, "F_S": 25.0, "F_C": 20.4, "F_V": 203.5, "v_s": 5e-3,
        "v_SS": 5e-3, "sigma_0": 1e6, "sigma_1": 1e3, "d_1": 1e-6,
        **{f"W_{i}": 5.0 for i in range(1, 5)}, **{f"r_{i}": 2.0 for i in range(2, 5)},
    },
}  # fmt: skip
#: Calls that are timed at once, and how often.
CALLS, TURNS = 2_000_000, 7
_TIMED = """\
#include "friction.h"
#include <math.h>
#include <stdio.h>
#include <string.h>
#include <time.h>
static volatile double sink;
static volatile double speeds[1024];
static double now(void)
{{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9 * (double)t.tv_sec + (double)t.tv_nsec;
}}
int main(void)
{{
    static friction_law law;
    static friction_compensator of;
    double sum = 0.0, t;
    int i, turn;
    for (i = 0; i < 1024; i++) speeds[i] = 0.01 * sin(0.1 * i);
    friction_init(&law);
    friction_compensator_init(&of);
    for (turn = 0; turn < {turns}; turn++) {{
        t = now();
        for (i = 0; i < {calls}; i++) sum += speeds[i & 1023];
        printf("%g ", (now() - t) / {calls}.0);
        t = now();
        for (i = 0; i < {calls}; i++) sum += exp(speeds[i & 1023]);
        printf("%g ", (now() - t) / {calls}.0);
        t = now();
        for (i = 0; i < {calls}; i++) sum += friction_force(&law, speeds[i & 1023], 1e-3);
        printf("%g ", (now() - t) / {calls}.0);
        t = now();
        for (i = 0; i < {calls}; i++) {{
            double v = speeds[i & 1023];
            sum += friction_compensate(&of, v, v, 1e-3);
        }}
        printf("%g\\n", (now() - t) / {calls}.0);
    }}
    sink = sum;
    return 0;
}}
"""


def measure(quick: bool = False) -> dict[str, Any]:
    """Nanoseconds of calls; differences of positions as shares of their range."""
    calls = [{"law": law, **_timed(law, 2 if quick else TURNS)} for law in LAWS]
    return {"calls": calls, "units": list(_agreements(quick))}


def model(rig: str, law: str) -> Model:
    """A model of known parameters."""
    kind = RIGS[rig]
    parameters = {
        kind.label(q.name): {
            "value": float(shown_in(kind, q, VALUES[rig][q.name])), "unit": kind.unit_of(q),
            "low": None, "high": None, "at_bound": None, "verdict": "identified",
        }
        for q in kind.parameters(law_named(law)) if q.name in VALUES[rig]
    }  # fmt: skip
    return as_model(Card.model_validate({
        "law": law, "rig": rig, "kind": rig, "parameters": parameters, "data": [], "software": {},
        "objective": {"name": "position_rmse", "value": 1.0, "unit": "mm", "samples": 1},
        "search": {"method": "bts", "seed": 0, "evaluations": 1, "seconds": 1.0, "ended": "budget"},
    }))  # fmt: skip


def _timed(law: str, turns: int) -> dict[str, float]:
    """Medians in ns, less the loop around a call: exp, the law, the compensator."""
    rig = "servo-pendulum" if law_named(law).loads else "slide-bed"
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for file, text in c(model(rig, law)).items():
            (folder / file).write_bytes(text)
        (folder / "timed.c").write_text(_TIMED.format(calls=CALLS, turns=turns))
        compiler = shutil.which("cc") or "cc"
        subprocess.run(  # noqa: S603 - our own
            [compiler, "-O2", "timed.c", "friction.c", "-lm", "-o", "timed"], cwd=folder, check=True
        )
        output = subprocess.run(  # noqa: S603 - the same
            [folder / "timed"], capture_output=True, text=True, check=True
        ).stdout
    loop, exp, force, added = np.median(np.loadtxt(output.splitlines()), axis=0)
    return {"exp": exp - loop, "force": force - loop, "compensate": added - loop}


def _agreements(quick: bool) -> Iterator[dict[str, Any]]:
    drive, x0 = TestBed().drive("both")
    ramp = track(drive, np.arange(0.0, drive.t[-1], 0.01), x0)
    for law in ("stribeck", "coulomb-viscous", "stribeck+temperature", "lugre", "gms"):
        inputs = np.array([0 * ramp.t, 300.0 + 0 * ramp.t, drive(ramp.t), 0 * ramp.t])
        both_ways = ramp._replace(inputs=inputs, held=np.array([0.0, 0.0, 0.0, 1.0]))
        yield _agreement("slide-bed", law, "the test bed's ramp, both ways", both_ways)
    logs = sorted(axis_servo.LOGS.glob("*.json"))[: 1 if quick else 2]
    for file in logs:
        rig = RIGS["servo-pendulum"]
        log = read(file, columns=dict(rig.columns))
        for law in ("stribeck", "bam-m4", "bam-m6"):
            yield _agreement("servo-pendulum", law, f"the goal of {file.stem}", _whole(rig, log))
    log = _emps()
    for law in ("stribeck", "lugre", "maxwell-slip"):
        rig = RIGS["presliding"]
        yield _agreement("presliding", law, "the force of the EMPS log", _whole(rig, log))


def _whole(rig: Any, log: Recording) -> Track:
    whole: Track = rig.track(log, slice(0, len(log)), float(log.position[0]), np.ones(len(log)))
    return whole


def _emps() -> Recording:
    import scipy.io  # noqa: PLC0415 - for this one log

    file = axis_servo.LOGS.parents[1] / "emps" / "DATA_EMPS.mat"
    raw = scipy.io.loadmat(file)
    t, q, u = (np.ascontiguousarray(raw[n].ravel(), dtype=float) for n in ("t", "qm", "vir"))
    return Recording(t=t, position=q, force=float(raw["gtau"][0, 0]) * u)


def _agreement(rig: str, law: str, motion: str, segment: Track) -> dict[str, Any]:
    """The difference of the unit's positions from the rig's, as a share of their range."""
    exported = model(rig, law)
    assert isinstance(exported.rig, SimulatedRig)  # noqa: S101 - every rig here is
    bed, law_itself = exported.rig, exported.law
    if isinstance(bed, SlideBed) and not law_itself.sticks:  # whose kernel is not what a unit has
        p, c = bed.split(law_itself, exported.values[None])
        expected = motions(law_itself, SLIDE, p, c, segment, bed["step"], bed["tolerance"])[0][0]
    else:
        expected = exported.rig.move(law_itself, exported.values[None], segment).position[0]
    positions, seconds = _simulated(exported, segment)
    errors = (positions - expected) / np.ptp(expected)
    return {
        "rig": rig, "law": law, "what": motion, "most": float(np.abs(errors).max()),
        "rms": float(np.sqrt(np.mean(errors**2))),
        "share": seconds / float(segment.t[-1] - segment.t[0]),
    }  # fmt: skip


def _simulated(exported: Model, segment: Track) -> tuple[Array, float]:
    """Positions of the unit, stepped from sample to sample as a master does, and seconds."""
    import fmpy  # noqa: PLC0415 - of the extra `export`
    from fmpy.fmi2 import FMU2Slave  # noqa: PLC0415 - the same

    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "axis.fmu"
        path.write_bytes(fmu(exported))
        folder = fmpy.extract(str(path), str(Path(name) / "axis"))
        description = fmpy.read_model_description(str(path))
        at = {v.name: v.valueReference for v in description.modelVariables}
        unit = FMU2Slave(
            guid=description.guid, unzipDirectory=folder, instanceName="axis",
            modelIdentifier=description.coSimulation.modelIdentifier,
        )  # fmt: skip
        unit.instantiate()
        unit.setupExperiment(startTime=0.0)
        unit.enterInitializationMode()
        start = {"position_start": segment.x0, "velocity_start": segment.v0}
        start |= dict(zip(("m", "l", "kp", "vin"), segment.given.tolist(), strict=False))
        unit.setReal([at[n] for n in start], list(start.values()))
        inputs = [v for v in axis(exported).of("input") if v.place < len(segment.inputs)]
        refs = [at[v.name] for v in inputs]
        rows = np.array([segment.inputs[v.place] for v in inputs])
        moving = [i for i, v in enumerate(inputs) if not v.fixed]
        unit.setReal(refs, rows[:, 0].tolist())
        unit.exitInitializationMode()
        t, positions = segment.t - segment.t[0], np.empty(len(segment.t))
        positions[0] = segment.x0
        slopes = np.diff(rows) / np.diff(t)
        start_time = time.perf_counter()
        for k, h in enumerate(np.diff(t)):
            unit.setReal(refs, rows[:, k].tolist())
            unit.setRealInputDerivatives(
                [refs[i] for i in moving], [1] * len(moving), slopes[moving, k].tolist()
            )
            unit.doStep(t[k], h)
            (positions[k + 1],) = unit.getReal([at["position"]])
        seconds = time.perf_counter() - start_time
        unit.terminate()
        unit.freeInstance()
    return positions, seconds


def tables(results: dict[str, Any]) -> list[str]:
    """The cost of a call, and the agreement of the units."""
    calls = "\n".join(
        f"| {r['law']} | {r['force']:.1f} | {r['force'] / r['exp']:.1f} "
        f"| {r['compensate']:.1f} | {r['compensate'] / r['exp']:.1f} |"
        for r in results["calls"]
    )
    units = "\n".join(
        f"| {r['rig']} | {r['law']} | {r['what']} | {r['most']:.1e} | {r['rms']:.1e} "
        f"| {1 / r['share']:,.0f} |"
        for r in results["units"]
    )
    timed = (
        "Exported C, `cc -O2`, a call in a loop over 1,024 speeds, the loop taken off; `exp` is "
        "the C library's."
    )
    stepped = (
        "Exported units in FMPy, from sample to sample, beside our own simulation: differences "
        "of position as shares of its range. The last column counts FMPy's and Python's time."
    )
    costs = (
        f"{timed}\n\n"
        "| law | friction / ns | in calls of exp | compensator / ns | in calls of exp |\n"
        f"|---|---:|---:|---:|---:|\n{calls}"
    )
    agreements = (
        f"{stepped}\n\n"
        "| rig | law | under | largest | RMS | times real time |\n"
        f"|---|---|---|---:|---:|---:|\n{units}"
    )
    return [costs, agreements]
